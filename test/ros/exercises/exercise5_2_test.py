#!/usr/bin/env python3
"""Exercise 5.2: every tag is outlined, with its first corner marked and its id."""
import numpy as np
from aruco_ar import Tag, mark_tags
from rig.nodes.replay import ReplayTest, main


class Exercise52(ReplayTest):
    results = ['/exercise5_2/image']

    def test_every_tag_is_outlined_and_its_first_corner_is_red(self):
        for moment in self.moments:
            image = moment.results[0].astype(int)
            for tag in moment.tags:
                for start, end in zip(tag.corners[1:3], tag.corners[2:4]):
                    x, y = np.round((start + end) / 2).astype(int)
                    blue, green, red = best_pixel(image, x, y, lambda pixel: pixel[1] - pixel[0] - pixel[2])
                    self.assertTrue(green > 200 and blue < 120 and red < 120, (tag.id, blue, green, red))
                x, y = np.round(tag.corners[0]).astype(int)
                blue, green, red = image[y, x]
                self.assertTrue(red > 200 and blue < 60 and green < 60, (tag.id, blue, green, red))

    def test_the_written_id_is_the_true_one(self):
        read = 0
        for moment in self.moments[::3]:
            for tag in moment.tags:
                x, y = np.round(tag.center).astype(int)
                if 30 < x < 610 and 30 < y < 450:
                    self.assertEqual(written_number(moment, tag, x, y), tag.id)
                    read += 1
        self.assertGreater(read, 40)

    def test_nothing_else_is_drawn(self):
        for moment in self.moments:
            if moment.area is None or moment.cut:
                continue
            changed = np.any(moment.results[0] != moment.frame, axis=2)
            for tag in moment.tags:
                left, top = np.int32(tag.corners.min(axis=0)) - 8
                right, bottom = np.int32(tag.corners.max(axis=0)) + 9
                changed[max(top, 0):bottom, max(left, 0):right] = False
            self.assertFalse(changed.any())


def written_number(moment, tag, x, y):
    """The number whose drawing on the frame at (x, y) is closest to the result."""
    around = slice(y - 30, y + 31), slice(x - 30, x + 31)
    middle = slice(18, 43), slice(18, 43)  # only the number, without the outline and the dot
    result = moment.results[0][around][middle].astype(int)

    def unlike(number):  # text is drawn on whole pixels, so the nearest may be a neighbor
        corners = tag.corners - (x - 30, y - 30)
        return min(np.abs(mark_tags(moment.frame[around], [Tag(number, corners + (right, down))])[middle]
                          - result).sum() for right in (-1, 0, 1) for down in (-1, 0, 1))
    return min(range(1, 10), key=unlike)


def best_pixel(image, x, y, fit):
    """The pixel around (x, y) with the largest ``fit``."""
    return max(image[y - 1:y + 2, x - 1:x + 2].reshape(-1, 3), key=fit)


if __name__ == '__main__':
    main('exercise5_2_test', Exercise52)
