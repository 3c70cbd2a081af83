"""Calibrating simulated lenses from views of a sheet."""
import cv2
import numpy as np
import pytest
from aruco_ar import InputError, Lens
from aruco_ar.calibration.calibrate import MIN_VIEWS, _untilted, calibrate, corners_apart, unseen_parts
from aruco_ar.calibration.calibrated import TRY_FISHEYE, Calibrated
from aruco_ar.calibration.collection import FEW, FULL, LIKE, MOVING, Collection
from aruco_ar.calibration.sheet_layout import learn_layout
from aruco_ar.calibration.views import MAX_VIEWS, View, cells_of, different_views
from rig.accuracy.views import LENSES, MATRIX, SIZE, sheet, views_of

pytestmark = pytest.mark.long


@pytest.mark.parametrize('name', LENSES)
def test_a_lens_is_found_from_a_sheet_that_nobody_has_measured(name):
    truth = LENSES[name]
    views = views_of(truth, sheet())
    found = calibrate(views, SIZE, truth.fisheye)
    assert found.lens.matrix[0, 0] == pytest.approx(truth.matrix[0, 0], rel=0.01)
    assert found.lens.matrix[1, 1] == pytest.approx(truth.matrix[1, 1], rel=0.01)
    assert corners_apart(found.lens, truth).max() < 0.5
    assert found.rms < 0.25 and found.held_out < 0.3 and found.coverage > 0.8
    assert found.corners < 0.5 and not found.lacks()


