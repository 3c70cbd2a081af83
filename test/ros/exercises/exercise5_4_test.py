#!/usr/bin/env python3
"""Exercise 5.4: the polygon through the ordered centers is a proper quadrilateral."""
import numpy as np
from aruco_ar.painting.marks import PURPLE
from rig.nodes.replay import ReplayTest, main, split


class Exercise54(ReplayTest):
    results = ['/exercise5_4/image']

    def test_the_whole_area_is_filled_and_nothing_else(self):
        for moment in self.with_area:
            image = moment.results[0].copy()
            purple = np.all(image == PURPLE, axis=2)
            inside, outside = split(moment.area, image.shape)
            for corner in moment.area.corners:  # the dots on the corners cover it
                x, y = np.int32(np.round(corner))
                for mask in (inside, outside):
                    mask[y - 8:y + 9, x - 8:x + 9] = False
            self.assertTrue(purple[inside].all())
            np.testing.assert_array_equal(image[outside], moment.frame[outside])
            self.assert_corners(moment, moment.results[0], PURPLE, 1.5)

    def test_without_four_tags_the_frame_is_unchanged(self):
        self.assert_untouched_without_area('/exercise5_4/image')


if __name__ == '__main__':
    main('exercise5_4_test', Exercise54)
