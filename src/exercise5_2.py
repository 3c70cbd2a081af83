#!/usr/bin/env python3
"""Exercise 5.2: detect the tags.

A tag is a square with a pattern that holds a number, its id. For each tag the
detector gives the id and four corners, clockwise from the tag's own top left.
"""
from aruco_ar import mark_tags
from aruco_node import run


def detect(frame, tags):
    """Outline every tag, mark its first corner, and write its id."""
    return mark_tags(frame, tags)


if __name__ == '__main__':
    run('exercise5_2', detect)
