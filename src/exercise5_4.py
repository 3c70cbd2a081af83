#!/usr/bin/env python3
"""Exercise 5.4: put the centers in order.

Top left, top right, bottom right, bottom left: in this order the polygon is a
proper quadrilateral, whatever the order in which the tags were found.
"""
import aruco_program  # noqa: F401  it prepares NumPy and OpenCV, so it comes first
import numpy as np
from aruco_ar import fill_polygon, find_four_centers, mark_centers, order_coordinates
from aruco_ar.exercise import LENS, TAGS, Exercise, Result


def order_centers(scene):
    """Put four centers in order, and fill the quadrilateral through them."""
    tags = scene.tags                  # they were found as in exercise 5.2
    centers = find_four_centers(tags)  # as in exercise 5.3; of more than four, those farthest outside
    if centers is None:
        return Result([scene.image], tags)

    # x grows to the right and y grows down. So the sum x + y is least at the top left and greatest at the
    # bottom right. The difference y - x is least at the top right and greatest at the bottom left.
    x, y = centers[:, 0], centers[:, 1]
    total, difference = x + y, y - x
    order = [np.argmin(total), np.argmin(difference), np.argmax(total), np.argmax(difference)]
    corners = centers[order]

    # This is the course's rule. It fails if the camera rolls until the square stands on a corner. For example,
    # (50, 0), (100, 50), (50, 100) and (0, 50) have the sums 50, 150, 150, 50 and the differences -50, -50,
    # 50, 50. Now (50, 0) comes first both times, so it is chosen twice, and another center never. Then we go
    # clockwise around the middle instead, and begin with the center that lies most to the top left.
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
