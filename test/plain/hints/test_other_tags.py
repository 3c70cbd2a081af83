"""Hints at tags that nobody looks for."""
import cv2
import numpy as np
import pytest
from aruco_ar import Detector
from aruco_ar.hints.other_tags import OtherTags

FRAMES_PER_S = 10
# The rows of the first tags of AprilTag's tagStandard41h12; a bit is a cell, 1 for white.
STANDARD_41H12 = ('1bc 0 17c 7d 4c 55 17c 0 1a4', '1bd 0 17c 7c 15d 16c 7c 101 b9',
                  '1bd 101 17d 75 65 15d 7d 1 a8', '1be 101 17d 45 174 7d 7c 100 1b1')
MIRRORING = ('are mirrored in the image, so they cannot be read. If the camera or its driver mirrors or flips '
             'the image, turn off this mirroring.')


@pytest.fixture(autouse=True)
def costs(monkeypatch):
    """What each search costs, in seconds: ``costs[0]``. So what a test sees does not depend on the machine."""
    cost, took = [0.0], [0.0]

    def thread_time():
        took[0] += cost[0]
        return took[0]
    monkeypatch.setattr('time.thread_time', thread_time)
    return cost


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


def hint(frame, dictionary='DICT_6X6_250', ids=(), seconds=6, found=False, seen=(), border=1):
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
    show(others, frame, np.arange(0, 5, 0.1))
    assert others.hint
    show(others, frame_with('DICT_4X4_50', []), np.arange(5, 20, 0.1))
    assert others.hint is None
    show(others, frame, np.arange(20, 25, 0.1))
    assert others.hint
    others.update(frame, 25.0, set(), True)
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
    for number in range(0, 10 * FRAMES_PER_S, 10):
        show(others, frames[number // 10 % 4], [number / FRAMES_PER_S])
    assert others.hint.startswith('2 tags of DICT_4X4_50 (0, 1) are in sight')


def on_wall(tags, side=60):
    """A frame with tags, each (n, n) uint8, with white margins."""
    frame = np.full((360, 480, 3), 170, np.uint8)
    for number, tag in enumerate(tags):
        x, y = 60 + 210 * (number % 2), 40 + 160 * (number // 2)
        frame[y - 12:y + side + 12, x - 12:x + side + 12] = 235
        frame[y:y + side, x:x + side, 0] = cv2.resize(tag, (side, side), interpolation=cv2.INTER_NEAREST)
        frame[..., 1:] = frame[..., :1]
    return cv2.GaussianBlur(frame, (0, 0), 0.8)


def of_41h12():
    rows = [[int(row, 16) for row in tag.split()] for tag in STANDARD_41H12]
    return [np.array([[row >> bit & 1 for bit in range(8, -1, -1)] for row in tag], np.uint8) * 255
            for tag in rows]


def of_own_dictionary():
    dictionary = cv2.aruco.extendDictionary(4, 6)
    return [cv2.aruco.generateImageMarker(dictionary, tag_id, 8) for tag_id in range(4)]


@pytest.mark.parametrize('tags, side', [(of_41h12(), 63), (of_own_dictionary(), 64)], ids=['41h12', 'own'])
def test_tags_of_no_known_dictionary_are_counted_and_others_advised(tags, side):
    assert hint(on_wall(tags, side)) == (
        '4 square tags in sight are of no dictionary that the node knows, so it cannot read them. They may be '
        "AprilTag's newer ones, such as tagStandard41h12. Print other tags: rosrun unit5 artag_generator.py.")
    assert hint(on_wall(tags, side), seen=(17,)) is not None
    assert hint(on_wall(tags[:1], side)) is None


@pytest.mark.parametrize('frame, dictionary, border', [
    (on_wall(of_41h12(), 63), 'DICT_6X6_250', 1), (frame_with('DICT_5X5_50', [1, 2, 3]), 'DICT_4X4_50', 1),
    (frame_with('DICT_APRILTAG_36h11', [1, 2, 3, 4]), 'DICT_ARUCO_ORIGINAL', 2),
    (np.ascontiguousarray(frame_with('DICT_7X7_50', [1, 2, 3])[::-1]), 'DICT_7X7_50', 1)],
    ids=['unknown', 'other dictionary', 'other dictionary and border', 'mirrored'])
def test_each_kind_is_told_within_ten_seconds_though_a_search_takes_long(frame, dictionary, border, costs):
    costs[0] = 0.15
    assert hint(frame, dictionary, seconds=10, border=border) is not None


def test_it_takes_four_tags_that_differ_in_two_ways():
    assert hint(frame_with('DICT_4X4_50', [0, 1, 2]), border=2) is None
    assert hint(frame_with('DICT_4X4_50', [0, 1, 2, 3]), border=2).endswith('Give border:=1.')


def test_mirrored_tags_that_are_others_of_the_dictionary_are_told_by_the_wanted_ids():
    frame = np.ascontiguousarray(frame_with('DICT_ARUCO_ORIGINAL', [5, 6, 7, 8, 9, 10])[:, ::-1])
    found = {tag.id for tag in Detector('DICT_ARUCO_ORIGINAL').detect(frame)}
    assert len(found) == 6 and found.isdisjoint({5, 6, 7, 8})
    assert hint(frame, 'DICT_ARUCO_ORIGINAL', (5, 6, 7, 8)) == \
        '6 tags of DICT_ARUCO_ORIGINAL (5, 6, 7, 8, 9, 10) ' + MIRRORING
    assert hint(frame, 'DICT_ARUCO_ORIGINAL') is None  # these might be meant
    for ids in (1, 2, 3, 4), (1, 2, 3, 5):  # one of them may be so by chance
        assert hint(frame, 'DICT_ARUCO_ORIGINAL', ids).endswith('or ids:=any.')


def checkers():
    return np.kron(np.indices((6, 8)).sum(axis=0) % 2, np.ones((50, 50))) * 255


def framed_checkers():
    cells = np.kron(np.indices((6, 6)).sum(axis=0) % 2, np.ones((40, 40))) * 255
    return np.pad(np.pad(cells, 40), 40, constant_values=255)


def codes_of_products():
    code = cv2.QRCodeEncoder.create().encode('https://example.org/a/b/c')
    code = cv2.resize(code, (160, 160), interpolation=cv2.INTER_NEAREST)
    return np.pad(np.block([[code, code.T], [code[::-1], code]]), 20, constant_values=255)


def windows():
    """Dark frames around panes of which some are lit, in a light wall."""
    scene = np.full((360, 480), 200.0)
    for number in range(6):
        x, y = 30 + 150 * (number % 3), 30 + 160 * (number // 3)
        scene[y:y + 120, x:x + 120] = 40
        for pane in range(4):
            left, top = x + 15 + 50 * (pane % 2), y + 15 + 50 * (pane // 2)
            scene[top:top + 40, left:left + 40] = 230 if number >> pane & 1 else 90
    return scene


def keyboard():
    """Dark keys with light letters."""
    scene = np.full((360, 480), 190, np.uint8)
    for number, letter in enumerate('ABCDEFGHJKLMNPQRSTUVWXYZ'):
        x, y = 12 + 58 * (number % 8), 40 + 58 * (number // 8)
        scene[y:y + 48, x:x + 48] = 25
        cv2.putText(scene, letter, (x + 13, y + 35), cv2.FONT_HERSHEY_SIMPLEX, 1.0, 235, 4)
    return scene


def bricks():
    scene = np.full((360, 480), 190, np.uint8)
    for row in range(12):
        for column in range(-1, 9):
            x, y = 60 * column + 30 * (row % 2), 30 * row
            scene[y + 3:y + 28, max(x + 3, 0):x + 58] = 70 + 17 * ((row + 3 * column) % 5)
    return scene


@pytest.mark.parametrize('slant', [0, 0.25], ids=['straight', 'slanted'])
@pytest.mark.parametrize('scene', [checkers, framed_checkers, codes_of_products, windows, keyboard, bricks])
def test_nothing_is_said_of_things_with_dark_squares(scene, slant, random):
    image = cv2.GaussianBlur(np.array(scene(), np.float32), (0, 0), 0.8)
    height, width = image.shape
    rim = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    seen = rim + np.float32(slant * 100) * np.array([[0, 0], [-1, 0.6], [-0.5, -1], [0.4, 0]], np.float32)
    image = cv2.warpPerspective(image, cv2.getPerspectiveTransform(rim, seen), (width, height),
                                borderMode=cv2.BORDER_REPLICATE)
    frame = np.clip(image + random.normal(0, 3, image.shape), 0, 255).astype(np.uint8)
    assert hint(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR), seconds=4) is None


@pytest.mark.parametrize('shape', [(1, 2000, 3), (2000, 1, 3), (2000, 3, 3)])
def test_thin_frames_can_be_searched(shape):
    assert hint(np.full(shape, 90, np.uint8), seconds=5) is None


def test_noise_patterns_and_text_give_no_hint(random):
    cells = random.randint(0, 2, (48, 64)).astype(np.uint8) * 255
    checks = np.indices((48, 64)).sum(axis=0) // 4 % 2 * 255
    for image in cells, checks:
        frame = cv2.resize(image.astype(np.uint8), (640, 480), interpolation=cv2.INTER_NEAREST)
        assert hint(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR), seconds=4) is None
    text = np.full((480, 640, 3), 255, np.uint8)
    for row in range(12):
        cv2.putText(text, 'Some words 8642 HH MM BB', (10, 40 + 38 * row), cv2.FONT_HERSHEY_SIMPLEX, 1.2,
                    (0, 0, 0), 6)
    assert hint(text, seconds=4) is None


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
            ids + ' ' + MIRRORING)
    assert hint(wide([1, 2, 3, 4]), seen=seen) == (
        ids + ' have a black border 2 cells wide, but the node looks for one 1 cell wide. Give border:=2.')
    assert hint(frame, seen=seen, border=2) == (
        ids + ' have a black border 1 cell wide, but the node looks for one 2 cells wide. Give border:=1.')


def test_false_tags_that_come_and_go_do_not_end_the_search_for_others():
    others, frame = OtherTags('DICT_4X4_1000', ()), frame_with('DICT_APRILTAG_36h11', [1, 2, 3, 4])
    for number in range(60):
        show(others, frame, [number / 10], seen=[number, number + 1] if number % 3 == 0 else [])
    assert others.hint.startswith('4 tags of DICT_APRILTAG_36h11 (1, 2, 3, 4) are in sight, but')
