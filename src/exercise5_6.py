#!/usr/bin/env python3
"""Exercise 5.6: paint a picture into the area between the tags.

The picture is warped so that its corners fall on the area's corners, and
added where the area was subtracted.
"""
from aruco_ar import find_area, overlay
from aruco_ar.node import run


def paint_picture(frame, tags, picture):
    """The frame with the picture in the area; the frame itself where there is none."""
    area = find_area(tags)
    return overlay(frame, picture, area)


if __name__ == '__main__':
    run('exercise5_6', paint_picture, picture=True)
