#!/usr/bin/env python3
"""Exercise 5.2: detect the tags.

A tag is a black square. Light cells inside of it make a pattern that stands for
a number, its id. For each tag, the detector returns the id and four corners,
clockwise from the tag's own top left.
"""
import aruco_program  # noqa: F401  it prepares NumPy and OpenCV, so it comes first
import cv2
from aruco_ar import Detector
from aruco_ar.exercise import Exercise, Result
from aruco_ar.painting.marks import GREEN, RED, SHIFT, fixed_point, write_text


def detect_tags(scene):
    """Outline every tag, mark its first corner, and write its id."""
    # The detector's settings are parameters of the node: "dictionary", "ids", "search", "correction",
    # "confidence", "min_side" and "border". rosrun unit5 exercise5_2.py --help explains them. The dictionary
    # lists the patterns of all tags and their ids.
    detector = Detector(**scene.settings.of_detector())

    # The detector calls cv2.aruco.ArucoDetector.detectMarkers, which searches for dark quadrilaterals
    # and reads the cells inside. Then the detector moves the corners onto the edges of the tag, to a
    # small fraction of a pixel.
    tags = detector.detect(scene.frame)

    # Corners are fractions of a pixel, but OpenCV's drawing functions take whole numbers. With the
    # argument SHIFT, the unit of these numbers is 1 / 2**SHIFT pixel, so 4 << SHIFT is 4 pixels.
    image = scene.image
    for tag in tags:
        corners = fixed_point(tag.corners)
        cv2.polylines(image, [corners], True, GREEN, 2, cv2.LINE_AA, SHIFT)
        cv2.circle(image, corners[0].tolist(), 4 << SHIFT, RED, -1, cv2.LINE_AA, SHIFT)
    for tag in tags:  # after all outlines, so that no outline crosses an id
        write_text(image, str(tag.id), tag.center)
    return Result([image], tags)


EXERCISE = Exercise('exercise5_2', detect_tags)

if __name__ == '__main__':
    import aruco_node
    aruco_node.run(EXERCISE)
