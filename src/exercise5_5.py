#!/usr/bin/env python3
"""Exercise 5.5: subtract the area between the tags.

The area is the quadrilateral through the centers of four tags. A mask is an
image that is white where the area is and black elsewhere.
"""
import aruco_program  # noqa: F401  it prepares NumPy and OpenCV, so it comes first
import cv2
from aruco_ar import area_mask
from aruco_ar.exercise import AREA, Exercise, Result


def subtract_area(scene):
    """Make the mask of the area, and subtract it from the frame."""
    # The area is found as in the exercises before: tags (5.2), centers (5.3), and their order (5.4). But what
    # the node calls for that, a tracker, also remembers the place of each tag on the wall. So it knows the area
    # even while tags are covered.
    area = scene.area

    # The mask is white in the area and black elsewhere. On the area's rim, where a pixel is only
    # partly in the area, it is gray.
    mask = area_mask(scene.frame, area)

    # White is 255, the largest value, and no result is below 0. So a pixel minus white is black. Black
    # is 0, so a pixel minus black is unchanged. Subtracting the mask therefore cuts the area out.
    image = cv2.subtract(scene.frame, mask)
    return Result([mask, image], scene.tags)


EXERCISE = Exercise('exercise5_5', subtract_area, needs=[AREA], topics=['mask', 'image'])

if __name__ == '__main__':
    import aruco_node
    aruco_node.run(EXERCISE)
