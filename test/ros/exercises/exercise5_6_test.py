#!/usr/bin/env python3
"""Exercise 5.6: the Earth is in the area, with the wall around it."""
import numpy as np
import rospkg
from aruco_ar import load_picture, overlay
from rig.nodes.replay import ReplayTest, main, split

SPACE = (9, 5, 4)  # the color along the rim of earth.jpg


class Exercise56(ReplayTest):
    results = ['/exercise5_6/image']

    def test_the_earth_is_inside_and_the_wall_outside(self):
        earth = load_picture(rospkg.RosPack().get_path('unit5') + '/images/earth.jpg')
        for moment in self.with_area:
            image = moment.results[0]
            inside, outside = split(moment.area, image.shape)
            np.testing.assert_array_equal(image[outside], moment.frame[outside])
            ideal = overlay(moment.frame, earth, moment.area)
            unlike = np.abs(image[inside].astype(int) - ideal[inside])
            self.assertLess(unlike.mean(), 6)
            # neither the wall nor an Earth upside down
            self.assertGreater(np.abs(image[inside].astype(int) - moment.frame[inside]).mean(), 80)
            flipped = overlay(moment.frame, earth[::-1], moment.area)
            self.assertGreater(np.abs(image[inside].astype(int) - flipped[inside]).mean(),
                               4 * unlike.mean())

    def test_ocean_desert_and_space_have_their_colors(self):
        moment = max(self.with_area, key=lambda moment: np.ptp(moment.area.corners, axis=0).sum())
        homography = moment.area.homography(960, 640)

        def color(x, y):
            seen = homography @ [x, y, 1]
            x, y = np.int32(np.round(seen[:2] / seen[2]))
            return moment.results[0][y, x].astype(int)
        blue, _, red = color(330, 330)
        self.assertGreater(blue, red + 30)
        blue, green, red = color(430, 270)
        self.assertTrue(red > green > blue and red > 150)
        self.assertLess(color(60, 320).max(), 60)

    def test_the_corners_are_where_the_truth_says(self):
        for moment in self.with_area:
            self.assert_corners(moment, moment.results[0], SPACE, 1.5)

    def test_the_earth_stays_while_tags_are_out_of_view(self):
        self.assert_stays_with_tags_out_of_view('/exercise5_6/image')


if __name__ == '__main__':
    main('exercise5_6_test', Exercise56)
