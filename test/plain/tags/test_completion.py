"""Tags of which something covers a side: they are completed, and whole tags are left alone."""
import cv2
import numpy as np
import pytest
from aruco_ar import Detector, draw_tag
from aruco_ar.tags.completion import Completion
from benchmark.real_clips.covered import Cover

TAG = 23
PLACE = np.float32([[90, 80], [171, 84], [175, 168], [86, 163]])


def photo(place=PLACE, border=1, white=False):
    """A photo, (260, 260, 3), of a tag at a place, (4, 2) pixels."""
    tag = draw_tag('DICT_6X6_250', TAG, 800, border=border, quiet=1)
    margin = (len(tag) - 800) / 2
    corners = np.float32([[margin, margin], [margin + 800, margin], [margin + 800, margin + 800],
                          [margin, margin + 800]]) - 0.5
    seen = cv2.warpPerspective(tag, cv2.getPerspectiveTransform(corners, 4 * np.float32(place)), (1040, 1040),
                               borderValue=255)
    seen = cv2.GaussianBlur(cv2.resize(seen, (260, 260), interpolation=cv2.INTER_AREA), (0, 0), 0.8)
    seen = 0.7 * (255.0 - seen if white else seen) + 25 + np.random.RandomState(0).normal(0, 2, seen.shape)
    return cv2.cvtColor(np.clip(seen, 0, 255).astype(np.uint8), cv2.COLOR_GRAY2BGR)


def found_in(frame, border=1):
    """The corners of the tag in a frame, (4, 2), as they are found and as they are completed, or None."""
    detector = Detector(border=border)
    tag, = detector.detect(frame)
    return tag.corners, detector.completion(TAG).complete(frame, tag.corners)


def assert_completed(cover, place=PLACE, needs_it=True, **look):
    """With a cover, the tag is completed to about what is found without it. ``look``: see photo."""
    whole, _ = found_in(photo(place, **look), look.get('border', 1))
    frame = photo(place, **look)
    cover.put(frame, place, 0.06)
    found, completed = found_in(frame, look.get('border', 1))
    if needs_it:
        assert np.linalg.norm(found - whole, axis=1).max() > 4
    best = found if completed is None else completed
    assert np.linalg.norm(best - whole, axis=1).max() < 1.5
    assert np.linalg.norm(best.mean(axis=0) - whole.mean(axis=0)) < 0.5


@pytest.mark.parametrize('color', ['skin', 'white'])
@pytest.mark.parametrize('side', ['below', 'the right'])
@pytest.mark.parametrize('turns', [0, 2])
def test_a_tag_is_completed_where_something_covers_a_side(color, side, turns):
    # One of these is found by its cells at once.
    assert_completed(Cover(color, side), np.roll(PLACE, turns, axis=0), (color, side, turns) != (
        'skin', 'the right', 2))


def test_so_is_one_that_is_white_on_black_or_has_a_wide_border():
    assert_completed(Cover('dark', 'below'), white=True)
    assert_completed(Cover('skin', 'below'), border=2)


@pytest.mark.parametrize('blur', [0, 1.5, 3])
def test_a_whole_tag_is_left_alone_sharp_or_blurred_or_smeared(blur):
    frame = photo()
    assert found_in(cv2.GaussianBlur(frame, (0, 0), blur) if blur else frame)[1] is None
    assert found_in(cv2.blur(frame, (1 + round(2 * blur), 1)))[1] is None


def test_so_is_a_tag_on_a_sheet_that_is_rolled():
    across = np.arange(260, dtype=np.float32)
    bent = across + 6 * np.sin(np.pi * np.clip((across - 80) / 90, 0, 1))  # cells get wider, then narrower
    frame = cv2.remap(photo(), *np.meshgrid(bent, across), cv2.INTER_LINEAR)
    assert found_in(frame)[1] is None


def test_nothing_is_said_of_a_side_with_no_cells_near_it():
    cells = np.zeros((8, 8), np.uint8)
    cells[1, 1:7] = 255
    place = np.float32([[20, 20], [84, 20], [84, 80], [20, 80]])
    frame = np.full((100, 100), 200, np.uint8)
    frame[20:80, 20:84], frame[28:36, 28:76] = 40, 200
    completion = Completion(cells, 1)
    taller = place + np.float32([[0, 0], [0, 0], [0, 4], [0, 4]])
    assert completion.complete(frame, place) is None
    assert completion.covered_side(frame, place, {2: taller}) is None
