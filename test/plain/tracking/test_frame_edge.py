"""Tags at the edge of the frame: whether the area stays, and where it is."""
import cv2
import numpy as np
import pytest
from aruco_ar import Tracker
from aruco_ar.tags.tag import draw_tag

pytestmark = pytest.mark.long
FINE, SIDE, SIZE = 4, 60, (640, 480)  # a frame is drawn FINE times as large; the side of a tag, pixels
TOPS = 60, 60, 360, 360


def frame_with(lefts, random):
    """A frame with tags 1 to 4, whose left edges are at these x, pixels from the frame's own edge."""
    wide = np.full((SIZE[1] * FINE, (SIZE[0] + 4 * SIDE) * FINE), 230, np.uint8)
    for number, (left, top) in enumerate(zip(lefts, TOPS)):
        x, y = round((left + 2 * SIDE) * FINE), top * FINE
        wide[y:y + SIDE * FINE, x:x + SIDE * FINE] = draw_tag('DICT_6X6_250', number + 1, SIDE * FINE)
    wide = wide[:, 2 * SIDE * FINE:(2 * SIDE + SIZE[0]) * FINE]
    frame = cv2.GaussianBlur(cv2.resize(wide, SIZE, interpolation=cv2.INTER_AREA), (0, 0), 0.7)
    return np.clip(frame + random.normal(0, 2, frame.shape), 0, 255).astype(np.uint8)


def corners_of(lefts):
    centers = np.column_stack([lefts, TOPS]) + SIDE / 2 - 0.5
    return centers[[0, 1, 3, 2]]


@pytest.mark.parametrize('inside', [3.0, 2.0, 1.0, 0.5])
def test_the_area_does_not_come_and_go_while_all_tags_touch_the_edge(inside, random):
    lefts = np.array([inside, SIZE[0] - SIDE - inside] * 2)
    tracker = Tracker()
    areas = [tracker.update(frame_with(lefts, random), number / 30) for number in range(90)]
    areas = areas[2:]  # the usual search and the fine one take turns
    assert None not in areas
    assert max(np.abs(area.corners - corners_of(lefts)).max() for area in areas) < 1


def test_tags_that_slide_to_the_edge_show_the_area_until_they_reach_it(random):
    tracker = Tracker()
    for number in range(60):
        left = max(10 - number / 4, 1)
        lefts = np.array([left, 450, left, 450])
        area = tracker.update(frame_with(lefts, random), number / 30)
        assert len(tracker.tags) == 4
        assert np.abs(area.corners - corners_of(lefts)).max() < 1
