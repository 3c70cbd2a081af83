"""The painted frame against the frame of a wall on which the same picture is really printed."""
import os
import time
from collections import defaultdict

import cv2
import numpy as np
from aruco_ar import Area, InputError, area_mask, load_picture
from aruco_ar.base.progress import progress, tell
from aruco_ar.settings.settings import FOREGROUNDS
from rig import PACKAGE

from benchmark.course import Course

from . import alike, grain, hidden, real_arm, standing
from .painter import Painter
from .scenes import SCENES

SECONDS = 8
JUDGED = 4       # every fourth frame is judged; the first second is left out
FIRST_S = 1.0
SIGHT = slice(30, 350), slice(60, 580)  # rows and columns of the frame around the area
SURE_LEVELS = 30  # where picture and frame differ by this much, a pixel shows how much of it was painted
PICTURE = os.path.join(PACKAGE, 'images', 'earth.jpg')
METHODS = {'course': None, 'ours': {}, '+ keep': {'foreground': 'keep'}, '+ match': {'light': 'match'},
           '+ both': {'foreground': 'keep', 'light': 'match'}}


def library():
    """(structural_similarity, rgb2lab, deltaE_ciede2000) of scikit-image. Raises InputError without it."""
    try:
        from skimage.color import deltaE_ciede2000, rgb2lab
        from skimage.metrics import structural_similarity
    except ImportError:
        raise InputError('This part needs scikit-image: sudo apt install python3-skimage') from None
    return structural_similarity, rgb2lab, deltaE_ciede2000


def likeness(painted, printed, inside):
    """(PSNR in dB, SSIM, median of the color difference CIEDE2000) where ``inside``, (h, w) bool."""
    similarity, lab, difference = library()
    grays = [cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) for image in (painted, printed)]
    _, similar = similarity(*grays, full=True)
    # Colors are compared as eyes see them, from where single pixels and their noise cannot be seen.
    colors = [lab(cv2.GaussianBlur(image, (0, 0), 2)[..., ::-1])[inside] for image in (painted, printed)]
    return hidden.psnr(painted, printed, inside), similar[inside].mean(), np.median(difference(*colors))


def kept(bare, painted, kept_image):
    """(h, w): the share of the frame in each pixel, and where it can be told.

    ``bare``: the frame. ``painted``: with the picture all over. ``kept_image``: with things left in front.
    """
    bare, painted, kept_image = (image.astype(np.float32) for image in (bare, painted, kept_image))
    contrast = bare - painted
    length = (contrast**2).sum(axis=2)
    share = ((kept_image - painted) * contrast).sum(axis=2) / np.maximum(length, 1)
    return np.clip(share, 0, 1), length > SURE_LEVELS**2


def judge_front(moment, inside, painted, kept_image):
    """(6,): sums over a frame for the intersection, union, what is painted over, front, left unpainted, wall.

    The arguments are those of kept, for a Moment, and ``inside``: (h, w), where the area is.
    """
    share, clear = kept(moment.bare, painted, kept_image)
    clear &= inside
    share, front = share[clear], moment.front[clear]
    return np.array([np.minimum(share, front).sum(), np.maximum(share, front).sum(),
                     np.maximum(front - share, 0).sum(), front.sum(),
                     np.maximum(share - front, 0).sum(), (1 - front).sum()])


FRONT_TITLE = '%-26s %5s %15s %16s' % ('foreground:=keep', 'IoU', 'painted over', 'wall left free')


def front_row(name, sums):
    """A line of the table about what is in front, for sums of judge_front."""
    return '%-26s %6.3f %10.1f %% %10.2f %%' % (
        name, sums[0] / sums[1], 100 * sums[2] / sums[3], 100 * sums[4] / sums[5])


def run_scene(scene, picture):
    """({method: [likeness of each judged frame]}, foreground's sums, {method: ms of each frame}, sights).

    For the sums, see judge_front. ``sights``: [(color difference with both, frames side by side)].
    """
    course = Course('DICT_6X6_250', picture)
    painters = {name: Painter(picture, scene.lens, **changes)
                for name, changes in METHODS.items() if changes is not None}
    scores, sums, times, sights = defaultdict(list), np.zeros(6), defaultdict(list), []
    for number, moment in enumerate(scene.moments(picture, SECONDS)):
        results = {'course': course.paint(moment.bare)[0]}
        for name, painter in painters.items():
            start = time.perf_counter()
            results[name] = painter.paint(moment.bare, moment.stamp)[1]
            times[name].append(1000 * (time.perf_counter() - start))
        if moment.stamp < FIRST_S or number % JUDGED:
            continue
        inside = area_mask(moment.bare, Area(np.float32(moment.corners), lens=scene.lens))[..., 0] == 255
        for name, result in results.items():
            scores[name].append(likeness(result, moment.printed, inside))
        sums += judge_front(moment, inside, results['ours'], results['+ keep'])
        images = moment.bare, results['course'], results['+ both'], moment.printed
        sights.append((scores['+ both'][-1][2], np.hstack([image[SIGHT] for image in images])))
    return scores, sums, times, sights


