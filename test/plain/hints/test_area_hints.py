"""What a user is told about an area that was found."""
import numpy as np
import pytest
from aruco_ar import Area, Tag
from aruco_ar.hints.area_hints import AreaHints

CORNERS = np.float32([[100, 100], [400, 110], [390, 300], [95, 310]])
SQUARE = np.float32([[-10, -10], [10, -10], [10, 10], [-10, 10]])


def tags_at(places, first=1):
    return [Tag(first + number, SQUARE + place) for number, place in enumerate(np.float32(places))]


def sentences(tags, area, ids=(), upright='tags', seconds=3):
    hints = AreaHints(ids, upright)
    for number in range(10 * seconds):
        hints.update(number / 10, tags, area)
    return list(hints.sentences.values())


def test_of_more_than_four_tags_it_says_how_to_keep_those_that_were_taken():
    tags = tags_at([*CORNERS, (250, 200), (200, 160)])
    said = ('6 tags are in sight: 1, 2, 3, 4, 5, 6. The area is between the outermost four. Keep these four by '
            'ids:=%s, or give four others that span the area you want.')
    assert sentences(tags, Area(CORNERS)) == [said % '1,2,3,4']
    in_a_row = tags_at([(250, 200), (270, 200), (290, 200), (310, 200), *CORNERS])  # they span no area
    seen = '3, 4, 5, 6, 7, 8'
    assert sentences(in_a_row[2:], Area(CORNERS)) == [said.replace('1, 2, 3, 4, 5, 6', seen) % '5,6,7,8']
    assert sentences(tags, Area(CORNERS), ids=(1, 2, 3, 4)) == []
    assert sentences(tags, Area(CORNERS), seconds=1) == []


@pytest.mark.parametrize('tags', [tags_at(CORNERS), tags_at([*CORNERS[1:], (250, 200), (200, 160)])])
def test_with_four_tags_or_with_one_of_them_out_of_sight_it_says_nothing(tags):
    assert sentences(tags, Area(CORNERS)) == []


def test_an_area_that_is_upside_down_comes_with_the_remedy():
    turned = Area(np.roll(CORNERS, 2, axis=0))
    assert sentences(tags_at(CORNERS), turned) == [
        'The tags hang upside down in the image, so the top of the area is below. Turn it by upright:=image.']
    assert sentences(tags_at(CORNERS), turned, upright='image') == []
    assert sentences(tags_at(CORNERS), Area(np.roll(CORNERS, 1, axis=0))) == []


def test_a_hint_is_withdrawn_when_it_is_true_no_more():
    hints = AreaHints((), 'tags')
    for number in range(50):
        hints.update(number / 10, tags_at(CORNERS), Area(np.roll(CORNERS, 2 if number < 40 else 0, axis=0)))
        assert bool(hints.sentences) == (20 <= number < 40)
    hints.update(6.0, [], None)
    assert hints.sentences == {}
