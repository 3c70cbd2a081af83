"""What detectors find in frames of which it is known where all tags are."""
from collections import namedtuple
from functools import lru_cache

import numpy as np
from aruco_ar import Detector
from aruco_ar.tags import detector
from aruco_ar.tags.edges import side_of
from aruco_ar.tags.tag import DICTIONARY_NAMES

from benchmark.simulated.search import opencv_finder

from . import frames

# No corner of a true tag is farther off than this part of its side, or than so many pixels.
OFF = 0.15, 2.0
TAGGED = 'tags'  # the kind of frames with tags

# What a detector finds in a frame. ``kind``: of the frame. ``is_true``: whether it has a tag with that ``id``.
Finding = namedtuple('Finding', 'kind dictionary id likeness confidence is_true')


def is_true(tag_id, corners, truth):
    """Whether there is such a tag in the frame; ``truth``: {id: (4, 2) pixels}, all that are in it."""
    if tag_id not in truth:
        return False
    side = side_of(truth[tag_id][None])[0]
    return np.linalg.norm(truth[tag_id] - corners, axis=1).max() < max(OFF[0] * side, OFF[1])


class Finder:
    """Finds tags of all dictionaries in frames: by ours, and by OpenCV's detector as it comes.

    All dictionaries are read in the same quadrilaterals, so these are found only once in each frame.
    """

    def __init__(self, confidence):
        """``confidence``: the least one of ours."""
        self._frame, self._quads, self._find_quads = None, {}, detector.find_quads
        detector.find_quads = self._known_quads
        self._ours = {name: Detector(name, confidence=confidence) for name in DICTIONARY_NAMES}
        self._opencv = {name: opencv_finder(name) for name in DICTIONARY_NAMES}

    def ours(self, kind, frame, dictionary, truth):
        """The Findings of our detector in a frame."""
        if frame is not self._frame:
            self._frame, self._quads = frame, {}
        return [Finding(kind, dictionary, tag.id, tag.likeness, tag.confidence,
                        is_true(tag.id, tag.corners, truth))
                for tag in self._ours[dictionary].detect(frame)]

    def _known_quads(self, image, *how):
        if (image.shape, how) not in self._quads:
            self._quads[image.shape, how] = self._find_quads(image, *how)
        return self._quads[image.shape, how]

    def opencv(self, frame, dictionary):
        """The ids that OpenCV's detector finds in a frame."""
        return [tag_id for tag_id, _ in self._opencv[dictionary](frame)]


@lru_cache(maxsize=1)
def finder_of(confidence):
    """The Finder of this process."""
    return Finder(confidence)


def tagged(finder, dictionary, number):
    """The Findings in one of the frames with tags of a dictionary."""
    frame, truth = frames.tag_frame(number, dictionary)
    return finder.ours(TAGGED, frame, dictionary, truth)