def run_clips(clips):
    """Print how much of the area keep leaves free on real clips (see clips.Clip)."""
    tell('foreground:=keep on real clips: the share of the area that is not painted\n\n'
         '%-14s %8s %8s %8s %8s' % ('clip', 'frames', 'mean', 'median', '90 %'))
    for clip in clips:
        frames, rate = clip.frames()
        painters = [Painter(load_picture(PICTURE), dictionary=clip.dictionary, ids=clip.ids,
                            foreground=foreground)
                    for foreground in FOREGROUNDS]
        shares = []
        for number, frame in enumerate(frames):
            (sight, painted), (_, kept_image) = (painter.paint(frame, number / rate) for painter in painters)
            area = sight.areas[0].area
            if area is not None:
                share, clear = kept(frame, painted, kept_image)
                clear &= area_mask(frame, area)[..., 0] == 255
                shares.append(share[clear].mean() if clear.any() else 0)
        tell('%-14s %8d %6.1f %% %6.1f %% %6.1f %%' % (
            os.path.basename(clip.path), len(shares), *(100 * np.array([
                np.mean(shares), np.median(shares), np.percentile(shares, 90)]))))


def run_arm(clips):
    """Print what keep makes of a real arm, if its clip is among the clips."""
    for clip in clips:
        if os.path.basename(clip.path) == real_arm.CLIP:
            arm, picture = real_arm.cut_out(clip.frames()[0][real_arm.FRAME]), load_picture(PICTURE)
            tell('\nAn arm, cut out of %s, that writes on a sheet from the first frame on\n\n%s'
                 % (real_arm.CLIP, FRONT_TITLE))
            for name, depth in real_arm.SHEETS:
                painters, sums = [Painter(picture, foreground=each) for each in FOREGROUNDS], np.zeros(6)
                for moment in real_arm.ArmScene(arm, depth).moments(picture, SECONDS):
                    images = [painter.paint(moment.bare, moment.stamp)[1] for painter in painters]
                    inside = area_mask(moment.bare, Area(np.float32(moment.corners)))[..., 0] == 255
                    if moment.stamp >= FIRST_S:
                        sums += judge_front(moment, inside, *images)
                tell(front_row(name, sums))


def run(chart='unit5-bench-looks.png'):
    """Judge all scenes, print the tables, and write the picture of the median and the worst frames."""
    library()
    cv2.setNumThreads(1)
    picture = cv2.convertScaleAbs(load_picture(PICTURE), alpha=0.65, beta=90)  # light, so that shadows show
    tell('\nThe painted frame against a frame with the picture printed on the wall, inside the area: PSNR in\n'
         'dB, SSIM, and the median color difference CIEDE2000 (medians over the frames)\n\n%-26s %s' % (
             '', ' '.join('%-18s' % name for name in METHODS)))
    fronts, rows, ms = [], [], defaultdict(list)
    for name, scene in progress(list(SCENES.items()), 'looks'):
        scores, sums, times, sights = run_scene(scene, picture)
        tell('%-26s %s' % (name, ' '.join('%4.1f %5.3f %5.1f  ' % tuple(np.median(scores[each], axis=0))
                                          for each in METHODS)))
        if sums[3]:
            fronts.append(front_row(name, sums))
        for each, values in times.items():
            ms[each] += values
        sights.sort(key=lambda sight: sight[0])
        rows.append(np.hstack([sights[len(sights) // 2][1], sights[-1][1]]))
    tell('\n%s\n%s' % (FRONT_TITLE, '\n'.join(fronts)))
    tell('\nmilliseconds a frame on one thread, the tracker included (median, 99 %)')
    for each, values in ms.items():
        tell('%-10s %5.2f %6.2f' % (each, np.median(values), np.percentile(values, 99)))
    standing.run()
    alike.run()
    hidden.run()
    grain.run()
    cv2.imwrite(chart, cv2.resize(np.vstack(rows), None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))
    tell('\nWrote %s: the median and the worst frame of each scene, as frame, course, ours, printed' % chart)
