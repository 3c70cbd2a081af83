"""Which tags are believed: those that are as sharp as ever, and in their places."""
import numpy as np
from aruco_ar import Tag
from aruco_ar.tracking.sharpness import Sharpness
from aruco_ar.tracking.strays import Strays

SQUARE = np.float32([[0, 0], [40, 0], [40, 40], [0, 40]])


def tags_like(*likeness):
    return [Tag(number, SQUARE, like) for number, like in enumerate(likeness)]


def test_tags_are_blurred_that_were_sharper_before():
    sharpness, blurred, sharp = Sharpness(), Tag(1, SQUARE, 0.95), Tag(2, SQUARE, 0.999)
    assert sharpness.take_in(tags_like(1.0, 0.999, 0.998, 1.0))
    assert sharpness.is_blurred(blurred) and not sharpness.is_blurred(sharp)
    assert not sharpness.take_in(tags_like(1.0, 0.95, 1.0, 1.0))


def test_tags_that_are_never_sharp_are_believed_after_a_while():
    """Before that, something may cover a part of one."""
    sharpness = Sharpness()
    known = [sharpness.take_in(tags_like(0.95, 0.96, 0.95, 0.97)) for _ in range(30)]
    assert not any(known[:10]) and all(known[20:])
    assert not sharpness.is_blurred(Tag(1, SQUARE, 0.945)) and sharpness.is_blurred(Tag(1, SQUARE, 0.9))


def test_a_tag_that_is_off_for_a_moment_only_seems_so():
    strays = Strays()
    assert not strays.note([3], 1.0) and not strays.note([3], 1.4)
    assert not strays.note([], 1.45) and not strays.note([3], 1.5) and not strays.note([3, 4], 1.9)
    assert strays.note([3], 2.0)


def test_a_tag_that_is_far_off_was_moved():
    seen = {5: Tag(5, SQUARE), 6: Tag(6, SQUARE)}
    assert Strays.moved(seen, {5: SQUARE + (25, 0), 6: SQUARE + (10, 10)}) == {5}
