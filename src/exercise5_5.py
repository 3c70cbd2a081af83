#!/usr/bin/env python3
"""Exercise 5.5: subtract the area between the tags.

The area is the quadrilateral through the centers of four tags. A mask is an
image that is white where the area is and black elsewhere.
"""
import aruco_node
import cv2
from aruco_ar import area_mask
from aruco_ar.exercise import TRACKER, Exercise, Result


def subtract_area(scene):
    """The mask of the area, and the frame without the area."""
    # The tracker finds the tags (5.2), takes their centers (5.3) and puts them in order (5.4). It
    # also remembers where on the wall each tag is. So it still knows the area while tags are covered.
    tracker = scene.tracker
    area = tracker.update(scene.frame, scene.stamp)

    # White in the area, gray on its rim, where a pixel is only partly in it, and black elsewhere.
    mask = area_mask(scene.frame, area)

    # Pixel by pixel, white is 255. So a frame minus white is black, and a frame minus black is the
    # frame as it was: subtracting the mask cuts the area out.
    image = cv2.subtract(scene.frame, mask)
    return Result([mask, image], tracker.tags, area)


EXERCISE = Exercise('exercise5_5', subtract_area, needs=[TRACKER], topics=['mask', 'image'])

if __name__ == '__main__':
    aruco_node.run(EXERCISE)
