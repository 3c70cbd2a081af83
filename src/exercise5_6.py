#!/usr/bin/env python3
"""Exercise 5.6: paint a picture into the area between the tags.

The picture is warped so that its corners fall on the area's corners, the
centers of the tags, and takes the place of what 5.5 subtracted. How a picture
of another shape is fitted, and how much of it is mixed with the frame, the
parameters ~fit and ~opacity say.

The area comes from aruco_ar.Tracker: it stays on the wall while tags are
covered, and its top is where the tags' own tops are.
"""
from aruco_ar import overlay
from aruco_node import run


def paint_picture(frame, area, picture, fit, opacity):
    """The frame with the picture in the area; the frame itself where there is no area."""
    return overlay(frame, picture, area, fit=fit, opacity=opacity, out=frame)  # right into the frame: no copy


if __name__ == '__main__':
    run('exercise5_6', paint_picture)
