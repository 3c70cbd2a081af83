"""Hints at tags that nobody looks for."""
import cv2
import numpy as np
import pytest
from aruco_ar import Detector
from aruco_ar.hints.other_tags import OtherTags

FRAMES_PER_S = 10


def frame_with(dictionary, ids, random=None):
    """A frame with tags, and noise."""
    table = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
    frame = np.full((480, 640, 3), 170, np.uint8)
    for number, tag_id in enumerate(ids):
        tag = cv2.aruco.generateImageMarker(table, tag_id, 80)
        x, y = 60 + 160 * (number % 4), 60 + 180 * (number // 4)
        frame[y - 20:y + 100, x - 20:x + 100] = 235
        frame[y:y + 80, x:x + 80] = tag[..., None]
    noise = np.random.RandomState(1).normal(0, 3, frame.shape)
    return np.clip(np.round(frame + noise), 0, 255).astype(np.uint8)


def show(others, frame, times, found=False, seen=()):
    """Show a frame at some times, seconds, and do each search at once. ``seen``: the wanted ids in it."""
    for stamp in times:
        work = others.update(frame, stamp, set(seen), found)
        if work is not None:
            work()


def hint(frame, dictionary='DICT_6X6_250', ids=(), seconds=20, found=False, seen=(), border=1):
    others = OtherTags(dictionary, ids, border)
    show(others, frame, np.arange(0, seconds, 1 / FRAMES_PER_S), found, seen)
    return others.hint


@pytest.mark.parametrize('dictionary, ids, named', [
    ('DICT_4X4_50', [0, 1, 2, 3], 'DICT_4X4_50'), ('DICT_4X4_1000', [7, 200], 'DICT_4X4_250'),
    ('DICT_5X5_100', [3, 60, 70], 'DICT_5X5_100'), ('DICT_6X6_1000', [300, 400], 'DICT_6X6_1000'),
    ('DICT_ARUCO_ORIGINAL', [10, 20, 30, 40], 'DICT_ARUCO_ORIGINAL'),
    ('DICT_APRILTAG_36h11', [1, 2, 3, 4], 'DICT_APRILTAG_36h11')])
def test_tags_of_another_dictionary_are_named_with_the_remedy(dictionary, ids, named):
    assert hint(frame_with(dictionary, ids)) == (
        '%d tags of %s (%s) are in sight, but the node looks for tags of DICT_6X6_250. Give dictionary:=%s.'
        % (len(ids), named, ', '.join(map(str, ids)), named))


def test_tags_with_other_ids_are_named():
    assert hint(frame_with('DICT_6X6_250', [5, 6, 7, 8]), ids=(1, 2, 3, 4)) == (
        '4 tags of DICT_6X6_250 (5, 6, 7, 8) are in sight, but none of ids:=1,2,3,4. Give the ids of four of '
        'them, or ids:=any.')


def test_nothing_is_said_while_wanted_tags_are_in_sight_or_in_the_first_seconds():
    frame = frame_with('DICT_4X4_50', [0, 1, 2, 3])
    assert hint(frame, found=True) is None
    assert hint(frame, seconds=1) is None


def test_a_hint_is_withdrawn_when_the_tags_are_gone_or_the_wanted_ones_come():
    others, frame = OtherTags('DICT_6X6_250', ()), frame_with('DICT_4X4_50', [0, 1, 2, 3])
    show(others, frame, np.arange(0, 20, 0.1))
    assert others.hint
    show(others, frame_with('DICT_4X4_50', []), np.arange(20, 50, 0.1))
    assert others.hint is None
    show(others, frame, np.arange(50, 80, 0.1))
    assert others.hint
    others.update(frame, 80.0, set(), True)
    assert others.hint is None


def test_nothing_is_said_of_another_wall_once_the_wanted_tags_have_been_in_sight():
    others, frame = OtherTags('DICT_6X6_250', ()), frame_with('DICT_APRILTAG_36h11', [1, 2, 3, 4])
    show(others, frame, np.arange(0, 2, 0.1), found=True)
    others.reset()
    show(others, frame, np.arange(2, 40, 0.1))
    assert others.hint is None


@pytest.mark.parametrize('ids', [(), (1, 2, 3, 4), (1, 2)])
def test_nothing_is_said_of_wanted_tags_that_the_search_of_the_node_misses(ids):
    assert hint(frame_with('DICT_6X6_250', [1, 2, 3, 4]), ids=ids) is None


def test_only_tags_are_named_that_were_seen_each_time():
    others = OtherTags('DICT_6X6_250', ())
    frames = [frame_with('DICT_4X4_50', [0, 1, third]) for third in (4, 5, 6, 7)]
    for number in range(0, 20 * FRAMES_PER_S, 10):
        show(others, frames[number // 10 % 4], [number / FRAMES_PER_S])
    assert others.hint.startswith('2 tags of DICT_4X4_50 (0, 1) are in sight')


@pytest.mark.parametrize('shape', [(1, 2000, 3), (2000, 1, 3), (2000, 3, 3)])
def test_thin_frames_can_be_searched(shape):
    assert hint(np.full(shape, 90, np.uint8), seconds=5) is None


def test_noise_patterns_and_text_give_no_hint(random):
    cells = random.randint(0, 2, (48, 64)).astype(np.uint8) * 255
    checks = np.indices((48, 64)).sum(axis=0) // 4 % 2 * 255
    for image in cells, checks:
        frame = cv2.resize(image.astype(np.uint8), (640, 480), interpolation=cv2.INTER_NEAREST)
        assert hint(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR), seconds=15) is None
    text = np.full((480, 640, 3), 255, np.uint8)
    for row in range(12):
        cv2.putText(text, 'Some words 8642 HH MM BB', (10, 40 + 38 * row), cv2.FONT_HERSHEY_SIMPLEX, 1.2,
                    (0, 0, 0), 6)
    assert hint(text, seconds=15) is None


def test_dictionaries_are_known_as_courses_spell_them():
    frame = frame_with('DICT_6X6_250', [1, 2])
    assert {tag.id for tag in Detector('DICT_6x6_250').detect(frame)} == {1, 2}


def wide(ids):
    """A frame with tags whose black border is two cells wide."""
    frame = np.full((480, 640, 3), 235, np.uint8)
    for number, tag_id in enumerate(ids):
        frame[60:140, 30 + 150 * number:110 + 150 * number] = \
            cv2.aruco.generateImageMarker(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250), tag_id, 80,
                                          borderBits=2)[..., None]
    return frame


@pytest.mark.parametrize('seen', [(), (17,)], ids=['nothing found', 'a false tag now and then'])
def test_tags_that_are_mirrored_or_of_another_border_are_named_with_the_remedy(seen):
    frame, ids = frame_with('DICT_6X6_250', [1, 2, 3, 4]), '4 tags of DICT_6X6_250 (1, 2, 3, 4)'
    for flipped in frame[:, ::-1], frame[::-1]:
        assert hint(np.ascontiguousarray(flipped), seen=seen) == (
            ids + ' are mirrored in the image, so they cannot be read. If the camera or its driver mirrors or '
            'flips the image, turn off this mirroring.')
    assert hint(wide([1, 2, 3, 4]), seen=seen) == (
        ids + ' have a black border 2 cells wide, but the node looks for one 1 cell wide. Give border:=2.')
    assert hint(frame, seen=seen, border=2) == (
        ids + ' have a black border 1 cell wide, but the node looks for one 2 cells wide. Give border:=1.')


def test_false_tags_that_come_and_go_do_not_end_the_search_for_others():
    others, frame = OtherTags('DICT_4X4_1000', ()), frame_with('DICT_APRILTAG_36h11', [1, 2, 3, 4])
    for number in range(200):
        show(others, frame, [number / 10], seen=[number, number + 1] if number % 3 == 0 else [])
    assert others.hint.startswith('4 tags of DICT_APRILTAG_36h11 (1, 2, 3, 4) are in sight, but')
