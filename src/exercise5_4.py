#!/usr/bin/env python3
"""Exercise 5.4: put the centers in order.

Top left, top right, bottom right, bottom left: in this order the polygon is a
proper quadrilateral, whatever the order in which the tags were found.
"""
import aruco_program  # noqa: F401  before all else
import numpy as np
from aruco_ar import fill_polygon, find_four_centers, mark_centers, order_coordinates
from aruco_ar.exercise import LENS, TAGS, Exercise, Result


def order_centers(scene):
    """Put four centers in order, and fill the quadrilateral through them."""
    tags = scene.tags                  # exercise 5.2
    centers = find_four_centers(tags)  # exercise 5.3; of more than four, those with the largest area
    if centers is None:
        return Result([scene.image], tags)

    # x grows to the right and y grows down. So the sum x + y is least at the top left and greatest at the
    # bottom right. The difference y - x is least at the top right and greatest at the bottom left.
    x, y = centers.T
    total, difference = x + y, y - x
    order = [np.argmin(total), np.argmin(difference), np.argmax(total), np.argmax(difference)]
    corners = centers[order]

    # This is the course's rule. It fails if the camera rolls until the square stands on a corner. Then two
    # corners have nearly the same sum, and one of them can also have the least or the greatest difference. So
    # it is chosen twice, and another one never. In that case we go clockwise around the middle of the four
    # instead, and begin with the one that is best called the top left.
    if len(set(order)) < 4:
        corners = order_coordinates(centers)

    # Draw the polygon and the centers as in exercise 5.3. If the camera is calibrated, the sides of the
    # polygon are bent as its lens bends straight lines.
    image = mark_centers(fill_polygon(scene.image, corners, lens=scene.lens), corners)
    return Result([image], tags)


EXERCISE = Exercise('exercise5_4', order_centers, needs=[TAGS, LENS])

if __name__ == '__main__':
    import aruco_node
    aruco_node.run(EXERCISE)
