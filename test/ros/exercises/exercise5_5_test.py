#!/usr/bin/env python3
"""Exercise 5.5: the mask is white exactly in the area, and the image is black there."""
import numpy as np
from rig.nodes.replay import ReplayTest, main, split


class Exercise55(ReplayTest):
    results = ['/exercise5_5/mask', '/exercise5_5/image']
    transport = 'raw'
    count = 6  # all frames of the short bag

    def test_the_mask_is_white_in_the_area_and_black_elsewhere(self):
        for moment in self.with_area:
            mask = moment.results[0]
            inside, outside = split(moment.area, mask.shape)
            self.assertTrue(np.all(mask[inside] == 255))
            self.assertTrue(np.all(mask[outside] == 0))

    def test_the_image_is_the_frame_without_the_area(self):
        for moment in self.with_area:
            image = moment.results[1]
            inside, outside = split(moment.area, image.shape)
            self.assertFalse(image[inside].any())
            np.testing.assert_array_equal(image[outside], moment.frame[outside])
            self.assert_corners(moment, image, (0, 0, 0), 1.5)

    def test_image_and_mask_fit_together(self):
        for moment in self.moments:
            mask, image = moment.results
            np.testing.assert_array_equal(image, np.maximum(moment.frame.astype(int) - mask, 0))


if __name__ == '__main__':
    main('exercise5_5_test', Exercise55)
