#!/usr/bin/env python3
"""Exercise 5.3: extract the centers of the tags.

A tag's center is where its diagonals cross. The polygon through the centers
depends on the order of the points: in the order in which the tags were found
it usually crosses itself.
"""
from aruco_ar import fill_polygon, mark_centers
from aruco_node import run


def extract_centers(frame, tags):
    """Mark the centers, and fill the polygon through them as they come."""
    centers = [tag.center for tag in tags]
    return mark_centers(fill_polygon(frame, centers), centers)


if __name__ == '__main__':
    run('exercise5_3', extract_centers)