def test_a_known_board_is_enough(random):
    truth = LENSES['barrel']
    layout = {number: np.array([[number % 6, number // 6]], float) for number in range(30)}
    views = []
    while len(views) < 30:
        turn = cv2.Rodrigues(random.uniform(-0.6, 0.6, 3))[0]
        depth = random.uniform(6, 14)
        shift = np.array([*(random.uniform(-0.3, 0.3, 2) * depth), depth])
        pixels = {key: truth.project(np.column_stack([point - (2.5, 2), [0]]) @ turn.T + shift)
                  for key, point in layout.items()}
        views.append(View({key: each + random.normal(0, 0.05, (1, 2)) for key, each in pixels.items()
                           if np.all(each > 0) and np.all(each < SIZE)}))
    views = [view for view in views if len(view.points) > 8]
    for view in views[:3]:  # views of a single row tell nothing
        row = {key: points for key, points in view.points.items() if key < 6}
        views.append(View(row))
    found = calibrate(views, SIZE, board=layout)
    assert found.lens.matrix[0, 0] == pytest.approx(560, rel=0.01)
    assert corners_apart(found.lens, truth).max() < 0.5


def test_a_lens_is_not_sure_where_the_sheet_was_not_or_where_few_views_are_noisy():
    truth = LENSES['barrel']
    middle = calibrate(views_of(truth, sheet(2, 2), 14, away=0.05), SIZE)
    assert middle.coverage < 0.8 and 'Show the sheet near the rims of the image, too.' in middle.lacks()
    noisy = calibrate(views_of(truth, sheet(), 10, noise=0.7), SIZE)
    assert noisy.corners > 0.5 and 'At the corners of the image this lens may be off by' in noisy.lacks()
    assert noisy.lacks().endswith('Show the sheet in more views, near and far, too.')


def found_with(**changes):
    good = dict(lens=LENSES['barrel'], rms=0.1, held_out=0.1, views=20, coverage=1.0, corners=0.1)
    return Calibrated(**{**good, **changes})


OFF = 'At the corners of the image this lens may be off by 2.6 px. Show the sheet '
UNKNOWN = 'At the corners of the image this lens is not known. Show the sheet '
NEARER = 'tilted, with its left side or foot nearer to the camera, too.'
BAD = 'This lens is bad: points are off by 2.6 px, and a good one leaves less than 1.0 px. Put the sheet on'


@pytest.mark.parametrize('found, begin, end', [
    (found_with(), '', ''),
    (found_with(held_out=2.6), BAD + ' a flat board', TRY_FISHEYE),
    (found_with(corners=2.6), OFF, OFF + 'in more views, near and far, too.'),
    (found_with(corners=np.inf, untilted=('left side', 'foot')), UNKNOWN, UNKNOWN + NEARER),
    (found_with(corners=2.6, coverage=0.5, unseen=('top left', 'top', 'right'), untilted=('left side', 'foot')),
     OFF, OFF + 'in the top left, the top and the right of the image; and ' + NEARER)])
def test_what_is_wrong_with_a_lens_is_said_with_the_views_that_mend_it(found, begin, end):
    said = found.lacks()
    assert said.startswith(begin) and said.endswith(end) and bool(said) == bool(end)


def test_the_parts_that_were_not_seen_and_the_tilts_that_are_missing_are_known():
    # The normal of a sheet that is nearer at the left. The camera's x axis points right, and z away from it.
    normals = np.array([[0.4, 0, -1.0]] * 3) / np.hypot(0.4, 1)
    assert _untilted(normals) == ('right side', 'top', 'foot') and _untilted(-normals) == _untilted(normals)
    seen = np.ones((8, 6), bool)
    seen[6:, :2] = False
    assert unseen_parts(seen) == ('top right',)


def test_two_lenses_are_apart_at_the_corners_but_a_turn_of_the_camera_does_not_count():
    truth = LENSES['no distortion']
    longer = Lens(*SIZE, np.diag([1.01, 1.01, 1]) @ MATRIX - [[0, 0, 3.22], [0, 0, 2.36], [0, 0, 0]],
                  np.zeros(5))
    away = np.hypot(*(np.array([[0, 0], [639, 0], [0, 479], [639, 479]]) - MATRIX[:2, 2]).T)
    np.testing.assert_allclose(corners_apart(longer, truth), 0.01 * away, rtol=0.05)
    turned = Lens(*SIZE, MATRIX + [[0, 0, 5], [0, 0, 0], [0, 0, 0]], np.zeros(5))
    assert corners_apart(turned, truth).max() < 3


def test_the_layout_of_tags_is_learned_from_tilted_views():
    layout, truth = sheet(), LENSES['no distortion']
    learned = learn_layout([view.points for view in views_of(truth, layout, 15, noise=0.05)])
    assert set(learned) == set(layout)
    # The learned one has its origin in a tag: compare after the best turn and shift.
    ours, true = (np.concatenate([each[tag_id] for tag_id in sorted(layout)]) for each in (learned, layout))
    ours, true = ours - ours.mean(axis=0), true - true.mean(axis=0)
    left, _, right = np.linalg.svd(ours.T @ true)
    np.testing.assert_allclose(ours @ left @ right, true, atol=0.01)


def test_of_a_still_camera_one_view_is_left_and_of_a_moving_one_the_different_ones():
    views = views_of(LENSES['barrel'], sheet(), 3)
    assert len(different_views([views[0]] * 50, SIZE)) == 1
    with pytest.raises(InputError, match='1 of the 50 views of the sheet differ'):
        calibrate([views[0]] * 50, SIZE)
    assert len(different_views(views * 20, SIZE)) == 3
    assert 0 < cells_of(views[:1], SIZE).sum() < cells_of(views, SIZE).sum()


def test_too_few_or_too_equal_views_are_refused_with_advice():
    views = views_of(LENSES['barrel'], sheet())
    with pytest.raises(InputError, match='3 of the 3 views .* at least %d' % MIN_VIEWS):
        calibrate(views[:3], SIZE)
    flat = views_of(LENSES['no distortion'], sheet(), 12, tilt=0.001)
    with pytest.raises(InputError, match='tilted'):
        calibrate(flat, SIZE)


def test_a_view_with_wrong_tags_is_left_out(random):
    truth = LENSES['barrel']
    views = views_of(truth, sheet())
    views[7] = View({key: points + random.normal(0, 6, (4, 2)) for key, points in views[7].points.items()})
    found = calibrate(views, SIZE)
    assert found.views == len(views) - 1 and corners_apart(found.lens, truth).max() < 0.5


def test_a_lens_is_found_though_one_on_the_way_to_it_cannot_see_some_corners(recwarn):
    matrix = np.array([[560.0, 0, 320], [0, 560, 240], [0, 0, 1]])
    truth = Lens(*SIZE, matrix, np.array([-0.4, 0.2, 0, 0, -0.05]))
    found = calibrate(views_of(truth, sheet(), 16, seed=1), SIZE)
    assert found.lens.matrix[0, 0] == pytest.approx(560, rel=0.01) and not recwarn.list


def test_views_of_tags_on_another_wall_are_left_out(random):
    truth = LENSES['barrel']
    views, wall = views_of(truth, sheet()), views_of(truth, sheet(2, 2), 12, seed=9)
    wall = [View({100 + key: points for key, points in view.points.items()}) for view in wall]
    found = calibrate(views + wall, SIZE)
    assert found.lens.matrix[0, 0] == pytest.approx(560, rel=0.01) and found.views <= len(views)
    with pytest.raises(InputError, match='Only 7 views show the tags of one sheet, but at least 8 are needed'):
        calibrate(views[:7] + wall[:6], SIZE)


@pytest.mark.parametrize('fisheye', [False, True])
def test_where_opencv_finds_no_lens_the_other_model_is_named(monkeypatch, fisheye):
    def fail(*_, **__):
        raise cv2.error
    monkeypatch.setattr(cv2, 'calibrateCameraExtended', fail)
    monkeypatch.setattr(cv2.fisheye, 'calibrate', fail)
    with pytest.raises(InputError, match='finds no lens') as raised:
        calibrate(views_of(LENSES['barrel'], sheet(), 12), SIZE, fisheye)
    assert ('--fisheye, or model:=fisheye' in str(raised.value)) != fisheye


def test_a_collection_says_why_a_view_is_not_kept(random):
    view, other, third = views_of(LENSES['barrel'], sheet(), 3)
    collection = Collection(SIZE)
    alone = View(dict(list(view.points.items())[:1]))
    said = [collection.offer(each) for each in (alone, view, view, view, other)]
    assert said == [FEW, MOVING, '', LIKE, MOVING]
    board = {number: np.array([[number % 12, number // 12]], float) for number in range(24)}
    pixels = {number: 20 * place + 100 + random.normal(0, 1, (1, 2)) for number, place in board.items()}
    for count, why in (12, FEW), (24, ''):
        collection = Collection(SIZE, board)
        for _ in range(2):
            said = collection.offer(View({number: pixels[number] for number in range(count)}))
        assert said == why
    collection.views += [third] * MAX_VIEWS
    assert collection.is_full and collection.offer(third) == FULL


def test_a_collection_keeps_still_views_that_differ_and_shows_where_they_were():
    views = views_of(LENSES['barrel'], sheet(), count=12)
    collection = Collection(SIZE)
    for view in views:  # each is seen once, as if the sheet moved all the time
        assert collection.offer(view)
    for view in views[:3]:
        collection.offer(view)
        assert not collection.offer(view)
        assert collection.offer(view)
    assert len(collection.views) == 3 and collection.offer(View({}))
    frame = np.full((*SIZE[::-1], 3), 100, np.uint8)
    image = collection.draw(frame, View({}))
    seen = (image != frame).any(axis=2)
    assert seen.mean() == pytest.approx(collection.coverage, abs=0.01)
    for view in views[:3]:
        for points in view.points.values():
            x, y = points[0].astype(int)
            assert seen[y, x] and image[y, x, 1] > image[y, x, 2]
