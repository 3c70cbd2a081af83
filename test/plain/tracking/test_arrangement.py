"""Tags that are moved, shared or duplicated: which arrangement is learned, and when."""
from dataclasses import replace

import pytest
from aruco_ar import Tracker
from aruco_ar.simulation.robot import Path, Pose
from aruco_ar.walls.wall import WallTag
from rig.accuracy.areas import USUAL, assert_never_wrong, follow, later, rms
from rig.accuracy.drives import SLOW, STILL, WALL, drive


def wall_with_moved_tag(tag_id, **place):
    """The wall with one tag in another place."""
    return replace(WALL, tags=tuple(replace(tag, **place) if tag.id == tag_id else tag for tag in WALL.tags))


REARRANGED = {
    'one moved': wall_with_moved_tag(3, x=0.2, y=0.4),
    'two swapped': replace(WALL, area=(2, 1, 3, 4), tags=tuple(
        replace(tag, id={1: 2, 2: 1}.get(tag.id, tag.id)) for tag in WALL.tags)),
    'all swapped': replace(WALL, area=(4, 3, 2, 1), tags=tuple(
        replace(tag, id=5 - tag.id) for tag in WALL.tags)),
    'larger tags in the same places': replace(WALL, tags=tuple(replace(tag, side=0.25) for tag in WALL.tags)),
    'all farther apart': replace(WALL, tags=tuple(
        replace(tag, x=1.2 * tag.x, y=0.55 + 1.2 * (tag.y - 0.55)) for tag in WALL.tags)),
}


@pytest.mark.parametrize('wall', REARRANGED.values(), ids=REARRANGED)
def test_rearranged_tags_are_learned_again_and_meanwhile_no_area_is_wrong(wall):
    tracker = Tracker()
    follow(tracker, drive(SLOW, 20, **USUAL))
    frames = later(drive(SLOW, 45, wall=wall, **USUAL), 20 / 30)
    errors = follow(tracker, frames)
    assert_never_wrong(errors, frames)
    assert rms(errors[30:]) < 0.7


def test_another_scene_is_learned_at_once():
    other = replace(WALL, area=(11, 12, 13, 14), tags=tuple(
        replace(tag, id=tag.id + 10, x=tag.x * 0.7 + 0.1) for tag in WALL.tags))
    tracker = Tracker()
    follow(tracker, drive(SLOW, 20, **USUAL))
    assert follow(tracker, later(drive(SLOW, 5, wall=other, **USUAL), 20 / 30)).max() < 0.7


def test_another_scene_that_shares_a_tag_is_learned_at_once():
    other = replace(WALL, area=(1, 12, 13, 14), tags=tuple(
        replace(tag, id=tag.id + 10 if tag.id > 1 else 1, x=tag.x * 0.7 + 0.1) for tag in WALL.tags))
    tracker = Tracker()
    follow(tracker, drive(SLOW, 20, **USUAL))
    assert follow(tracker, later(drive(SLOW, 5, wall=other, **USUAL), 20 / 30)).max() < 0.7


@pytest.mark.parametrize('covered', [[], [3], [1, 3]])
def test_the_area_survives_a_jerk_of_the_camera(covered):
    start = Pose(-2.2, 0.1, -0.05)
    path = Path(start, ((0.5, 0, 0), (1 / 30, 0, 1.5), (1, 0, 0)))  # a turn by 28 px in one frame
    errors = follow(Tracker(), drive(path, 40, lambda number: covered if number > 5 else (), **USUAL))
    assert rms(errors) < 1.0  # NaN if any frame had no area


def test_a_decoy_that_is_seen_briefly_is_not_learned():
    """Tag 3 is covered, and for six frames another tag 3 is in sight."""
    decoy = replace(WALL, tags=WALL.tags[:2] + WALL.tags[3:] + (WallTag(3, 0.0, 0.55, 0.18),))
    before, true = list(drive(STILL, 20, noise=2.0)), drive(STILL, 10, noise=2.0)
    tracker = Tracker()
    follow(tracker, before)
    for frame in later(drive(STILL, 6, wall=decoy, noise=2.0), 20 / 30):
        assert tracker.update(frame.image, frame.stamp) is None
    assert follow(tracker, later(true, 26 / 30)).max() < 0.7


def test_a_second_tag_with_the_same_id_does_not_matter():
    decoy = replace(WALL, tags=(WallTag(3, 0.0, 0.55, 0.18),) + WALL.tags)
    tracker = Tracker()
    follow(tracker, drive(SLOW, 20, **USUAL))
    assert rms(follow(tracker, later(drive(SLOW, 45, wall=decoy, **USUAL), 20 / 30))) < 0.7


def test_a_moved_tag_hides_the_area_rather_than_dragging_it_along():
    decoy = replace(WALL, tags=WALL.tags[:2] + WALL.tags[3:] + (WallTag(3, 0.0, 0.55, 0.18),))
    tracker = Tracker()
    follow(tracker, drive(SLOW, 20, **USUAL))
    frames = later(drive(SLOW, 3, wall=replace(decoy, area=(1, 2, 4, 3)), **USUAL), 20 / 30)
    for frame in frames:
        area = tracker.update(frame.image, frame.stamp)
        assert area is None


def test_more_tags_are_learned_and_keep_the_area_in_place():
    wall = replace(WALL, tags=WALL.tags + (WallTag(8, 0.0, 0.9, 0.14, 20.0), WallTag(9, 0.0, 0.25, 0.14)))
    frames = list(drive(SLOW, 120, lambda number: [8, 9] if number < 5 else WALL.area if number >= 75 else (),
                        wall=wall, **USUAL))
    errors = follow(Tracker(), frames)
    assert rms(errors) < 1.0


def test_other_tags_keep_the_area_in_place_if_four_ids_are_given():
    wall = replace(WALL, tags=WALL.tags + (WallTag(8, 0.0, 0.9, 0.14, 20.0), WallTag(9, 0.0, 0.25, 0.14)))
    frames = list(drive(SLOW, 120, lambda number: WALL.area if number >= 75 else (), wall=wall, **USUAL))
    tracker = Tracker(ids=WALL.area)
    assert rms(follow(tracker, frames[:75])) < 0.3
    assert {tag.id for tag in tracker.tags} == set(WALL.area)
    assert rms(follow(tracker, frames[75:])) < 1.0
    assert tracker.tags == []  # none of the given ids is in sight
