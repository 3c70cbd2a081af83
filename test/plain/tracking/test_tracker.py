"""The area over time, compared with the simulated camera's truth: it sticks, and is never wrong."""
from dataclasses import replace

import cv2
import numpy as np
import pytest
from aruco_ar import Detector, InputError, Tracker
from aruco_ar.simulation.robot import Path, Pose
from aruco_ar.walls.wall import Poster
from rig.accuracy.areas import USUAL, assert_never_wrong, follow, later, rms
from rig.accuracy.drives import FAST, LIVELY, SLOW, STILL, WALL, at_random, drive


def test_the_area_does_not_tremble_while_the_camera_stands_still():
    tracker, frames = Tracker(), list(drive(STILL, 40, noise=5.0))
    corners = np.array([tracker.update(frame.image, frame.stamp).corners for frame in frames])
    assert corners.std(axis=0).max() < 0.05
    assert rms(np.linalg.norm(corners - frames[0].corners, axis=2)) < 0.3


def test_the_area_does_not_lag_behind_while_driving_past():
    frames = list(drive(FAST, 120, **USUAL))
    errors = follow(Tracker(), frames)
    assert rms(errors) < 0.7  # NaN if any frame had no area
    assert rms(errors[-30:]) < 0.7


def test_a_sudden_start_is_followed_at_once():
    path = Path(Pose(-2.2, 0.1, -0.05), ((1, 0, 0), (1, 0.3, 0.5)))
    errors = follow(Tracker(), drive(path, 45, **USUAL))
    assert errors[28:].max() < 0.7


@pytest.fixture
def searched(monkeypatch):
    """The sizes of what is searched for tags of which nothing is known."""
    sizes, search = [], Detector.search
    monkeypatch.setattr(Detector, 'search', lambda self, frame, *args: sizes.append(frame.shape[:2])
                        or search(self, frame, *args))
    return sizes


def test_a_camera_that_is_jerked_in_each_frame_is_followed_without_searches(searched):
    tracker, random, (frame,) = Tracker(), np.random.RandomState(3), drive(STILL, 1, **USUAL)
    for number in range(13):  # within the time after which the whole frame is searched
        jerk = np.float32(random.uniform(-3, 3, 2) if number else (0, 0))
        image = cv2.warpAffine(frame.image, np.float64([[1, 0, jerk[0]], [0, 1, jerk[1]]]), (640, 480),
                               borderMode=cv2.BORDER_REPLICATE)
        corners = tracker.update(image, number / 30).corners
        assert len(tracker.tags) == 4
        np.testing.assert_allclose(corners, frame.corners + jerk, atol=0.7)
    assert not searched


def test_searches_of_the_whole_frame_get_rare_while_there_is_nothing_to_learn(searched):
    tracker, (frame,), (covered,) = Tracker(), drive(STILL, 1), drive(STILL, 1, lambda number: [2])
    for number in range(100):
        tracker.update(frame.image, number / 10)
    assert 10 < len(searched) < 17 and set(searched) == {(480, 640)}
    searched.clear()
    tracker.update(covered.image, 10)
    assert (480, 640) in searched  # the tag that was lost may have been moved


@pytest.fixture
def looked(monkeypatch):
    """The ids of the tags that are looked for beside their places, one by one."""
    ids, look = [], Detector.find_shifted
    monkeypatch.setattr(Detector, 'find_shifted', lambda self, frame, some, quads: ids.extend(some)
                        or look(self, frame, some, quads))
    return ids


def test_a_tag_that_stays_covered_is_looked_for_beside_its_place_ever_less_often(looked):
    tracker, counts = Tracker(), []
    for frame in drive(SLOW, 75, lambda number: [3] if number >= 15 else (), **USUAL):
        looked.clear()
        tracker.update(frame.image, frame.stamp)
        counts.append(looked.count(3))
    looks = np.flatnonzero(counts)
    waits = np.diff(looks)
    assert looks[0] == 15 and waits[:2].max() < 4           # a hand that passes by is soon away
    assert set(waits[-5:]) <= {6, 7} and looks[-1] > 66     # after a while, five times a second


@pytest.mark.parametrize('moved, frames', [(0.0, 0), (0.036, 7)], ids=['in its place', 'beside it'])
def test_a_tag_that_was_covered_for_long_is_found_soon_when_it_comes_back(moved, frames):
    tags = tuple(replace(tag, x=tag.x + moved) if tag.id == 3 else tag for tag in WALL.tags)
    tracker, (covered,) = Tracker(), drive(STILL, 1, lambda number: [3])
    (before,), (after,) = drive(STILL, 1), drive(STILL, 1, wall=replace(WALL, tags=tags))
    for number in range(70):
        tracker.update((before if number < 10 else covered).image, number / 30)
    assert 3 not in {tag.id for tag in tracker.tags}
    seen = [tracker.update(after.image, (70 + number) / 30) and {tag.id for tag in tracker.tags}
            for number in range(frames + 1)]
    assert 3 in seen[-1]


