#!/usr/bin/env python3
"""Exercise 5.4: put the centers in order.

Top left, top right, bottom right, bottom left: in this order the polygon is a
proper quadrilateral, whatever the order in which the tags were found.
"""
from aruco_ar import fill_polygon, find_four_centers, mark_centers, order_coordinates
from aruco_node import run


def order_centers(frame, tags):
    """Fill the quadrilateral through four centers, put in order."""
    centers = find_four_centers(tags)
    if centers is None:
        return frame
    corners = order_coordinates(centers)
    return mark_centers(fill_polygon(frame, corners), corners)


if __name__ == '__main__':
    run('exercise5_4', order_centers)
