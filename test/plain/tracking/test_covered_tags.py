"""Something covers a side of tags: the area stays in its place, from the first frame on, and after that."""
import numpy as np
import pytest
from aruco_ar import Detector, Tracker
from benchmark.real_clips.covered import Cover
from rig.accuracy.areas import USUAL, follow
from rig.accuracy.drives import SLOW, drive


def covered(frames, ids, cover, depths):
    """The frames with a Cover on tags. ``depths``: {number of the frame: how far it reaches, in sides}."""
    detector, result = Detector(), []
    for number, frame in enumerate(frames):
        image = frame.image.copy()
        for tag in detector.detect(frame.image) if depths.get(number) else ():
            if tag.id in ids:
                cover.put(image, tag.corners, depths[number])
        result.append(frame._replace(image=image))
    return result


@pytest.fixture(scope='module')
def frames():
    return list(drive(SLOW, 60, size=(960, 720), **USUAL))


@pytest.mark.parametrize('ids', [[3], [1, 3]])
@pytest.mark.parametrize('color', ['skin', 'white'])
@pytest.mark.parametrize('side', ['below', 'the right'])
def test_tags_that_are_covered_from_the_first_frame_on_are_used_where_they_are(frames, ids, color, side):
    seen = covered(frames, ids, Cover(color, side), dict.fromkeys(range(40), 0.08))
    errors = follow(Tracker(), seen)
    assert errors.max() < 1.2 and errors[50:].max() < 0.6


@pytest.mark.parametrize('ids', [[3], [1, 3]])
@pytest.mark.parametrize('depth', [0.03, 0.08])
def test_tags_of_a_known_wall_that_are_covered_hardly_move_the_area(frames, ids, depth):
    seen = covered(frames, ids, Cover('skin', 'below'), dict.fromkeys(range(30, 50), depth))
    errors = follow(Tracker(), seen)
    assert errors[30:].max() < 0.7


@pytest.mark.parametrize('ids', [[2, 3], [1, 4]])
def test_tags_of_which_much_is_covered_after_the_first_frame_hardly_move_the_area(frames, ids):
    few = frames[::5]  # six a second, so the first frame is all that shows these tags
    seen = covered(few, ids, Cover('skin', 'below'), dict.fromkeys(range(1, 10), 0.3))
    assert follow(Tracker(), seen).max() < 0.4


def test_a_tag_is_reported_where_it_is_without_what_covers_it(frames):
    seen = covered(frames, [3], Cover('skin', 'below'), dict.fromkeys(range(30, 50), 0.08))
    tracker, detector = Tracker(), Detector()
    for number, frame in enumerate(seen[:50]):
        tracker.update(frame.image, frame.stamp)
        if number >= 30:
            found, = (tag.corners for tag in tracker.tags if tag.id == 3)
            whole, = (tag.corners for tag in detector.detect(frames[number].image) if tag.id == 3)
            assert np.abs(found - whole).max() < 1


def test_whole_tags_are_not_changed(frames, monkeypatch):
    changed = []
    complete = Tracker._completed

    def completed(self, layout, seen, expected, search):
        tags, ids = complete(self, layout, seen, expected, search)
        changed.extend(ids)
        return tags, ids
    monkeypatch.setattr(Tracker, '_completed', completed)
    follow(Tracker(), frames)
    assert not changed