@pytest.mark.parametrize('calm_s', [1, 12])
def test_a_new_tag_locates_the_area_soon_after_it_was_hung(calm_s):
    more = replace(WALL, tags=(*WALL.tags, replace(WALL.tags[0], id=90, x=0.0, y=WALL.tags[0].y)))
    tracker, (before,), (after,) = Tracker(ids=WALL.area), drive(STILL, 1), drive(STILL, 1, wall=more)
    (alone,) = drive(STILL, 1, lambda number: WALL.area, wall=more)
    for number in range(10 * calm_s + 45):
        tracker.update((before if number < 10 * calm_s else after).image, number / 10)
    for number in range(40):
        area = tracker.update(alone.image, calm_s + 4.5 + number / 10)
    assert area is not None and tracker.located
    assert np.abs(area.corners - alone.corners).max() < 5


@pytest.mark.long
def test_a_lone_tag_near_the_wall_locates_the_area_once_the_robot_stands_still():
    # The robot drives up to the wall, turns until one tag is left in the frame, and stops.
    path = Path(Pose(-2.2, 0.05, 0), ((1.3, 0.6, 0), (2.1, 0, 0.3), (3, 0, 0)))
    frames = list(drive(path, 190, **USUAL))
    errors = follow(Tracker(), frames)
    assert_never_wrong(errors, frames)
    assert not np.isnan(errors[-30:]).any()


@pytest.mark.parametrize('covered, px', [([3], 0.6), ([1, 2], 1.2), ([2, 4], 1.2), ([2, 3, 4], 5.0),
                                         ([1, 2, 3], 5.0)])
def test_the_area_stays_while_tags_are_covered(covered, px):
    frames = list(drive(SLOW, 75, lambda number: covered if number >= 15 else (), **USUAL))
    errors = follow(Tracker(), frames)
    assert rms(errors[15:]) < px
    assert_never_wrong(errors, frames)


@pytest.mark.long
def test_the_area_is_there_although_every_tag_is_hidden_now_and_then():
    frames = list(drive(LIVELY, 300, at_random(300, seed=4), **USUAL))
    errors = follow(Tracker(), frames)
    assert np.mean(~np.isnan(errors[:, 0])) >= 0.99
    assert_never_wrong(errors, frames)


@pytest.mark.parametrize('look', [{'smear': 9}, {'light': 0.75}, {'quality': 50}], ids=str)
def test_the_area_is_there_despite_blur_shade_and_compression(look):
    frames = list(drive(LIVELY, 60, noise=2.0, **look))
    errors = follow(Tracker(), frames)
    assert np.mean(~np.isnan(errors[:, 0])) >= 0.98
    assert_never_wrong(errors, frames)


@pytest.mark.parametrize('hold', [0.0, 0.3, 1.0])
def test_the_area_is_held_without_tags_and_then_gone(hold):
    frames = list(drive(STILL, 50, lambda number: [1, 2, 3, 4] if number >= 10 else (), noise=2.0))
    errors = follow(Tracker(hold=hold), frames)
    last = frames[9].stamp
    for frame, error in zip(frames[10:], errors[10:]):
        assert np.isnan(error[0]) == (frame.stamp - last > hold + 1e-6)
    assert np.nanmax(errors) < 1.0


def test_everything_is_forgotten_if_the_time_goes_back():
    frames = list(drive(STILL, 20, lambda number: [1] if number >= 10 else ()))
    tracker = Tracker()
    assert not np.isnan(follow(tracker, frames)).any()
    assert tracker.update(frames[15].image, 0.1) is None
    assert tracker.update(frames[0].image, 0.2) is not None


def test_everything_is_forgotten_if_the_size_of_the_frames_changes():
    tracker = Tracker()
    frames = list(drive(STILL, 2))
    assert not np.isnan(follow(tracker, frames)).any()
    small = next(drive(STILL, 1, size=(320, 240), covered=lambda number: [1]))
    assert tracker.update(small.image, 0.2) is None


def test_frames_with_the_same_stamp_are_accepted():
    wall = replace(WALL, plaster=0)  # nothing shows the area without tags
    frames = list(drive(SLOW, 60, lambda number: WALL.area if number >= 30 else (), wall=wall, **USUAL))
    errors = follow(Tracker(), [frame._replace(stamp=7.0) for frame in frames])
    assert errors[:30].max() < 0.7
    assert np.isnan(errors[45:]).all()


@pytest.mark.parametrize('arguments, words', [
    ({'hold': -1}, 'held for -1'), ({'hold': 'long'}, 'held for long'),
    ({'upright': 'up'}, '"up".*tags, image')])
def test_wrong_arguments_are_explained(arguments, words):
    with pytest.raises(InputError, match=words):
        Tracker(**arguments)


def test_gray_frames_are_accepted():
    frames = [frame._replace(image=cv2.cvtColor(frame.image, cv2.COLOR_BGR2GRAY)) for frame in drive(SLOW, 10)]
    assert follow(Tracker(), frames).max() < 0.3


