"""What each look costs beyond ours alone. All paint the same frames in turn: noise of the machine cancels."""
import os
import time
from itertools import islice

import cv2
import numpy as np
from aruco_ar import load_picture
from aruco_ar.base.progress import tell
from rig import PACKAGE

from .painter import Painter
from .scenes import SCENES

LOOKS = {'ours alone': {}, 'foreground:=keep': {'foreground': 'keep'}, 'light:=match': {'light': 'match'},
         'grain:=match': {'grain': 'match'}, 'tags:=hide': {'tags': 'hide'}}
CHOSEN = 'plain', 'a person walks past'
BENT = 'lens, k1 = -0.3'
SECONDS = 12
LEFT_OUT = 15  # so many frames at first are left out, in which all is new
MOST = 300     # frames of a clip
PICTURE = os.path.join(PACKAGE, 'images', 'earth.jpg')
ROW = '%-26s %-18s %7s %7s %7s'
HEAD = ('\nWhat each look costs beyond ours alone, from frame to painted frame: milliseconds of the\n'
        'processor per frame, on one thread\n\n' + ROW % ('', '', 'mean', 'median', '99 %'))


def measure(title, painters, frames):
    """Print the milliseconds of the first of painters, by their names, and what the others take beyond it.

    ``frames``: of (frame, stamp).
    """
    times, names = [], list(painters)
    for number, (frame, stamp) in enumerate(frames):
        took = {}
        for turn in range(len(names)):  # what comes first finds the frame in no cache
            name = names[(number + turn) % len(names)]
            start = time.thread_time()  # without what other programs take
            painters[name].paint(frame, stamp)
            took[name] = 1000 * (time.thread_time() - start)
        times.append([took[name] for name in names])
    alone, *others = np.array(times[LEFT_OUT:]).T
    for name, values in zip(names, [alone, *(other - alone for other in others)]):
        found = values.mean(), np.median(values), np.percentile(values, 99)
        tell(ROW % (title, name, *('%.2f' % value for value in found)))
        title = ''


def run():
    """Print the table of simulated scenes."""
    cv2.setNumThreads(1)
    picture = load_picture(PICTURE)
    tell(HEAD)
    for name in CHOSEN:
        measure(name, {look: Painter(picture, **changes) for look, changes in LOOKS.items()},
                _seen(SCENES[name], picture))
    measure(BENT, {'ours alone': Painter(picture), 'lens:=correct': Painter(picture, SCENES[BENT].lens)},
            _seen(SCENES[BENT], picture))


def run_clips(clips):
    """Print the table of real clips: see clips.Clip."""
    cv2.setNumThreads(1)
    picture = load_picture(PICTURE)
    tell(HEAD)
    for clip in clips:
        frames, rate = clip.frames()
        measure('%s, %d x %d' % (os.path.basename(clip.path), *frames[0].shape[1::-1]),
                {look: Painter(picture, dictionary=clip.dictionary, ids=clip.ids, **changes)
                 for look, changes in LOOKS.items()},
                ((frame, number / rate) for number, frame in enumerate(islice(frames, MOST))))


def _seen(scene, picture):
    """The frames of a Scene, and their stamps."""
    return ((moment.bare, moment.stamp) for moment in scene.moments(picture, SECONDS))
