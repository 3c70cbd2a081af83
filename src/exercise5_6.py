#!/usr/bin/env python3
"""Exercise 5.6: paint a picture into the area between the tags.

The picture is warped onto the area, and replaces what exercise 5.5 subtracted.
"""
import aruco_program  # noqa: F401  before all else
import cv2
from aruco_ar.exercise import AREA, PICTURE, Exercise, Result
from aruco_ar.painting.paint import warp
from aruco_ar.painting.place import find_place


def paint_picture(scene):
    """Paint the picture into the area. Without an area, the frame stays as it is."""
    image, picture, area = scene.image, scene.picture, scene.area  # the area is found as in exercise 5.5
    if area is None or picture is None:
        return Result([image], scene.tags)

    # The corners of the area are the place where the corners of the picture go. If their shapes differ, the
    # picture is stretched, or cut off, or leaves a part of the area free. The mask is that of exercise 5.5.
    place = find_place(image, area, picture, scene.settings.fit)

    # The homography maps the four corners of the picture to those of the place, and straight lines to
    # straight lines. With it, the picture is warped, as by cv2.warpPerspective. Our function does this only
    # where the mask is not black. It also avoids flicker, and bends the picture as the lens of the camera
    # bends the wall.
    homography = cv2.getPerspectiveTransform(place.picture_corners, place.corners)
    warped = warp(picture, homography, place.mask, place.positions)

    # In the course, the mask is subtracted, and the warped picture is added. So it is here with an opaque
    # picture. But where the picture is transparent, or somebody stands in front of it, less is subtracted and
    # added.
    added, subtracted = scene.shares(warped, place)

    # The window is the part of the image with the area. Subtract the mask, as in 5.5: the area is black now.
    # Then add the picture, which is black everywhere else.
    window = place.window
    cv2.subtract(window, subtracted, window)
    cv2.add(window, added, window)
    return Result([image], scene.tags)


EXERCISE = Exercise('exercise5_6', paint_picture, needs=[AREA, PICTURE])

if __name__ == '__main__':
    import aruco_node
    aruco_node.run(EXERCISE)
