"""Before a frame is drawn into, it is known whether hints may search it."""
import numpy as np
import pytest
from aruco_ar.hints.hints import Hints
from aruco_ar.tracking.sight import SeenArea, Sight

FRAME = np.full((240, 320, 3), 200, np.uint8)
DETECTION = {'dictionary': 'DICT_6X6_250', 'ids': (), 'search': 'normal', 'correction': 1.0, 'confidence': 0.8,
             'min_side': 0.0}


@pytest.mark.parametrize('is_at_once', [True, False], ids=['at once', 'later'])
def test_no_frame_is_searched_of_which_that_was_not_said(is_at_once):
    hints, waiting, searched, said = Hints(DETECTION, 'tags'), [], 0, 0
    for number in range(300):
        may_search = hints.may_search(number / 10)
        searches = hints.update(Sight(FRAME, number / 10, areas=(SeenArea(None),)))
        assert may_search or not searches
        said, searched = said + may_search, searched + len(searches)
        waiting += searches
        if is_at_once or number % 7 == 0:
            while waiting:
                waiting.pop()()
    assert searched > 10 and said < 200
