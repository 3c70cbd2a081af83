#!/usr/bin/env python3
"""Exercise 5.6: paint a picture into the area between the tags.

The picture is warped onto the area, and replaces what exercise 5.5 subtracted.
"""
import aruco_program  # noqa: F401  it prepares NumPy and OpenCV, so it comes first
import cv2
from aruco_ar.exercise import AREA, PICTURE, Exercise, Result
from aruco_ar.painting.paint import warp
from aruco_ar.painting.place import find_place


def paint_picture(scene):
    """Paint the picture into the area. Without an area, the frame stays as it is."""
    image, picture, area = scene.image, scene.picture, scene.area  # the area is found as in exercise 5.5
    if area is None or picture is None:
        return Result([image], scene.tags)

    # Find out which corners of the picture go where. Usually the picture's corners go to the area's. If the
    # two differ in shape, "fit" may ask for less of the picture, or for less of the area. The window is the
    # part of the image with the area: what we change in it is changed in the image. The mask of exercise 5.5
    # is made for the window alone.
    place = find_place(image, area, picture, scene.settings.fit)
    window, mask = place.window, place.mask

    # The homography maps four corners to four corners, and straight lines to straight lines. For four pairs of
    # points, this function gives the same as cv2.findHomography in the course.
    homography = cv2.getPerspectiveTransform(place.picture_corners, place.corners)

    # Warp the picture, as by cv2.warpPerspective. Our function does this only where the mask is not black. It
    # also avoids flicker, and bends the picture as the lens of the camera bends the wall.
    warped = warp(picture, homography, mask, place.positions)

    # Not all of it may be visible: the picture may be transparent, or somebody may stand in front of it.
    mask, warped = scene.visible(warped, place)

    # Subtract the mask, as in 5.5: the area is black now. Then add the picture, which is black outside of the
    # area. The last argument is where the result goes.
    cv2.subtract(window, mask, window)
    cv2.add(window, warped, window)
    return Result([image], scene.tags)


EXERCISE = Exercise('exercise5_6', paint_picture, needs=[AREA, PICTURE])

if __name__ == '__main__':
    import aruco_node
    aruco_node.run(EXERCISE)
