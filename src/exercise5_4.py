#!/usr/bin/env python3
"""Exercise 5.4: put the centers in order.

Top left, top right, bottom right, bottom left: in this order the polygon is a
proper quadrilateral, whatever the order in which the tags were found.
"""
import aruco_node
from aruco_ar import fill_polygon, find_four_centers, mark_centers, order_coordinates
from aruco_ar.exercise import LENS, Exercise, Result, find_tags


def order_centers(scene):
    """Put four centers in order, and fill the quadrilateral through them."""
    tags = find_tags(scene)            # exercise 5.2
    centers = find_four_centers(tags)  # exercise 5.3; of more than four, those with the largest area
    if centers is None:
        return Result([scene.image], tags)

    # The sum x + y is least at the top left and greatest at the bottom right. The difference y - x
    # is least at the top right and greatest at the bottom left. This is the course's rule. It fails
    # for a square that stands on its corner. Our function handles that case, too.
    corners = order_coordinates(centers)

    # Draw the polygon and the centers as in exercise 5.3. If the camera is calibrated, the sides of the
    # polygon are bent as its lens bends straight lines.
    image = mark_centers(fill_polygon(scene.image, corners, lens=scene.lens), corners)
    return Result([image], tags)


EXERCISE = Exercise('exercise5_4', order_centers, needs=[LENS])

if __name__ == '__main__':
    aruco_node.run(EXERCISE)
