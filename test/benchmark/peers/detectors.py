"""The detectors that are compared: each is a function that finds the tags in a frame."""
from functools import partial

import cv2
from aruco_ar import get_dictionary
from aruco_ar.tags.detector import SEARCHES

from benchmark.simulated.search import finder, opencv_finder

DEFAULT = 'OpenCV'  # its defaults; the others are compared with it
SUBPIX, APRILTAG, ARUCO3 = 'OpenCV, SUBPIX', 'OpenCV, APRILTAG', 'OpenCV, ArUco 3'
FAMILIES = {'DICT_APRILTAG_16H5': 'tag16h5', 'DICT_APRILTAG_25H9': 'tag25h9', 'DICT_APRILTAG_36H11': 'tag36h11'}
PUPIL = {'AprilTag 3': {}, 'AprilTag 3, whole': {'quad_decimate': 1.0}}
SHARPENING = 0.25  # AprilTag's default; pupil-apriltags rounds its own down to 0
# AprilTag's corners are counted from the corner of the top left pixel, all others from its middle. OpenCV's
# refinement is a copy of it.
HALF_PX = 0.5


def detectors(dictionary):
    """{name: function}, and {name: why there is none}.

    A function takes a frame, (h, w, 3) BGR, and returns a list of (id, (4, 2) corners); (0, 0) is the middle of
    the top left pixel. Each works on one thread. Raises InputError if there is no such dictionary.
    """
    get_dictionary(dictionary)  # raises
    found = {
        DEFAULT: opencv_finder(dictionary),
        SUBPIX: opencv_finder(dictionary, cornerRefinementMethod=cv2.aruco.CORNER_REFINE_SUBPIX),
        APRILTAG: partial(_moved, opencv_finder(
            dictionary, cornerRefinementMethod=cv2.aruco.CORNER_REFINE_APRILTAG)),
        ARUCO3: opencv_finder(dictionary, useAruco3Detection=True)}
    missing = {}
    if dictionary.upper() in FAMILIES:
        try:
            found.update((name, partial(_moved, _april_tag(FAMILIES[dictionary.upper()], **settings)))
                         for name, settings in PUPIL.items())
        except ImportError as error:
            missing['AprilTag 3'] = 'pupil-apriltags cannot be loaded: %s' % error
    found.update(('ours, ' + search, finder(search, dictionary)) for search in SEARCHES)
    return found, missing


def _moved(find, frame):
    return [(tag_id, corners - HALF_PX) for tag_id, corners in find(frame)]


def _april_tag(family, **settings):
    import pupil_apriltags  # there is none for some systems

    class Detector(pupil_apriltags.Detector):
        def __del__(self):
            """Frees nothing: its own frees the families before what uses them, and the program crashes."""

    detector = Detector(family, **settings)
    detector.tag_detector_ptr.contents.decode_sharpening = SHARPENING
    return lambda frame: [(tag.tag_id, tag.corners) for tag in
                          detector.detect(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY))]
