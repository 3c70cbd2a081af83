#!/usr/bin/env python3
"""Exercise 5.3: the centers are marked, and the polygon through them in the order of detection is filled."""
import cv2
import numpy as np
from aruco_ar.painting.marks import PURPLE
from rig.nodes.replay import ReplayTest, main


class Exercise53(ReplayTest):
    results = ['/exercise5_3/image']

    def test_centers_are_marked_within_a_pixel_of_the_truth(self):
        for moment in self.moments:
            for tag in moment.tags:
                found = dot_center(moment.results[0], tag.center)
                self.assertLess(np.linalg.norm(found - tag.center), 1.0, tag.id)

    def test_the_polygon_crosses_itself(self):
        crossed = 0
        for moment in self.with_area:
            purple = np.all(moment.results[0] == PURPLE, axis=2)
            whole = cv2.contourArea(moment.area.corners)
            corners = moment.area.corners
            outside = cv2.fillConvexPoly(np.zeros(purple.shape, np.uint8),
                                         np.int32(np.round(corners)), 255)
            outside = cv2.dilate(outside, np.ones((5, 5))) == 0
            self.assertFalse(np.any(purple & outside))
            # The crossed polygon leaves two of the four triangles at the middle empty.
            self.assertGreater(purple.sum(), 0.3 * whole)
            crossed += purple.sum() < 0.7 * whole
        self.assertGreater(crossed, len(self.with_area) // 2)

    def test_fewer_tags_are_marked_too(self):
        few = [moment for moment in self.moments if 0 < len(moment.tags) < 3 and moment.cut]
        self.assertTrue(few)
        for moment in few:
            for tag in moment.tags:
                dot_center(moment.results[0], tag.center)


def dot_center(image, near):
    """The middle of the yellow dot near a point."""
    left, top = np.int32(near) - 8
    part = image[top:top + 17, left:left + 17].astype(int)
    yellow = np.clip(np.minimum(part[..., 1], part[..., 2]) - part[..., 0] - 100, 0, None)
    yellow = np.where((part[..., 0] < 80), yellow, 0)
    assert yellow.sum() > 0, 'there is no dot near %s' % near
    y, x = np.mgrid[0:17, 0:17]
    return np.array([left + (x * yellow).sum() / yellow.sum(), top + (y * yellow).sum() / yellow.sum()])


if __name__ == '__main__':
    main('exercise5_3_test', Exercise53)
