#!/usr/bin/env python3
"""Exercise 5.5: subtract the area between the tags.

The area is the quadrilateral through the centers of four tags. It comes from
aruco_ar.Tracker, which keeps it where it is on the wall while tags are covered.

The mask is white where the area is and black elsewhere. A frame minus white
is black, a frame minus black is the frame: subtracting the mask cuts the area
out.
"""
from aruco_ar import area_mask, subtract
from aruco_node import run


def subtract_area(frame, area):
    """The mask of the area, and the frame without the area."""
    mask = area_mask(frame, area)
    return mask, subtract(frame, mask)


if __name__ == '__main__':
    run('exercise5_5', subtract_area, topics=['mask', 'image'])
