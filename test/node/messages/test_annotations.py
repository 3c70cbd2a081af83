"""The marks that Foxglove draws over an image: their type, and where they are."""
import sys
import tempfile
from types import ModuleType

import numpy as np
import pytest
import rospy
from aruco_ar import Detector, InputError, find_area
from aruco_ar.simulation.render import project
from aruco_ar.simulation.robot import Camera
from aruco_node.messages.annotations import annotations, kinds

STAMP = rospy.Time(5, 6)
# Of foxglove_msgs 3.1.0, the last release for ROS 1: what Foxglove's own @foxglove/rosmsg computes from the
# definitions that it publishes as @foxglove/schemas 1.6.6.
MD5 = '685a869995712c54b6863409ecf414b1'
GREEN, RED, YELLOW, PURPLE = (0, 1, 0), (1, 0, 0), (1, 1, 0), (150 / 255, 0, 1)


@pytest.fixture(autouse=True)
def made_anew():
    kinds.cache_clear()
    yield
    kinds.cache_clear()


def color(message):
    return message.r, message.g, message.b


def pixels(points):
    """Points as (n, 2) pixels of ours: a viewer has (0, 0) at the corner of the first pixel."""
    return np.array([(point.x, point.y) for point in points]) - 0.5


def test_the_type_is_the_one_that_foxglove_publishes():
    kind = kinds().ImageAnnotations
    assert (kind._type, kind._md5sum) == ('foxglove_msgs/ImageAnnotations', MD5)


def test_the_marks_are_where_tags_and_area_are(frame, wall, view):
    tags = sorted(Detector().detect(frame), key=lambda tag: tag.id)
    message = annotations(tags, [find_area(tags)], STAMP)
    *outlines, around = message.points
    firsts, centers = message.circles[::2], message.circles[1::2]
    for number, tag in enumerate(sorted(wall.tags, key=lambda tag: tag.id)):
        corners, _ = project(tag.corners, *view, Camera())
        outline, center = outlines[number], (corners[0] + corners[2]) / 2
        assert outline.type == outline.LINE_LOOP and color(outline.outline_color) == GREEN
        np.testing.assert_allclose(pixels(outline.points), corners, atol=0.3)
        np.testing.assert_allclose(pixels([firsts[number].position])[0], corners[0], atol=0.3)
        assert color(firsts[number].fill_color) == RED
        text = message.texts[number]
        assert text.text == str(tag.id) and color(text.text_color) == YELLOW
        assert text.position == centers[number].position
        np.testing.assert_allclose(pixels([text.position])[0], center, atol=1.0)
    np.testing.assert_allclose(pixels(around.points), project(wall.area_corners, *view, Camera())[0], atol=0.3)
    assert around.type == around.LINE_LOOP and color(around.outline_color) == PURPLE
    marks = [*message.points, *message.circles, *message.texts]
    assert len(marks) == 4 + 1 + 8 + 4 and {mark.timestamp for mark in marks} == {STAMP}


def test_without_tags_there_are_no_marks():
    assert annotations([], [], STAMP) == kinds().ImageAnnotations()


@pytest.mark.parametrize('has_texts', [True, False])
def test_the_package_is_used_where_it_has_all_messages(has_texts, monkeypatch):
    package, messages = ModuleType('foxglove_msgs'), ModuleType('foxglove_msgs.msg')
    if has_texts:
        messages.TextAnnotation = object
    package.msg = messages
    monkeypatch.setitem(sys.modules, 'foxglove_msgs', package)
    monkeypatch.setitem(sys.modules, 'foxglove_msgs.msg', messages)
    assert (kinds() is messages) == has_texts


def test_a_full_disk_is_named(monkeypatch):
    def full(**_):
        raise OSError(28, 'No space left on device')
    monkeypatch.setitem(sys.modules, 'foxglove_msgs', None)
    monkeypatch.setattr(tempfile, 'mkdtemp', full)
    with pytest.raises(InputError, match='ImageAnnotations cannot be made: .*No space left.* or set TMPDIR'):
        kinds()
