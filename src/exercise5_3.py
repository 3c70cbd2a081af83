#!/usr/bin/env python3
"""Exercise 5.3: extract the centers of the tags.

The centers will be the corners of the area that we paint into. The polygon
through them depends on their order. If we take them in the order in which the
tags were found, the polygon usually crosses itself.
"""
import aruco_program  # noqa: F401  it prepares NumPy and OpenCV, so it comes first
import cv2
from aruco_ar.exercise import TAGS, Exercise, Result
from aruco_ar.painting.marks import BLACK, PURPLE, SHIFT, YELLOW, fixed_point


def extract_centers(scene):
    """Mark the centers, and fill the polygon through them, in the order in which they were found."""
    tags = scene.tags  # they were found as in exercise 5.2

    # A tag's center is where its diagonals cross. A camera without distortion keeps straight lines
    # straight. So this point shows the center of the real tag. The mean of the corners, which the
    # course takes, does not if the tag is slanted.
    centers = [tag.center for tag in tags]

    image = scene.image
    if len(centers) >= 3:  # fewer make no polygon
        cv2.fillPoly(image, [fixed_point(centers)], PURPLE, cv2.LINE_AA, SHIFT)
    for center in centers:
        point = fixed_point(center).tolist()
        cv2.circle(image, point, 5 << SHIFT, BLACK, -1, cv2.LINE_AA, SHIFT)
        cv2.circle(image, point, 4 << SHIFT, YELLOW, -1, cv2.LINE_AA, SHIFT)
    return Result([image], tags)


EXERCISE = Exercise('exercise5_3', extract_centers, needs=[TAGS])

if __name__ == '__main__':
    import aruco_node
    aruco_node.run(EXERCISE)
