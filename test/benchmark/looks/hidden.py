"""The wall with its tags hidden against the same wall without tags."""
import cv2
import numpy as np
from aruco_ar.base.progress import tell

from .painter import Painter
from .scenes import SCENES

SECONDS = 8
JUDGED = 4    # every fourth frame is judged
CHOSEN = ('plain', 'a person walks past', 'a shadow moves across', 'light falls off, changes',
          'lens, k1 = -0.3', 'motion blur of 9 px', 'noise of 5', 'all at once')


def tags_in(frame):
    """How many tags OpenCV finds."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
    return len(cv2.aruco.ArucoDetector(dictionary).detectMarkers(frame)[0])


def psnr(image, truth, where):
    """The peak signal-to-noise ratio in dB of an image where ``where``, (h, w) bool."""
    error = np.mean((image[where].astype(float) - truth[where])**2)
    return 10 * np.log10(255**2 / max(error, 1e-3))


def run():
    """Print the table."""
    tell('\ntags:=hide, with a picture that cannot be seen (opacity 0), from the first frame on: how many\n'
         'tags OpenCV finds in all frames, and PSNR in dB where the tags and their paper were, against\n'
         'the same wall without tags (median, worst frame)\n\n'
         '%-26s %8s %8s %14s' % ('', 'show', 'hide', 'PSNR'))
    black = np.zeros((60, 90, 3), np.uint8)
    for name in CHOSEN:
        scene, found, decibels = SCENES[name], np.zeros(2, int), []
        painters = [Painter(black, scene.lens, opacity=0.0, foreground='keep', tags=tags)
                    for tags in ('show', 'hide')]
        for number, moment in enumerate(scene.moments(black, SECONDS)):
            shown, hidden = (painter.paint(moment.bare, moment.stamp)[1] for painter in painters)
            if number % JUDGED:
                continue
            found += tags_in(shown), tags_in(hidden)
            where = np.any(moment.bare != moment.untagged, axis=2) & (moment.front == 0)
            decibels.append(psnr(hidden, moment.untagged, where))
        tell('%-26s %8d %8d %7.1f %6.1f' % (name, *found, np.median(decibels), min(decibels)))
