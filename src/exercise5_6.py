#!/usr/bin/env python3
"""Exercise 5.6: paint a picture into the area between the tags.

The picture is warped onto the area, and replaces what exercise 5.5 subtracted.
"""
import aruco_node
import cv2
from aruco_ar import area_mask
from aruco_ar.exercise import PICTURE, TRACKER, Exercise, Result
from aruco_ar.painting.fit import fit_picture
from aruco_ar.painting.paint import put_in, warp


def paint_picture(scene):
    """Paint the picture into the area. Without an area, the frame stays as it is."""
    # Find the area. The tracker does 5.2, 5.3 and 5.4 in one step: see exercise 5.5.
    tracker, image, settings = scene.tracker, scene.image, scene.settings
    area = tracker.update(scene.frame, scene.stamp)
    if area is None or scene.picture is None:
        return Result([image], tracker.tags, area)

    # The window is the part of the image that the area touches. What we paint into it is in the image.
    # A picture of another shape than the area is stretched, cut off, or leaves a part of the area free.
    window, part = area.window(image)
    corners, place = fit_picture(scene.picture, part, settings.fit)

    # The homography maps the corners of the picture to the corners of the area, and straight lines
    # to straight lines. So the area's are undistorted: as a lens without distortion would show them.
    homography = cv2.getPerspectiveTransform(corners, place.undistorted)

    # Warp the picture: cv2.warpPerspective, but only where the mask of 5.5 is not black, and bent as the real
    # lens bends lines. If the settings ask for it, people stay in front of it, and it takes the wall's light.
    mask = area_mask(window, place)
    warped = warp(scene.picture, homography, mask, place.positions)
    warped, mask = scene.on_wall(warped, mask, area, part)
    scene.hide_tags(area)

    # Subtract the mask from the window, as in 5.5, and add the picture where the window is now black:
    # cv2.add(cv2.subtract(window, mask), cv2.min(warped, mask)). A transparent picture is mixed in.
    put_in(window, warped, mask, settings.opacity)
    return Result([image], tracker.tags, area)


EXERCISE = Exercise('exercise5_6', paint_picture, needs=[TRACKER, PICTURE])

if __name__ == '__main__':
    aruco_node.run(EXERCISE)
