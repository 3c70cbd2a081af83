"""Each frame is searched once, for all who want to know something of it."""
from collections import Counter

import cv2
import numpy as np
import pytest
from aruco_ar import Lens, PoseEstimator, draw_tag
from aruco_ar.hints.hints import Hints
from aruco_ar.poses.pose_runner import PoseRunner
from aruco_ar.settings.settings import AreaSettings, PoseSettings
from aruco_ar.tags.detector import Detector
from aruco_ar.tracking.observer import FOLLOWED, FOUND, NEEDED, Observer

LENS = Lens(1000, 700, np.array([[900.0, 0, 500], [0, 900, 350], [0, 0, 1]]), np.array([]))
WHOLE = 700, 1000
IDS = [range(4 * area, 4 * area + 4) for area in range(5)]
CORNERS = np.array([[0, 0], [110, 0], [110, 130], [0, 130]])
PLACES = [(20 + 190 * area, 120 + 190 * (area % 2)) for area in range(5)]


@pytest.fixture
def searches(monkeypatch):
    """How often a frame was searched: {(function, size of what was searched): times}."""
    counted = Counter()
    originals = {name: getattr(Detector, name) for name in ('detect', 'search')}
    for name, original in originals.items():
        def count(self, frame, *more, name=name, original=original):
            counted[name, frame.shape[:2]] += 1
            return original(self, frame, *more)
        monkeypatch.setattr(Detector, name, count)
    return counted


def moved(number):
    """(2,) pixels: how far the wall has moved in a frame, smoothly."""
    return np.round([20 + 20 * np.sin(number / 10), 10 + 10 * np.cos(number / 10)]).astype(int)


def wall(number, areas=range(5)):
    """A frame, (700, 1000, 3), with those of five areas, in a slightly different place each time."""
    frame = np.full((700, 1000), 200, np.uint8)
    for area in areas:
        for tag_id, corner in zip(IDS[area], CORNERS):
            x, y = PLACES[area] + corner + moved(number)
            frame[y:y + 50, x:x + 50] = draw_tag('DICT_6X6_250', tag_id, 50)
    return cv2.cvtColor(cv2.GaussianBlur(frame, (0, 0), 0.6), cv2.COLOR_GRAY2BGR)


@pytest.mark.parametrize('tags', [NEEDED, FOUND, FOLLOWED])
def test_five_areas_poses_and_hints_search_each_frame_at_most_once(searches, tags):
    settings = [AreaSettings(ids=ids) for ids in IDS]
    observer, hints = Observer(settings, tags), Hints({**AreaSettings().of_detector()}, 'tags')
    estimator, found = PoseEstimator(0.1), []
    for number in range(60):
        searches.clear()
        sight = observer.look(wall(number), number / 30)
        assert hints.update(sight) == []
        whole = searches['detect', WHOLE] + searches['search', WHOLE]
        found.append(whole)
        if tags != NEEDED:
            assert len(estimator.update(sight.tags, LENS, sight.stamp)) == 20
            assert sum(searches.values()) <= 1, (number, searches)
        assert whole <= 1, (number, searches)
        # Besides, only the surroundings of tags that have just been lost are searched, once for all areas.
        assert sum(searches.values()) - whole <= 20
        assert sorted(tag.id for tag in sight.tags) == list(range(20))
        for seen, place in zip(sight.areas, PLACES):
            truth = place + CORNERS + moved(number) + 24.5
            np.testing.assert_allclose(seen.area.corners, truth, atol=0.5)
    least, most = {NEEDED: (3, 6), FOUND: (60, 60), FOLLOWED: (9, 15)}[tags]
    assert least <= sum(found) <= most


def test_areas_that_come_later_are_found_by_the_same_search(searches):
    observer = Observer([AreaSettings(ids=ids) for ids in IDS])
    for number in range(40):
        searches.clear()
        sight = observer.look(wall(number, range(2 if number < 20 else 5)), number / 30)
        # While something is not found, the usual and the fine search may both be done.
        assert searches['detect', WHOLE] <= 1 and searches['search', WHOLE] <= 1
    assert all(seen.area is not None for seen in sight.areas)


def test_poses_need_no_search_of_their_own(searches):
    runner = PoseRunner(PoseSettings(ids=IDS[0], tag_size=0.1))
    for number in range(60):
        searches.clear()
        sight, poses = runner.run(wall(number), number / 30, LENS)
        assert sum(searches.values()) <= 1, (number, searches)
        assert [pose.id for pose in poses.tags] == list(IDS[0]) and sight.areas[0].area is not None
        if number > 10:  # the wall is known after a few frames
            assert poses.area.width == pytest.approx(0.22, abs=0.005)
