"""A real wall that is remembered is not found where it is not: in frames of other walls, seen from any side."""
import glob
import os
import tempfile
from functools import partial
from itertools import cycle, islice

import cv2
import numpy as np
from aruco_ar.base.progress import progress, tell
from rig import PACKAGE

from .remembered import Searching, teach

PHOTOS = os.path.join(PACKAGE, '..', 'shared', 'photos')
FRAMES = 10000
OF_EACH = 60          # at most so many frames of a clip are shown, in ever new ways
WIDTH, HEIGHT = 640, 480
STEP_S = 1.0          # from frame to frame, so that each of them is searched
NEARER = 0.6, 1.3     # so much larger or smaller a frame is shown
ASKEW = 0.15          # and its corners moved at random, by so much of its width and height
BRIGHTNESS = 0.6, 1.2
MIRRORED = 0.3        # share of frames that are mirrored


def changed(frame, random):
    """A frame as if it were seen from another side, in another light."""
    height, width = frame.shape[:2]
    corners = np.float32([[0, 0], [width, 0], [width, height], [0, height]])
    off = random.uniform(-ASKEW, ASKEW, (4, 2)) * [width, height]
    # The whole frame, at its own size, would be WIDTH wide.
    places = WIDTH / width * (corners * random.uniform(*NEARER) + off)
    warped = cv2.warpPerspective(frame, cv2.getPerspectiveTransform(corners, np.float32(places)),
                                 (WIDTH, HEIGHT), flags=cv2.INTER_AREA, borderMode=cv2.BORDER_REFLECT)
    if random.rand() < MIRRORED:
        warped = warped[:, ::-1]
    return cv2.convertScaleAbs(warped, alpha=random.uniform(*BRIGHTNESS))


def photos():
    """The photos that are shared beside the package, (h, w, 3) BGR."""
    return [cv2.imread(path) for ending in ('jpg', 'png')
            for path in sorted(glob.glob(os.path.join(PHOTOS, '*.' + ending)))]


def show(searching, frames, count, random):
    """In how many frames a wall was found, though they show others.

    ``searching``: a function that makes a Searching for the wall. ``frames``: those of other walls, which are
    shown ``count`` times in all, never twice in the same way.
    """
    found, tracker = 0, searching()
    for number, frame in enumerate(progress(list(islice(cycle(frames), count)), 'other walls')):
        if not np.isnan(tracker.corners(changed(frame, random), STEP_S * number)).any():
            found, tracker = found + 1, searching()
    return found


def run(clips, count=FRAMES):
    """Print the table for some Clips. The wall of each is looked for in frames of those with other tags."""
    print('A wall that is remembered, looked for in frames of other walls: from clips and photos, as if seen\n'
          'from another side, in another light\n\n%-12s %8s %6s' % ('', 'frames', 'found'))
    random, walls, shown = np.random.RandomState(0), [], []
    with tempfile.TemporaryDirectory() as folder:
        for number, clip in enumerate(clips):
            frames, rate = clip.frames()
            of_clip = os.path.join(folder, str(number))
            os.mkdir(of_clip)
            path, _, _ = teach(clip, frames, rate, of_clip)
            if path is not None:
                walls.append((clip, path))
            shown += [(clip.dictionary, frame) for frame in frames[::-(-len(frames) // OF_EACH)]]
        shown += [('', photo) for photo in photos()]
        random.shuffle(shown)
        for clip, path in walls:
            others = [frame for dictionary, frame in shown if dictionary != clip.dictionary]
            found = show(partial(Searching, clip, path), others, count // len(walls), random)
            tell('%-12s %8d %6d' % (os.path.basename(clip.path), count // len(walls), found))
