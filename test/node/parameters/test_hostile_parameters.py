"""Wrong and extreme values of all parameters: they are accepted, or refused with a sentence."""
import pytest
from aruco_ar import InputError
from aruco_ar.base.errors import MAX_SENTENCE
from aruco_ar.settings.declaration import parameters_of
from aruco_node.parameters.parameters import read, ros_values
from aruco_node.parameters.settings import PictureSettings
from hostile.parameters import validation, values

# One node of each settings class.
NODES = 'exercise5_2', 'exercise5_5', 'exercise5_6', 'tag_poses', 'calibrate_live', 'camera_relay', \
    'wall_camera', 'page'


@pytest.mark.parametrize('node', NODES)
def test_every_value_of_every_parameter_is_accepted_or_refused_with_a_sentence(node, random):
    kind = validation.settings_of(node)
    for name, parameter in parameters_of(kind).items():
        taken = refused = 0
        for value in values.values(parameter, random):
            sentence = validation.refusal(validation.read_with, kind, name, value)
            if sentence:
                refused += 1
                assert not validation.fault_of(sentence, name), sentence
            else:
                taken += 1
                settings = validation.read_with(kind, name, value)
                assert read(kind, ros_values(settings).get) == settings, (name, value)
        assert taken > 0 and refused > 100, name


@pytest.mark.parametrize('name, value, words', [
    ('ids', [1, 2, 3, 250], 'Tag id 250 is not in DICT_6X6_250, which has the ids 0 to 249'),
    ('ids', '1,2,3,-4', '~ids is "1,2,3,-4"'),
    ('tag_sizes', {'7': True}, "~tag_sizes is {'7': True}"), ('tag_sizes', '7: 0.1, 07: 0.2', 'such as 7: 0.1'),
    ('wall', 'two\nlines', '~wall is "two\\\\nlines"'),
    ('folder', 'x' * 10**6, '~folder is "xxx.* ... xxx.*"; it must')])
def test_values_that_look_almost_right_are_refused(name, value, words):
    with pytest.raises(InputError, match=words):
        validation.taken(validation.settings_of('tag_poses'), name, value)


@pytest.mark.parametrize('value', ['00000', [float('nan')] * 5, [1e300] * 5, [True] * 5, {'k1': 0}])
def test_the_distortion_must_be_five_numbers(value):
    with pytest.raises(InputError, match='~distortion is .*five numbers'):
        validation.read_with(validation.settings_of('wall_camera'), 'distortion', value)


def test_an_error_message_is_one_readable_line_whatever_it_quotes():
    for wrong in 'a' * 10**6, '\n' * 10**6, '\x1b[2J', '\u202e', 'é' * 1000, '\ud800':
        sentence = str(InputError('The file "%s" is wrong; give another.' % wrong))
        assert len(sentence) <= MAX_SENTENCE and sentence.isprintable()
        assert sentence.startswith('The file "') and sentence.endswith('" is wrong; give another.')
    assert str(InputError('As it is: é ☺')) == 'As it is: é ☺'


@pytest.mark.parametrize('name', ['ids', 'picture', 'opacity'])
def test_every_entry_of_a_file_of_areas_is_accepted_or_refused_with_a_sentence(name, random, tmp_path):
    path, refused = str(tmp_path / 'areas.yaml'), 0
    for value in values.short(values.values(parameters_of(PictureSettings)[name], random)):
        sentence = validation.refusal(validation.area_taken, path, name, value)
        refused += sentence is not None
        assert sentence is None or not validation.fault_of(sentence), sentence
    assert refused > 100
