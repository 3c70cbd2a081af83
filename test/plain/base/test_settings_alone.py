"""The settings of aruco_ar, without ROS: defaults, checks, and what is made of them."""
from dataclasses import replace

import pytest
from aruco_ar import Detector, InputError
from aruco_ar.settings.settings import AreaSettings, DetectionSettings, PictureSettings


def test_values_may_have_the_form_that_a_text_file_has():
    given = PictureSettings(ids=(4, 3, 2, 1))
    assert PictureSettings(ids='4, 3, 2, 1') == PictureSettings(ids=[4, 3, 2, 1]) == given
    assert replace(given, fit='cover').ids == given.ids == (4, 3, 2, 1)


@pytest.mark.parametrize('name, value, allowed', [
    ('ids', (1, 2, 3), 'four different'), ('fit', 'squeeze', 'stretch, contain, cover'),
    ('hold', -1, 'from 0 to 60'), ('opacity', float('nan'), 'from 0 to 1'),
    ('picture', '', 'the path of a picture')])
def test_a_wrong_value_is_named_with_what_is_allowed(name, value, allowed):
    with pytest.raises(InputError, match='^The parameter %s is .*%s' % (name, allowed)):
        PictureSettings(**{name: value})


@pytest.mark.parametrize('kind', [DetectionSettings, AreaSettings, PictureSettings])
def test_a_detector_is_made_as_the_settings_say(kind, frame):
    assert kind().of_detector() == DetectionSettings().of_detector()
    assert len(Detector(**kind().of_detector()).detect(frame)) == 4
    assert [tag.id for tag in Detector(**kind(ids=(2, 90, 91, 92)).of_detector()).detect(frame)] == [2]
