#!/usr/bin/env python3
"""Exercise 5.2: every tag is outlined, its first corner marked, its id written."""
import numpy as np
from aruco_ar import Tag, mark_tags
from replay import ReplayTest, main


class Exercise52(ReplayTest):
    results = ['/exercise5_2/image']

    def test_every_tag_is_outlined_and_its_first_corner_is_red(self):
        for moment in self.moments:
            image = moment.results[0].astype(int)
            for tag in moment.tags:
                for start, end in zip(tag.corners[1:3], tag.corners[2:4]):
                    x, y = np.round((start + end) / 2).astype(int)
                    blue, green, red = near(image, x, y, lambda pixel: pixel[1] - pixel[0] - pixel[2])
                    self.assertTrue(green > 200 and blue < 120 and red < 120, (tag.id, blue, green, red))
                x, y = np.round(tag.corners[0]).astype(int)
                blue, green, red = image[y, x]
                self.assertTrue(red > 200 and blue < 60 and green < 60, (tag.id, blue, green, red))

    def test_the_id_written_is_the_true_one(self):
        places = [np.float32([x, y]) for x in (-1, 0, 1) for y in (-1, 0, 1)]
        read = 0
        for moment in self.moments[::3]:
            for tag in moment.tags:
                x, y = np.round(tag.center).astype(int)
                part = slice(max(y - 30, 0), y + 31), slice(max(x - 30, 0), x + 31)
                frame, result = moment.frame[part], moment.results[0][part].astype(int)
                corner = (part[1].start, part[0].start)

                def unlike(number):  # text is drawn on whole pixels: the nearest may be the next
                    return min(np.abs(mark_tags(frame, [Tag(number, tag.corners - corner + place)])
                                      - result).sum() for place in places)
                self.assertEqual(min(range(1, 10), key=unlike), tag.id)
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


def near(image, x, y, fit):
    """Of the pixels around a place the one that fits best."""
    return max(image[y - 1:y + 2, x - 1:x + 2].reshape(-1, 3), key=fit)


if __name__ == '__main__':
    main('exercise5_2_test', Exercise52)
