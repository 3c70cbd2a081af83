"""A hand stays in front of white paper, which differs little from pale skin."""
from dataclasses import replace

import cv2
import numpy as np
import pytest
from test_looks import (
    FRAMES_PER_S,
    Drive,
    around,
    assert_in_front,
    core,
    hand,
    is_kept,
    is_painted,
    painted,
    stage,
    with_sheet,
)

pytestmark = pytest.mark.long
PALE = 130, 141, 168


def test_a_pale_hand_stays_in_front_of_white_paper_for_as_long_as_it_writes(wall):
    drive, keeps = Drive(replace(wall, color=(225, 228, 230))), stage(foreground='keep')
    for number in range(6 * FRAMES_PER_S):
        frame, inside = drive.frame(number)
        things = hand(frame, number, PALE)
        image = painted(keeps, frame, number)
        if number > FRAMES_PER_S:
            assert_in_front(image, frame, things, inside)


def test_a_hand_that_is_there_from_the_first_frame_stays_in_front_of_a_crumpled_sheet(wall, tmp_path, random):
    ridges = sum(deep * np.abs(cv2.resize(random.normal(0, 1, (1200 // wide, 1600 // wide)), (1600, 1200),
                                          interpolation=cv2.INTER_CUBIC))
                 for wide, deep in ((200, 60), (80, 15)))
    shade = np.clip(215 * (1 + 0.3 * cv2.Sobel(ridges, -1, 1, 0) / 8), 120, 245)
    cv2.imwrite(str(tmp_path / 'sheet.png'), np.dstack([shade, shade + 2, shade + 4]).astype(np.uint8))
    drive, keeps = Drive(with_sheet(wall, tmp_path / 'sheet.png')), stage(foreground='keep')
    for number in range(2 * FRAMES_PER_S):
        frame, inside = drive.frame(number)
        assert np.ptp(np.percentile(frame[inside], (20, 80))) > 20  # it is crumpled, indeed
        things = hand(frame, number, moves=False)
        image = painted(keeps, frame, number)
        assert is_kept(image, frame, core(things) & inside) > 0.95
        assert is_painted(image, around(things, inside)) > 0.97
