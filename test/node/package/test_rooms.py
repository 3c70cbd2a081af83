"""What may import what, and that what the documentation shows exists."""
import ast
import glob
import os
import re

import pytest
from torture.__main__ import PARTS

LATER = ast.FunctionDef, ast.AsyncFunctionDef  # what these import is not imported when their file is loaded
INCLUDED = re.compile(r'^```\{(?:literalinclude|include)\} (\S+)', re.MULTILINE)
GENERATED = os.sep + os.path.join('docs', 'generated') + os.sep  # Sphinx makes these files: see docs/conf.py


# The folders of test/ from whose packages the files of each may import; pytest or rostest run all others.
BELOW = {'rig': set(), 'hostile': {'rig'}, 'fuzz': {'hostile', 'rig'}, 'benchmark': {'rig'},
         'torture': {'fuzz', 'hostile', 'rig'}}


def modules(package):
    """The paths of all Python files in the packages in src/."""
    return [path for room in [*glob.glob(package + '/src/aruco_*/'), package + '/src/page_server/']
            for path in glob.glob(room + '**/*.py', recursive=True)]


def imported(path, package, left_out=(), root='src'):
    """The whole names of what a file below a folder imports, except within nodes of the kinds ``left_out``."""
    own = os.path.relpath(path, os.path.join(package, root)).split(os.sep)
    with open(path, encoding='utf-8') as file:
        waiting = ast.parse(file.read()).body
    for node in waiting:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            module = '.'.join([*own[:-node.level], *filter(None, [node.module])]) if node.level else node.module
            yield from (module + '.' + alias.name for alias in node.names)
        elif not isinstance(node, left_out):
            waiting.extend(ast.iter_child_nodes(node))


def test_the_vision_the_course_and_the_desk_import_no_ros(package):
    assert len(modules(package)) > 100
    for path in modules(package):
        is_node = os.path.basename(path) == 'solution.py'  # these are the learner's nodes
        rooms = ['%s/src/%s/' % (package, room) for room in (
            'aruco_ar', 'aruco_course', 'aruco_desk', 'aruco_program', 'page_server')]
        if path.startswith(tuple(rooms)) and not is_node:
            names = {name.split('.')[0] for name in imported(path, package)}
            assert not {'rospy', 'cv_bridge', 'sensor_msgs', 'aruco_node'} & names, path


def test_the_folders_of_the_vision_do_not_import_each_other_in_a_circle(package):
    root = package + '/src/aruco_ar/'
    uses = {}  # {folder: the folders that it imports from}
    for path in modules(package):
        folder, _, file = path[len(root):].partition(os.sep)
        if path.startswith(root) and file:
            uses.setdefault(folder, set()).update(name.split('.')[1] for name in imported(path, package, LATER)
                                                  if name.startswith('aruco_ar.'))
    uses = {folder: used & (set(uses) - {folder}) for folder, used in uses.items()}
    assert sum(map(len, uses.values())) > 20
    while uses:
        free = [folder for folder, used in uses.items() if not used & set(uses)]
        assert free, 'a circle: %s' % uses
        for folder in free:
            del uses[folder]


@pytest.mark.parametrize('folder', BELOW)
def test_what_tests_share_imports_only_what_is_below_it(folder, package):
    paths = glob.glob('%s/test/%s/**/*.py' % (package, folder), recursive=True)
    assert len(paths) > 1
    others = set(os.listdir(package + '/test')) - {folder} - BELOW[folder]
    for path in paths:
        assert not {name.split('.')[0] for name in imported(path, package, root='test')} & others, path


def test_no_test_imports_from_the_scripts(package):
    scripts = {os.path.basename(path)[:-len('.py')]
               for path in glob.glob(package + '/script/**/*.py', recursive=True)}
    for path in glob.glob(package + '/test/**/*.py', recursive=True):
        assert not {name.split('.')[0] for name in imported(path, package, root='test')} & scripts, path


@pytest.mark.parametrize('part', PARTS)
def test_the_results_of_every_torture_test_are_recorded(part, package):
    assert os.path.isfile('%s/docs/results/torture_%s.txt' % (package, part))


def test_every_included_file_exists(package):
    targets = []
    for page in glob.glob(package + '/docs/**/*.md', recursive=True):
        with open(page, encoding='utf-8') as file:
            targets += [(page, os.path.normpath(os.path.join(os.path.dirname(page), target)))
                        for target in INCLUDED.findall(file.read())]
    assert len(targets) > 30
    assert [each for each in targets if GENERATED not in each[1] and not os.path.isfile(each[1])] == []
