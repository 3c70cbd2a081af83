"""A wall that was remembered in a file is known from the first frame on, also without its tags."""
import itertools
import os
import time
from dataclasses import replace

import cv2
import numpy as np
import pytest
from aruco_ar import InputError, Tracker
from aruco_ar.settings.settings import AreaSettings
from aruco_ar.tracking.observer import Observer
from rig.accuracy.areas import follow, rms
from rig.accuracy.drives import LIVELY, PAINTING, SLOW, STILL, WALL, drive
from rig.processes.started import WAIT_S

ALL = WALL.area
LEARNED = 75  # frames in which all tags are in sight
PHONE = {'noise': 2.0, 'blur': 0.7, 'light': 0.3, 'hand': 1.0, 'quality': 70}


@pytest.fixture(scope='module')
def saved(tmp_path_factory):
    """The path of a file with that wall."""
    path = str(tmp_path_factory.mktemp('walls') / 'painting.npz')
    tracker = Tracker()
    follow(tracker, drive(SLOW, LEARNED, wall=PAINTING, **PHONE))
    tracker.save_wall(path)
    return path


@pytest.fixture(scope='module')
def blank(tmp_path_factory):
    """The path of a file with a wall that has tags, and nothing else."""
    path = str(tmp_path_factory.mktemp('walls') / 'blank.npz')
    tracker = Tracker()
    follow(tracker, drive(SLOW, LEARNED, wall=replace(WALL, plaster=0), **PHONE))
    tracker.save_wall(path)
    return path


def hidden(number):
    return ALL


def test_a_file_is_small(saved):
    assert os.path.getsize(saved) < 2 * 1024 * 1024


@pytest.mark.long
@pytest.mark.parametrize('path', [STILL, LIVELY])
def test_the_wall_is_found_without_its_tags_from_the_first_frame_on(saved, path):
    errors = follow(Tracker(wall=saved), drive(path, 90, hidden, wall=PAINTING, **PHONE))
    assert not np.isnan(errors).any() and rms(errors) < 1


@pytest.mark.long
def test_the_wall_is_found_again_after_it_was_out_of_sight(saved):
    frames = list(drive(LIVELY, 90, hidden, wall=PAINTING, **PHONE))
    for frame in frames[30:60]:
        frame.image[:] = 90
    errors = follow(Tracker(wall=saved), frames)
    assert np.isnan(errors[42:60]).all()
    assert not np.isnan(errors[82:]).any() and rms(errors[82:]) < 1


@pytest.mark.long
def test_a_wall_that_was_saved_again_is_found_as_well(saved, tmp_path):
    """Also if it was not seen in between, and if it was seen with its tags."""
    wall = PAINTING
    for seen in (), drive(STILL, 60, wall=wall, **PHONE):
        tracker, again = Tracker(wall=saved), str(tmp_path / 'again.npz')
        follow(tracker, drive(STILL, 1, hidden, wall=wall, **PHONE))
        follow(tracker, seen)
        tracker.save_wall(again)
        errors = follow(Tracker(wall=again), drive(LIVELY, 60, hidden, wall=wall, **PHONE))
        assert not np.isnan(errors).any() and rms(errors) < 1


@pytest.mark.long
def test_one_tag_is_enough_on_a_blank_wall(blank):
    frames = list(drive(STILL, 60, lambda number: ALL[1:], wall=replace(WALL, plaster=0), noise=1.0))
    errors = follow(Tracker(wall=blank), frames)
    assert not np.isnan(errors[30:]).any() and errors[30:].max() < 6
    assert np.isnan(follow(Tracker(), frames)).all()


@pytest.mark.long
def test_another_wall_is_not_taken_for_it(saved):
    frames = list(drive(LIVELY, 60, hidden, wall=PAINTING, **PHONE))
    tracker = Tracker(wall=saved)
    for change in (lambda image: cv2.flip(image, 1)), cv2.bitwise_not:
        for frame in frames:
            assert tracker.update(change(frame.image), frame.stamp) is None


@pytest.mark.long
def test_tags_that_now_hang_elsewhere_count_more_than_the_file(saved):
    moved = replace(PAINTING, tags=tuple(
        replace(tag, x=tag.x * 0.8, y=tag.y * 0.9) if tag.id in ALL else tag for tag in WALL.tags))
    errors = follow(Tracker(wall=saved), drive(STILL, 90, wall=moved, **PHONE))
    assert not np.isnan(errors[45:]).any() and errors[45:].max() < 2


@pytest.mark.long
def test_a_search_in_a_thread_finds_it_in_a_later_frame(saved):
    """How much later depends on the computer. So frames are shown, in real time, until it is found."""
    frames = list(drive(STILL, 10, hidden, wall=PAINTING, **PHONE))
    observer, shown = Observer([AreaSettings(wall=saved)], in_thread=True), itertools.count()
    began = time.monotonic()
    assert observer.look(frames[0].image, 0.0).areas[0].area is None  # its search has only begun
    area = None
    while area is None and time.monotonic() < began + WAIT_S:
        frame = frames[next(shown) % len(frames)]
        area = observer.look(frame.image, time.monotonic() - began).areas[0].area
    assert area is not None and np.abs(area.corners - frame.corners).max() < 2


def test_a_wall_that_is_not_known_yet_cannot_be_saved(tmp_path):
    tracker = Tracker()
    follow(tracker, drive(STILL, 5, noise=1.0))
    with pytest.raises(InputError, match='Show all four tags'):
        tracker.save_wall(str(tmp_path / 'wall.npz'))


@pytest.mark.parametrize('arguments, words', [
    ({'ids': (1, 2, 3, 5)}, 'between the tags 1,2,3,4, not between 1,2,3,5'),
    ({'dictionary': 'DICT_5X5_250'}, 'dictionary:=DICT_6X6_250'),
    ({'border': 2.0}, 'border:=1')])
def test_a_file_with_other_tags_is_refused(saved, arguments, words):
    with pytest.raises(InputError, match=words):
        Tracker(wall=saved, **arguments)


@pytest.mark.parametrize('damage', [
    lambda data: data[:len(data) // 2], lambda data: b'', lambda data: b'tags: []',
    lambda data: data[:3000] + bytes(400) + data[3400:]])
def test_a_damaged_file_is_refused(saved, tmp_path, damage):
    path = tmp_path / 'wall.npz'
    with open(saved, 'rb') as file:
        path.write_bytes(damage(file.read()))
    with pytest.raises(InputError, match=r'wall.npz" is damaged, or is none that the service'):
        Tracker(wall=str(path))


@pytest.mark.parametrize('name, value', [
    ('format', 99), ('ids', [1, 2, 3, 99]), ('dictionary', 'DICT_9X9'),
    ('tag_places', lambda saved: np.full_like(saved, np.nan)),
    ('points', lambda saved: np.full_like(saved, 5e3)),
    ('point_places', lambda saved: np.full_like(saved, 1e9)),
    ('image', np.zeros((8, 8), np.uint8)), ('inner', [1e9, 1]),
    ('feature_descriptors', np.zeros((3, 128), np.uint8)), ('border', np.zeros(3))])
def test_a_file_with_wrong_entries_is_refused(saved, tmp_path, name, value):
    with np.load(saved) as arrays:
        changed = {key: arrays[key] for key in arrays.files}
    changed[name] = value(changed[name]) if callable(value) else value
    path = str(tmp_path / 'wall.npz')
    np.savez_compressed(path, **changed)
    with pytest.raises(InputError, match='again|damaged'):
        Tracker(wall=path)