@pytest.mark.parametrize('color', [WALL.color, (30, 40, 50)], ids=['light', 'dark'])
@pytest.mark.parametrize('quiet', [0.5, 0.25])
def test_margins_may_be_narrow_on_a_wall_of_any_shade(quiet, color):
    frames = list(drive(LIVELY, 60, wall=replace(WALL, quiet=quiet, color=color), **USUAL))
    tracker, found = Tracker(), 0
    errors = []
    for frame in frames:
        errors.append(np.linalg.norm(tracker.update(frame.image, frame.stamp).corners - frame.corners, axis=1))
        found += len(tracker.tags)
    assert rms(np.array(errors)) < 0.2 and found == 4 * len(frames)


@pytest.mark.long
@pytest.mark.parametrize('quiet, look, most', [
    (0.25, {'blur': 0.7}, 0.3), (0, {'blur': 0.7, 'posters': ()}, 0.3), (0.4, {'blur': 2.0}, 0.6),
    (0.4, {'quality': 25}, 0.3), (0.4, {'exposure': lambda number: 2.2, 'blur': 0.7}, 0.5),
    (0.4, {'exposure': lambda number: 2**(1.5 * np.sin(number / 10)), 'blur': 0.7}, 0.4),
    (0.4, {'hand': 2.0, 'shutter': 25.0, 'blur': 0.7}, 0.4)])
def test_tags_are_tracked_under_poor_conditions(package, quiet, look, most):
    """Narrow or no margins, a painting, blur, compression, overexposure, a moving hand, a rolling shutter."""
    painting = Poster(package + '/images/earth.jpg', 0, 0.55, 1.5, 1.0)
    look = dict(look)
    wall = replace(WALL, quiet=quiet, posters=look.pop('posters', (painting,)))
    frames = list(drive(LIVELY, 60, wall=wall, noise=2.0, **look))
    errors = follow(Tracker(), frames)
    assert not np.isnan(errors).any() and rms(errors[10:]) < most
    assert_never_wrong(errors, frames)


@pytest.mark.long
@pytest.mark.parametrize('away, look, quick, least, most', [
    (6.5, {'blur': 0.7, 'noise': 2.0}, 10, 50, 0.4),
    (4.7, {'blur': 1.0, 'noise': 3.0, 'quality': 40, 'hand': 2.0, 'shutter': 25.0,
           'exposure': lambda number: 2**(0.8 * np.sin(number / 10))}, 10, 40, 1.0)])
def test_small_tags_on_a_painting_are_found_soon(package, away, look, quick, least, most):
    """Tags of 16 px; and of 22 px under many poor conditions at once."""
    painting = Poster(package + '/images/earth.jpg', 0, 0.55, 1.5, 1.0)
    path = Path(Pose(-away, 0.1, -0.01), ((3, 0.1, 0.01),))
    frames = list(drive(path, 60, wall=replace(WALL, quiet=0.4, posters=(painting,)), **look))
    errors = follow(Tracker(), frames)
    known = ~np.isnan(errors[:, 0])
    assert known[:quick].any() and known.sum() >= least and rms(errors[known]) < most
    assert_never_wrong(errors, frames)


def test_tags_of_14_px_are_tracked():
    frames = list(drive(Path(Pose(-7.4, 0.1, -0.01), ((3, 0.1, 0.01),)), 60, noise=2.0, blur=0.5))
    errors = follow(Tracker(), frames)
    assert not np.isnan(errors[10:]).any() and rms(errors[10:]) < 0.25


def test_a_lone_small_tag_does_not_locate_the_area():
    """The bias of its corners is the same in every frame, so more frames do not help."""
    wall = replace(WALL, plaster=0, tags=tuple(replace(tag, side=0.07) for tag in WALL.tags))
    frames = list(drive(STILL, 90, lambda number: (1, 2, 3) if number >= 30 else (), wall=wall, noise=2.0))
    tracker = Tracker()
    follow(tracker, frames[:30])
    tracker.update(np.zeros_like(frames[0].image), 1.0)
    shown = later(frames[30:], 5.0)  # after a pause, nothing else is known
    assert tracker.update(shown[0].image, shown[0].stamp) is None
    assert np.isnan(follow(tracker, shown[1:])).all()


def test_the_frame_is_not_changed():
    frame = next(drive(STILL, 1))
    before, tracker = frame.image.copy(), Tracker()
    for number in range(3):
        tracker.update(frame.image, number / 30)
    np.testing.assert_array_equal(frame.image, before)


@pytest.mark.parametrize('shape', [(480, 640, 3), (1, 1, 3), (2, 900), (64, 48, 3)])
def test_frames_without_tags_are_accepted(random, shape):
    tracker = Tracker()
    for number in range(4):
        assert tracker.update(random.randint(0, 256, shape).astype(np.uint8), number / 30) is None
