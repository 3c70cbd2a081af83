#!/usr/bin/env python3
"""Exercise 5.6: paint a picture into the area between the tags.

The picture is warped so that its corners fall on the area's corners, the
centers of the tags, and takes the place of what 5.5 subtracted.
"""
from aruco_ar import overlay
from aruco_ar.node import run


def paint_picture(frame, area, picture):
    """The frame with the picture in the area; the frame itself where there is none."""
    return overlay(frame, picture, area, out=frame)


if __name__ == '__main__':
    run('exercise5_6', paint_picture, takes=['area', 'picture'])
