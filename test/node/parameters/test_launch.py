"""Launch files: their arguments have the parameters' defaults and descriptions, and reach the nodes."""
import glob
import os
import runpy
from functools import lru_cache

import pytest
from aruco_ar.base.files import package_folder
from aruco_ar.settings.declaration import Number, parameters_of
from aruco_node.parameters.parameters import read
from hostile.parameters import validation
from roslaunch.config import load_config_default

SCRIPT = runpy.run_path(os.path.join(package_folder(), 'script', 'remake', 'launch_args'))
FILES, FOLDER, argument_of = SCRIPT['FILES'], SCRIPT['FOLDER'], SCRIPT['argument_of']
# The values that a file gives to some nodes, whatever its argument of that name says.
EXERCISES = ['exercise5_%d' % number for number in range(2, 7)]
FIXED = {('base_station', 'transport'): dict.fromkeys(EXERCISES, 'raw'),
         **{(name, 'wall'): dict.fromkeys(EXERCISES, 'learn') for name in ('all', 'demo', 'base_station')}}


def fail(name, sentence):
    pytest.fail('launch/%s.launch: %s' % (name, sentence), pytrace=False)


def nodes(name, **arguments):
    """{name: (settings class, {parameter: value})} of this package's nodes that a launch file starts."""
    config = load_config_default([(os.path.join(FOLDER, name + '.launch'),
                                   ['%s:=%s' % item for item in arguments.items()])], None)
    return {node.name: (settings_of(node.type[:-len('.py')]),
                        {key.rpartition('/')[2]: parameter.value for key, parameter in config.params.items()
                         if key.startswith('/%s/' % node.name)})
            for node in config.nodes if node.package == 'unit5'}


@lru_cache(None)
def settings_of(node):
    """The settings class of a node."""
    return validation.settings_of(node)


@pytest.mark.parametrize('name', FILES)
def test_the_arguments_match_the_settings_of_the_nodes(name):
    text = SCRIPT['read'](name)
    found = SCRIPT['arguments_in'](text)
    for argument, wanted in FILES[name].items():
        if found.get(argument) != wanted:
            fail(name, 'the argument "%s" does not match the settings of its node. It is\n%s\n'
                       'but must be\n%s\nscript/remake/launch_args writes it.'
                 % (argument, ' '.join(found.get(argument, ['missing'])), ' '.join(wanted)))
    if SCRIPT['rewritten'](text, FILES[name]) != text:
        fail(name, 'the arguments are in another order than the parameters, or not in columns. '
                   'script/remake/launch_args puts them in order.')


@pytest.mark.parametrize('name', FILES)
def test_every_argument_reaches_every_node_with_that_parameter(name):
    known = {}
    for kind, _ in nodes(name).values():
        known.update({argument_of(parameter): each for parameter, each in parameters_of(kind).items()})
    assert set(FILES[name]) <= set(known)
    # roslaunch does not check whether a node would accept these values.
    given = {argument: number + 0.5 if isinstance(known[argument].kind, Number) else 'given %s' % argument
             for number, argument in enumerate(FILES[name])}
    for node, (kind, values) in nodes(name, **given).items():
        for parameter in parameters_of(kind):
            argument = argument_of(parameter)
            if argument in given and \
                    values.get(parameter) != FIXED.get((name, argument), {}).get(node, given[argument]):
                fail(name, 'the argument "%s" does not reach the node %s. The <node> needs <param name="%s" '
                     'value="$(arg %s)"/>. If it is in another file, the <include> needs pass_all_args="true".'
                     % (argument, node, parameter, argument))


@pytest.mark.parametrize('name', FILES)
def test_the_nodes_accept_the_default_arguments(name):
    for node, (kind, values) in nodes(name).items():
        unknown = set(values) - set(parameters_of(kind))
        if unknown:
            fail(name, 'the node %s is given "%s", but has no such parameter.' % (node, min(unknown)))
        read(kind, values.get)


def test_all_launch_files_are_compared():
    for path in glob.glob(os.path.join(FOLDER, '*.launch')):
        name = os.path.basename(path)[:-len('.launch')]
        # The launch files of programs that are no nodes of ours have their options, not parameters. The others
        # include exercise.launch.
        if 'pkg="unit5"' in SCRIPT['read'](name) and \
                name not in {*FILES, 'exercise', 'artag_generator', 'video_camera'}:
            fail(name, 'no test compares its arguments with the parameters of its nodes. Add it to FILES in '
                       'script/remake/launch_args.')
