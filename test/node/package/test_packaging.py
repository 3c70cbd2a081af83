"""Debian's control, RoboStack's recipe, pixi.toml and the entry for ROS One say what package.xml says."""
import os
import re
import subprocess
from xml.etree import ElementTree

import pytest
import yaml
from aruco_ar.base.versions import LOWEST

# The names in conda of keys of rosdep that are not the key without its "python3-".
CONDA = {'python3-opencv': 'py-opencv', 'python3-pil': 'pillow', 'python3-yaml': 'pyyaml'}
# The keys of the modules in LOWEST, as rosdep and Debian would call them: {key: the lowest version}.
KEYS = {'python3-' + {'cv2': 'opencv'}.get(module, module.lower()): '.'.join(map(str, version))
        for module, (_, version, _) in LOWEST.items() if module != 'python'}
NOT_IN_DEBIAN = {'python3-mcap'}
BUILD = 'buildtool_depend', 'build_depend', 'depend'
RUN = 'depend', 'exec_depend'


@pytest.fixture(scope='module')
def manifest(package):
    return ElementTree.parse(package + '/package.xml').getroot()


def dependencies(manifest, kinds):
    return {each.text for kind in kinds for each in manifest.findall(kind)}


def in_conda(key):
    """The name of a dependency in RoboStack or conda-forge."""
    if key.startswith('python3-'):
        return CONDA.get(key, key[len('python3-'):])
    return 'ros-noetic-' + key.replace('_', '-')


def without_key(manifest):
    """The keys of LOWEST that rosdep does not know."""
    return set(KEYS) - dependencies(manifest, RUN)


def fields(package):
    """The fields of both paragraphs of Debian's control, {name: text}."""
    with open(package + '/packaging/debian/control') as file:
        return dict(re.findall(r'^([\w-]+):(.*(?:\n .*)*)', file.read(), re.MULTILINE))


def names(field):
    """The packages in a field of Debian's control, {name: version}: '' if any will do."""
    return dict(re.findall(r'^ ([\w.-]+)(?: \(>= ([\w.:]+)\))?,$', field, re.MULTILINE))


def recipe(package):
    with open(package + '/packaging/robostack/recipe.yaml') as file:
        return yaml.safe_load(file)


def specs(entries):
    """Requirements of a recipe as {name: version}, without the ones that rattler-build fills in."""
    return {name: version for name, _, version in (each.partition(' ') for each in entries) if name != '${{'}


def pixi(package):
    tomllib = pytest.importorskip('tomllib')  # Python 3.11 has it
    with open(package + '/pixi.toml', 'rb') as file:
        return tomllib.load(file)


def test_all_tell_the_version_the_license_and_the_description_of_package_xml(package, manifest):
    version = manifest.find('version').text
    with open(package + '/packaging/debian/changelog') as file:
        assert file.readline().startswith('ros-unit5 (%s) ' % version)
    with open(package + '/docs/howto/install-a-wheel.md') as file:
        assert re.findall(r'aruco_ar-([\d.]+)-', file.read()) == [version]
    made = recipe(package)
    assert made['context']['version'] == version
    assert made['about']['license'] == manifest.find('license').text
    assert made['about']['summary'] == manifest.find('description').text
    with open(package + '/packaging/debian/copyright') as file, open(package + '/LICENSE') as license:
        told = re.sub(r'^ \.?', '', file.read(), flags=re.MULTILINE)
        assert 'License: ' + manifest.find('license').text in told
        assert license.read().split('\n\n', 2)[2].strip() in told


def test_debian_has_a_package_for_each_dependency(package, manifest):
    for kinds, told in ((BUILD, ['Build-Depends']), (RUN, ['Depends', 'Recommends'])):
        found = {name for field in told for name in names(fields(package)[field])}
        for key in dependencies(manifest, kinds):
            name = key.replace('_', '-')
            assert {name, 'ros-' + name, 'python3-' + name, 'lib%s-dev' % name} & found, key
    assert without_key(manifest) - NOT_IN_DEBIAN <= found


@pytest.mark.parametrize('path', ['package.xml', 'docs/howto/package.md', 'docs/howto/your-robot.md'])
def test_what_rosdep_does_not_know_is_named(package, manifest, path):
    with open(os.path.join(package, path)) as file:
        text = file.read()
    for module, (name, _, _) in LOWEST.items():
        if 'python3-' + module in without_key(manifest):
            assert re.search(r'\b%s\b' % name.split()[-1], text), name


def test_what_debian_lacks_is_told(package):
    with open(package + '/docs/howto/package.md') as file:
        assert re.findall('Debian has no package of `(.*?)`', file.read()) == [
            key[len('python3-'):] for key in NOT_IN_DEBIAN]


def test_debian_demands_the_lowest_versions(package):
    found = {**names(fields(package)['Depends']), **names(fields(package)['Recommends'])}
    for key in set(KEYS) - NOT_IN_DEBIAN:
        assert found[key].split(':')[-1] == KEYS[key], key  # before the colon is Debian's epoch


def test_the_recipe_of_robostack_has_each_dependency(package, manifest):
    needs = recipe(package)['requirements']
    assert {in_conda(key) for key in dependencies(manifest, BUILD)} <= set(specs(needs['host']))
    run = specs(needs['run'])
    assert {in_conda(key) for key in dependencies(manifest, RUN)} <= set(run)
    for key, lowest in KEYS.items():
        assert run[in_conda(key)] == '>=' + lowest


def test_pixi_has_what_script_setup_asks_of_conda(package, manifest):
    found = pixi(package)['dependencies']
    with open(package + '/script/packages.txt') as file:
        lines = [line.split() for line in file if line.strip() and not line.startswith('#')]
    assert {ros for _, ros, need in lines if need == 'run' and ros.startswith('ros-noetic-')} <= set(found)
    with open(package + '/script/locked/run.txt') as file:
        by_pip = set(re.findall('^([^ =]+)==', file.read(), re.MULTILINE))
    keys = {in_conda(key) for key in dependencies(manifest, (*BUILD, *RUN)) if key.startswith('python3-')}
    of_python = {each for each in found if not each.startswith('ros-')}
    taken = {in_conda(key) for key in ('python3-numpy', 'python3-opencv')}  # if they work with its cv_bridge
    assert keys - by_pip <= of_python and of_python & by_pip <= taken
    assert all(found[in_conda(key)] == '>=' + KEYS[key] for key in ('python3-numpy', 'python3-opencv'))


@pytest.mark.parametrize('trace', ['root/unit5', 'root/demo.log', 'usr/share/catkin'])
def test_no_package_is_made_in_a_debian_in_which_the_demo_was_run(package, tmp_path, trace):
    (tmp_path / trace).mkdir(parents=True)
    done = subprocess.run([package + '/script/fresh', 'trixie', '--package', '--folder', str(tmp_path)],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert (done.returncode, done.stdout) == (
        1, 'fresh: demo and test were run in %s; give --package another folder, or none\n' % tmp_path)


def test_each_task_of_pixi_is_a_program(package):
    for command in pixi(package)['tasks'].values():
        assert os.access(os.path.join(package, command), os.X_OK), command


def test_the_entry_for_ros_one_is_a_repository(package, manifest):
    with open(package + '/packaging/ros-one.repos') as file:
        entries = yaml.safe_load(file)['repositories']
    assert list(entries) == [manifest.find('name').text]
    assert set(entries['unit5']) == {'type', 'url', 'version'} and entries['unit5']['type'] == 'git'
