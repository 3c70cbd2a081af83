"""Parameters: which values are allowed, and how others are explained."""
import pytest
from aruco_ar import InputError
from aruco_ar.settings.declaration import parameters_of
from aruco_node.parameters.parameters import read, ros_values
from aruco_node.parameters.settings import PictureSettings, PoseSettings, load_areas


def settings(kind=PictureSettings, **parameters):
    return read(kind, parameters.get)


def test_without_parameters_the_defaults_are_used():
    assert settings() == PictureSettings()
    assert settings(PoseSettings) == PoseSettings()


@pytest.mark.parametrize('kind', [PictureSettings, PoseSettings])
def test_settings_survive_a_round_trip_through_the_parameter_server(kind):
    given = settings(kind, ids=[4, 3, 2, 1], **({'tag_sizes': {'7': 0.1}} if kind is PoseSettings else {}))
    assert settings(kind, **ros_values(given)) == given
    assert all(isinstance(value, (str, float, bool)) for value in ros_values(given).values())


@pytest.mark.parametrize('kind', [PictureSettings, PoseSettings])
def test_every_parameter_is_described(kind):
    for name, parameter in parameters_of(kind).items():
        assert parameter.what and parameter.kind.allowed, name


@pytest.mark.parametrize('sizes', [
    {'7': 0.1, '8': 0.25}, {7: 0.1, 8: 0.25}, '7: 0.1, 8: 0.25', '{7: 0.1, 8: 0.25}'])
def test_tag_sizes_may_be_a_dict_or_text(sizes):
    assert settings(PoseSettings, tag_sizes=sizes).tag_sizes == ((7, 0.1), (8, 0.25))


@pytest.mark.parametrize('name, value, allowed', [
    ('tag_size', 0, 'from 0.001 to 10'), ('tag_size', 'big', 'a number'), ('tag_sizes', '7', 'such as 7: 0.1'),
    ('tag_sizes', '7: wide', 'such as 7: 0.1'), ('tag_sizes', {'7': 11}, 'such as 7: 0.1'),
    ('tag_sizes', '7: 0.1, 250: 0.1', 'id 250 is not in DICT_6X6_250'),
    ('tag_sizes', 5, 'such'), ('tag_frame', 'tag', '{id}'), ('wall', '', 'learn, or the path'),
    ('rectified', 'yes', 'true, false or auto')])
def test_a_wrong_parameter_of_tag_poses_is_explained(name, value, allowed):
    with pytest.raises(InputError) as error:
        settings(PoseSettings, **{name: value})
    assert '~' + name in str(error.value) and allowed in str(error.value)


@pytest.mark.parametrize('ids', [[4, 3, 2, 1], '4, 3, 2, 1', '4 3 2 1', '[4,3,2,1]'])
def test_ids_may_be_a_list_or_text(ids):
    assert settings(ids=ids).ids == (4, 3, 2, 1)


@pytest.mark.parametrize('ids', ['', 'any', []])
def test_ids_may_be_any(ids):
    assert settings(ids=ids).ids == ()


@pytest.mark.parametrize('name, value, allowed', [
    ('dictionary', 'DICT_6X6_260', 'DICT_6X6_250'), ('dictionary', 7, 'one of'),
    ('ids', '1,2,3', 'four different'), ('ids', [1, 2, 3, 3], 'four different'), ('ids', 5, 'four'),
    ('ids', 'a,b,c,d', 'four'), ('ids', [1, 2, 3, 4.5], 'four'), ('ids', {'a': 1}, 'four'),
    ('scale', 0, 'from 0.01 to 4'), ('scale', -1, 'a number'), ('scale', 5, 'a number'),
    ('scale', 'big', 'a number'), ('scale', float('nan'), 'a number'), ('scale', True, 'a number'),
    ('hold', -0.1, 'from 0 to 60'), ('hold', 'long', 'a number'), ('upright', 'up', 'tags, image'),
    ('image_transport', 'theora', 'auto, raw, compressed'), ('image_transport', [], 'auto, raw, compressed'),
    ('picture', 5, 'such as topic:/other/camera'), ('picture', 'topic:', 'such as topic:/other/camera'),
    ('fit', 'squeeze', 'stretch, contain, cover'), ('opacity', 1.1, 'from 0 to 1'),
    ('folder', '', 'the path of a folder'), ('folder', 'a\0b', 'the path of a folder'),
])
def test_a_wrong_parameter_is_named_with_its_value_and_what_is_allowed(name, value, allowed):
    with pytest.raises(InputError) as error:
        settings(**{name: value})
    for words in ('~' + name, str(value).replace('\0', '\\x00'), allowed):
        assert words in str(error.value)


def test_the_areas_of_a_file_are_read(package):
    one, other = load_areas(package + '/config/areas.yaml')
    assert settings(**one).ids == (1, 2, 3, 4) and settings(**other).ids == (5, 6, 7, 8)
    assert settings(**other).fit == 'contain' and settings(**one).opacity == 1.0


@pytest.mark.parametrize('text, words', [
    ('areas: []', 'has 0 areas'), ('', 'wrong form'), ('areas: 5', 'wrong form'), ('[]', 'wrong form'),
    ('area: []', "lacks the entry 'areas'"), ('areas: [{picture: a.png}]', "lacks the entry 'ids'"),
    ('areas: [{ids: any}]', 'needs the ids of its four tags'), ('areas: [{ids: "[]"}]', 'needs the ids'),
    ('areas: [{ids: {}}]', 'needs the ids'), ('areas: [{ids: [1, 2, 3, 4], fit: foo}]', '~fit is "foo"'),
    ('[' * 5000, 'is not YAML'),
    ('areas: [{ids: [1, 2, 3, 4], colour: red}]', '"colour" is none of ids, picture'),
])
def test_a_wrong_file_of_areas_is_explained(assert_refused, text, words):
    assert_refused(load_areas, text, words)
