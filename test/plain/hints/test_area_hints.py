"""What a user is told about an area that was found."""
import cv2
import numpy as np
import pytest
from aruco_ar import Area, Tag, draw_tag
from aruco_ar.hints.area_hints import MANY_TAGS, AreaHints
from aruco_ar.hints.hints import Hints
from aruco_ar.settings.settings import AreaSettings
from aruco_ar.tracking.observer import Observer
from aruco_ar.tracking.sight import SeenArea, Sight

CORNERS = np.float32([[100, 100], [400, 110], [390, 300], [95, 310]])
SQUARE = np.float32([[-10, -10], [10, -10], [10, 10], [-10, 10]])


def tags_at(places, first=1):
    return [Tag(first + number, SQUARE + place) for number, place in enumerate(np.float32(places))]


def on_wall(places, random):
    """A frame, (480, 640, 3) uint8, with tags, {id: (x, y) of the center}, 50 pixels wide."""
    frame = np.full((480, 640), 170.0)
    for tag_id, (x, y) in places.items():
        frame[int(y) - 32:int(y) + 32, int(x) - 32:int(x) + 32] = 240
        frame[int(y) - 25:int(y) + 25, int(x) - 25:int(x) + 25] = draw_tag('DICT_6X6_250', tag_id, 50)
    frame = cv2.GaussianBlur(frame, (0, 0), 0.7) + random.normal(0, 2, frame.shape)
    return cv2.cvtColor(np.clip(frame, 0, 255).astype(np.uint8), cv2.COLOR_GRAY2BGR)


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


def test_more_than_four_tags_are_told_though_not_each_frame_is_searched_for_more(random):
    frame = on_wall({**dict(zip((1, 2, 3, 4), CORNERS)), 5: (250, 245), 6: (200, 160)}, random)
    observer, seen = Observer([AreaSettings()]), set()
    hints = Hints({'dictionary': 'DICT_6X6_250', 'ids': ()}, 'tags')
    for number in range(120):
        sight = observer.look(frame, number / 30)
        hints.update(sight)
        seen.add(len(sight.tags))
        if abs(number - 60) > 1:  # it takes two seconds
            assert ('6 tags are in sight' in hints.notes.get(MANY_TAGS, '')) == (number > 60)
    assert seen == {4, 6}


def test_an_area_that_is_upside_down_comes_with_the_remedy():
    turned = Area(np.roll(CORNERS, 2, axis=0))
    assert sentences(tags_at(CORNERS), turned) == [
        'The tags hang upside down in the image, so the top of the area is below. Turn it by upright:=image.']
    assert sentences(tags_at(CORNERS), turned, upright='image') == []
    assert sentences(tags_at(CORNERS), Area(np.roll(CORNERS, 1, axis=0))) == []


def test_a_hint_is_withdrawn_when_it_is_true_no_more():
    hints = AreaHints((), 'tags')
    for number in range(60):
        hints.update(number / 10, tags_at(CORNERS), Area(np.roll(CORNERS, 2 if number < 40 else 0, axis=0)))
        if number != 49:  # for a second it might come back
            assert bool(hints.sentences) == (20 <= number < 49)
    hints.update(6.0, [], None)
    assert hints.sentences == {}


ROW = dict(zip((1, 2, 3, 4), ((100, 200), (250, 205), (400, 200), (550, 210))))
OTHERS = {1: (100, 100), 2: (500, 110), 5: (490, 400), 6: (110, 390)}


OF_FOUR = ('Of the tags 1, 2, 3, 4, only %s. Bring all of them into view, or give the ids of four that hang '
           'there.')
IN_A_ROW = ('The tags in sight (1, 2, 3, 4) are not the corners of a quadrilateral, so no area is between '
            'them. Hang one in each corner.')


@pytest.mark.parametrize('places, ids, words', [
    ({7: (100, 100)}, (), 'Only 1 tag is in sight (7), and an area needs four.'),
    (dict(list(ROW.items())[:3]), (), 'Only 3 tags are in sight (1, 2, 3), and an area needs four.'),
    (ROW, (), IN_A_ROW),
    (OTHERS, (1, 2, 3, 4), OF_FOUR % '1, 2 are in sight; other tags in sight are 5, 6'),
    ({1: (100, 100)}, (1, 2, 3, 4), OF_FOUR % '1 is in sight')],
    ids=['one', 'three', 'in a row', 'others', 'one of four'])
def test_tags_that_span_no_area_are_named_with_the_reason_and_the_remedy(random, places, ids, words):
    frame = on_wall(places, random)
    settings = AreaSettings(ids=ids)
    observer, hints = Observer([settings]), Hints(settings.of_detector(), 'tags')
    for number in range(100):
        sight = observer.look(frame, number / 10)
        hints.update(sight)
        assert sight.areas[0].explanation == words
        assert hints.warning == (words if number >= 80 else None)
    frame = on_wall({**dict(zip((1, 2, 3, 4), CORNERS))}, random)
    sight = observer.look(frame, 10.0)
    hints.update(sight)
    assert sight.areas[0].area is not None and hints.warning is None


@pytest.mark.parametrize('stamp_of', [lambda number: 5.0, lambda number: 100 - number / 30],
                         ids=['still', 'backward'])
def test_hints_come_though_stamps_stand_still_or_go_back(random, stamp_of):
    frame = on_wall(ROW, random)
    hints = Hints({'dictionary': 'DICT_4X4_50', 'ids': ()}, 'tags')
    for number in range(300):
        stamp = stamp_of(number)
        may_search = hints.may_search(stamp)
        work = hints.update(Sight(frame, stamp, areas=(SeenArea(None),)))
        assert may_search or not work
        for search in work:
            search()
    assert hints.warning.endswith('Give dictionary:=DICT_6X6_50.')
