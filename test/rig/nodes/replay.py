"""The base of the exercises' rostests: frames, results and the truth, matched by their stamps."""
import unittest

import cv2
import numpy as np
import rospy
import rostest
from aruco_ar import Area, Tag, area_mask
from aruco_node.messages.images import TRANSPORTS, frame_from_image
from geometry_msgs.msg import PolygonStamped
from sensor_msgs.msg import Image
from unit5.msg import TagArray

from rig.nodes.topics import moments

FRAMES, TAGS, AREA = '/camera/rgb/image_raw', '/wall_camera/tags', '/wall_camera/area'


class Moment:
    """What was published with one stamp: the frame, the true tags and area, and the results."""

    def __init__(self, parts, frame, results, to_frame):
        self.header = frame.header
        self.frame = to_frame(frame)
        self.messages = [parts[topic] for topic in results]
        self.results = [frame_from_image(message) for message in self.messages]
        shape = np.array(self.frame.shape[1::-1])
        # The truth: the tags that are completely in the frame, and the area if all four tags are.
        everywhere = [Tag(tag.id, np.float32([(p.x, p.y) for p in tag.corners]))
                      for tag in parts[TAGS].tags]
        self.tags = [tag for tag in everywhere
                     if np.all(tag.corners > 8) and np.all(tag.corners < shape - 8)]
        self.cut = [tag for tag in everywhere
                    if np.any(tag.center < 0) or np.any(tag.center > shape - 1)]
        corners = np.float32([(p.x, p.y) for p in parts[AREA].polygon.points])
        self.area = Area(corners) if len(self.tags) == 4 else None
        self.remembered = Area(corners) if len(self.tags) in (2, 3) else None
        self.after_all = False  # whether all four tags were in the frame before, in the same round of the bag


class ReplayTest(unittest.TestCase):
    """Collects moments from the bag that the exercise's own launch file replays."""

    results = ()        # the topics that the exercise publishes
    transport = 'compressed'
    count = 110         # moments to wait for: a whole round of the bag, 85, from wherever the test joins it

    @classmethod
    def setUpClass(cls):
        suffix, kind, decoder = TRANSPORTS[cls.transport]
        to_frame = decoder()
        topics = {FRAMES + suffix: kind, TAGS: TagArray, AREA: PolygonStamped}
        topics.update(dict.fromkeys(cls.results, Image))
        cls.moments = [Moment(parts, parts[FRAMES + suffix], cls.results, to_frame)
                       for parts in moments(topics, cls.count)]
        for before, moment in zip(cls.moments, cls.moments[1:]):
            moment.after_all = moment.header.stamp > before.header.stamp and \
                (before.after_all or before.area is not None)
        cls.with_area = [moment for moment in cls.moments if moment.area]
        assert cls.with_area, 'all four tags are seen in no frame'

    def test_the_header_is_kept_and_the_encoding_is_bgr8(self):
        for moment in self.moments:
            for message in moment.messages:
                self.assertEqual(message.header.stamp, moment.header.stamp)
                self.assertEqual(message.header.frame_id, moment.header.frame_id)
                self.assertEqual(message.encoding, 'bgr8')

    def assert_untouched_without_area(self, topic):
        """Assert that a frame is returned unchanged if a tag's center is outside of it."""
        place = self.results.index(topic)
        without = [moment for moment in self.moments if moment.cut]
        self.assertTrue(without, 'a tag is out of view in no frame')
        for moment in without:
            np.testing.assert_array_equal(moment.results[place], moment.frame)

    def assert_stays_with_tags_out_of_view(self, topic):
        """Assert that the area stays in place while only two or three tags are in the frame.

        Frames before the node has seen all four are returned unchanged.
        """
        place = self.results.index(topic)
        known = [moment for moment in self.moments if moment.remembered and moment.after_all]
        self.assertTrue(known, 'two or three tags are in no frame')
        changed = []
        for moment in known:
            inside, outside = split(moment.remembered, moment.frame.shape)
            np.testing.assert_array_equal(moment.results[place][outside], moment.frame[outside])
            share = np.any(moment.results[place] != moment.frame, axis=2)[inside].mean()
            self.assertTrue(share == 0 or share > 0.9, '%d %% of the area is changed' % (100 * share))
            changed.append(share > 0)
        self.assertGreater(np.mean(changed), 0.6)

    def assert_corners(self, moment, result, color, px):
        """Assert that the corners of the area painted in a result are within ``px`` of the true ones.

        ``color``: what is painted along the area's rim.
        """
        # How much of each pixel is painted: 0 has the frame's color, 1 has the given color.
        frame = moment.frame.astype(np.float32)
        change, full = result - frame, np.float32(color) - frame
        span = np.maximum((full * full).sum(axis=2), 1)
        covered = np.clip((change * full).sum(axis=2) / span, 0, 1)
        found = corners_of(covered, moment.area.corners)
        errors = np.linalg.norm(found - moment.area.corners, axis=1)
        self.assertLess(errors.max(), px)


def split(area, shape, px=3):
    """(inside, outside): boolean masks of the pixels that are at least ``px`` away from the area's rim."""
    mask = area_mask(np.zeros(shape, np.uint8), area)[..., 0]
    kernel = np.ones((2 * px + 1, 2 * px + 1), np.uint8)
    return cv2.erode(mask, kernel) == 255, cv2.dilate(mask, kernel) == 0


def corners_of(covered, near):
    """(4, 2): the corners of a quadrilateral, close to the given ones.

    ``covered``: (h, w) float32, the share of each pixel that the quadrilateral
    covers. Each side is measured between the tags, where the wall is plain:
    along lines across the side, by how far the covered part reaches.
    """
    reach, step = 6.0, 0.25
    steps = np.arange(-reach + step / 2, reach, step)[:, None]
    middle = near.mean(axis=0)
    lines = []
    for start, end in zip(near, np.roll(near, -1, axis=0)):
        along = (end - start) / np.linalg.norm(end - start)
        outward = np.array([along[1], -along[0]])
        outward *= np.sign((start + end - 2 * middle) @ outward)
        points = []
        for part in np.linspace(0.22, 0.78, 60):
            place = start + part * (end - start)
            across = np.float32(place + steps * outward)[:, None]
            reached = cv2.remap(covered, across, None, cv2.INTER_LINEAR).sum() * step - reach
            points.append(place + reached * outward)
        center = np.mean(points, axis=0)
        normal = np.linalg.svd(points - center)[2][1]
        lines.append((normal, normal @ center))  # normal @ point == distance
    return np.array([np.linalg.solve([before[0], after[0]], [before[1], after[1]])
                     for before, after in zip(lines[-1:] + lines[:-1], lines)])


def main(name, case):
    """Run a test case as the node of a rostest."""
    rospy.init_node(name)
    rostest.rosrun('unit5', name, case)
