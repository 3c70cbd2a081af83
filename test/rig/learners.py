"""What the tests' learners have in common: how they find tags, and how a judge is asked about their code."""
import cv2
import numpy as np
from aruco_course.check import Shown

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)


def find(image, dictionary=DICTIONARY):
    """The tags' corners, (n, 4, 2), and their ids, (n,)."""
    gray = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    corners, ids, _ = cv2.aruco.ArucoDetector(dictionary, cv2.aruco.DetectorParameters()).detectMarkers(gray)
    if ids is None:
        return np.empty((0, 4, 2)), np.empty(0, int)
    return np.array(corners)[:, 0], ids.ravel()


def shrink(image, share=0.7, interpolation=cv2.INTER_LINEAR):
    height, width = image.shape[:2]
    return cv2.resize(image, (int(width * share), int(height * share)), interpolation=interpolation)


def gray(image):
    return cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)


def shown_by(function, views):
    """What the learner's function makes of views."""
    return [Shown(number, view, (function(view.frame.copy()),)) for number, view in enumerate(views, 1)]


def fault_of(judge, function, views):
    """What the judge says of the learner's function: a sentence, or None."""
    fault = judge(shown_by(function, views))
    return fault and str(fault)
