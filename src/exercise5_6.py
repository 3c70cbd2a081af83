#!/usr/bin/env python3
"""Exercise 5.6: paint a picture into the area between the tags.

The picture is warped, so that its corners fall on the corners of the area.
Then it takes the place of what exercise 5.5 subtracted.
"""
import aruco_node
import cv2
import numpy as np
from aruco_ar import area_mask
from aruco_ar.exercise import PICTURE, TRACKER, Exercise, Result
from aruco_ar.painting.fit import fit_picture
from aruco_ar.painting.paint import put_in, warp


def paint_picture(scene):
    """The frame with the picture in the area. Where no area is known, it is the frame itself."""
    # Find the area: 5.2, 5.3 and 5.4 in one, see exercise 5.5.
    tracker, image, settings = scene.tracker, scene.image, scene.settings
    area = tracker.update(scene.frame, scene.stamp)
    if area is None or scene.picture is None:
        return Result([image], tracker.tags, area)

    # A picture of another shape than the area is stretched, or it loses a part of one of the two.
    picture, place = fit_picture(scene.picture, area, settings.fit)

    # From here on, we work on a window: the part of the image that the area touches. It is not a
    # copy. What we paint into the window is in the image.
    window, place = place.window(image)

    # The homography maps each pixel of the picture to its place: corners to corners, lines to lines.
    height, width = picture.shape[:2]
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    homography = cv2.getPerspectiveTransform(corners, place.corners)

    # Warp the picture. This is cv2.warpPerspective, but only where the mask of 5.5 is not black.
    mask = area_mask(window, place)
    warped = warp(picture, homography, mask)

    # Subtract the mask from the window, as in 5.5, and add the picture where there is now a hole:
    # cv2.add(cv2.subtract(window, mask), cv2.min(warped, mask)). A picture that lets the frame
    # shine through is mixed with it instead.
    put_in(window, warped, mask, settings.opacity)
    return Result([image], tracker.tags, area)


EXERCISE = Exercise('exercise5_6', paint_picture, needs=[TRACKER, PICTURE])

if __name__ == '__main__':
    aruco_node.run(EXERCISE)
