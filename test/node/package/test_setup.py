"""script/setup and script/env find a ROS in /opt/ros, and one in conda. Both are imitated with Debian's own."""
import json
import os
import re
import shutil
import subprocess

import pytest
from rig.systems.ros import add_python, create_ros


@pytest.fixture
def copy(package, tmp_path):
    """A copy of the package, in which nothing is built."""
    into = tmp_path / 'unit5'
    shutil.copytree(package, str(into), ignore=shutil.ignore_patterns('.git', '.venv', 'build', '__pycache__'))
    return into


@pytest.fixture
def ros(tmp_path):
    """An empty folder that is /opt/ros for what bash() runs."""
    return tmp_path / 'opt' / 'ros'


@pytest.fixture
def bash(copy, tmp_path):
    """A function that runs a line of bash in the copy, as in a new shell. It returns (exit code, output).

    tmp_path/opt is mounted as /opt, and tmp_path/programs comes first on PATH.
    """
    (tmp_path / 'opt' / 'ros').mkdir(parents=True)
    mounted = ['unshare', '--map-root-user', '--mount', 'bash', '-c', 'mount --bind "$0" /opt && exec "$@"',
               str(tmp_path / 'opt')]
    if shutil.which('unshare') is None or subprocess.run([*mounted, 'true'],
                                                         stderr=subprocess.DEVNULL).returncode:
        pytest.skip('folders cannot be mounted here')

    def run(line, **variables):
        clean = {'HOME': str(tmp_path), 'PATH': '%s:/usr/bin:/bin' % (tmp_path / 'programs'),
                 'PIP_NO_INDEX': '1', **variables}
        done = subprocess.run([*mounted, 'bash', '-c', line], cwd=str(copy), env=clean, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        return done.returncode, done.stdout
    return run


def create_program(tmp_path, name, line):
    path = tmp_path / 'programs' / name
    path.parent.mkdir(exist_ok=True)
    path.write_text('#!/bin/sh\n%s\n' % line)
    path.chmod(0o755)


@pytest.fixture
def empty_apt(tmp_path):
    """An apt that has no packages, and with which nothing is installed."""
    for name, line in ('dpkg-query', 'exit 1'), ('apt-cache', ''), ('apt-get', '[ "$1" = update ]'):
        create_program(tmp_path, name, line)


@pytest.fixture
def no_apt(tmp_path):
    for name in 'dpkg-query', 'apt-cache', 'apt-get', 'sudo':
        create_program(tmp_path, name, 'echo "$0 was called"; exit 1')


def create_empty_ros(folder, version=1):
    """What script/setup looks for, and no more."""
    folder.mkdir(parents=True)
    (folder / 'setup.bash').write_text('export ROS_DISTRO=%s\n' % folder.name)
    if version == 1:
        (folder / 'share' / 'catkin').mkdir(parents=True)


@pytest.mark.parametrize('there, sourced, chosen', [
    ('noetic', None, 'noetic'), ('one', None, 'one'), ('one noetic', None, 'noetic'),
    ('one noetic', 'one', 'one'), ('one', 'noetic', 'one'), ('noetic obese', 'obese', 'obese'),
    ('obese', None, 'obese'), ('one', 'Debian', 'one')])
def test_the_ros_of_several_is_chosen_and_its_packages_asked_for(there, sourced, chosen, ros, bash, empty_apt):
    for name in there.split():
        create_empty_ros(ros / name)
    create_empty_ros(ros / 'humble', version=2)
    code, output = bash('script/setup', **({} if sourced is None else {'ROS_DISTRO': sourced}))
    assert code == 1
    assert output.startswith('setup: the ROS is the one in /opt/ros/%s\n' % chosen), output
    lacking = re.search(r'apt does not have (.*); it needs all sources', output)[1].split()
    assert 'ros-%s-cv-bridge' % chosen in lacking and 'python3-yaml' in lacking
    assert {name.split('-')[1] for name in lacking if name.startswith('ros-')} == {chosen}


def test_of_several_others_one_has_to_be_chosen(ros, bash, empty_apt):
    for name in 'obese', 'kinetic':
        create_empty_ros(ros / name)
    code, output = bash('script/setup')
    assert code == 1 and output == (
        'setup: there are several ROS: /opt/ros/kinetic /opt/ros/obese. Choose one, and run script/setup '
        'again: source /opt/ros/kinetic/setup.bash\n')
    assert 'ros-obese-catkin' in bash('source /opt/ros/obese/setup.bash; script/setup')[1]


@pytest.mark.parametrize('version', [None, 2])
def test_without_another_ros_it_is_debians(version, ros, bash, empty_apt, tmp_path):
    """An environment of conda that has no ROS, or a ROS 2, changes nothing."""
    if version:
        create_empty_ros(ros / 'humble', version)
        create_empty_ros(tmp_path / 'conda', version)
    code, output = bash('script/setup', CONDA_PREFIX=str(tmp_path / 'conda'))
    assert code == 1 and output.startswith('setup: apt does not have '), output
    assert ' python3-rospy ' in output and 'ros-noetic' not in output


def test_where_there_is_neither_apt_nor_conda_it_says_what_there_has_to_be(bash, tmp_path):
    for name in 'bash', 'cat', 'readlink', 'dirname', 'awk', 'grep', 'sh', 'env':
        create_program(tmp_path, name, 'exec %s "$@"' % shutil.which(name, path='/usr/bin:/bin'))
    code, output = bash('PATH=%s script/setup' % (tmp_path / 'programs'))
    assert code == 1 and output.startswith('setup: there is no apt, and no ROS in conda: unit5 needs'), output


def test_what_conda_lacks_is_named_with_the_command(bash, no_apt, tmp_path, package):
    conda = tmp_path / 'conda'
    create_empty_ros(conda)
    with open(package + '/script/packages.txt') as file:
        needed = set(re.findall(r'ros-noetic-(\S+) +run', file.read()))
    for name in needed - {'cv-bridge', 'image-view'}:
        (conda / 'share' / name.replace('-', '_')).mkdir(exist_ok=True)
        (conda / 'share' / name.replace('-', '_') / 'package.xml').touch()
    code, output = bash('script/setup', CONDA_PREFIX=str(conda))
    assert code == 1 and output.splitlines() == [
        'setup: the ROS is the one in %s' % conda,
        'setup: %s lacks some packages; install them, and run script/setup again: conda install '
        '-c robostack-noetic -c conda-forge ros-noetic-cv-bridge ros-noetic-image-view' % conda]


NEEDS_DEBIANS = pytest.mark.skipif(not os.path.exists('/usr/share/catkin'), reason="Debian's ROS is imitated")
ASKED = 'source script/env; echo $ROS_DISTRO; type -p roscore; roscd unit5; pwd; ' \
        'rosrun unit5 artag_generator.py --ids 5 --output made > wrote; ' \
        'roslaunch --nodes unit5 exercise5_6.launch; ' \
        'python3 -c "import rospy, unit5.msg, sys; print(sys.base_prefix)"'


@NEEDS_DEBIANS
@pytest.mark.long
def test_the_package_is_built_with_ros_one_and_a_new_shell_finds_it(ros, bash, copy, tmp_path):
    create_ros(str(ros / 'one'), 'one', str(tmp_path / 'scratch'))
    create_program(tmp_path, 'dpkg-query', 'echo install ok installed')
    code, output = bash('script/setup')
    assert code == 0 and output.startswith('setup: the ROS is the one in /opt/ros/one\n'), output
    code, output = bash(ASKED)
    assert output.splitlines() == ['one', '/opt/ros/one/bin/roscore', str(copy), '/exercise5_6', '/usr'], output
    assert (copy / 'made' / 'image_5.jpg').is_file()
    create_program(tmp_path, 'cmake', 'echo called')
    assert 'configuring' not in bash('script/setup')[1]
    (ros / 'one').rename(ros / 'noetic')
    assert 'setup: configuring build/\n' in bash('script/setup')[1]


@NEEDS_DEBIANS
@pytest.mark.long
def test_the_package_is_built_with_conda_and_a_new_shell_finds_it(bash, copy, no_apt, tmp_path):
    conda = str(tmp_path / 'conda')
    create_ros(conda, 'noetic', str(tmp_path / 'scratch'))
    add_python(conda)
    code, output = bash('script/setup', CONDA_PREFIX=conda)
    assert code == 0 and 'was called' not in output, output
    assert "are conda's own, for which its cv_bridge is built\n" in output
    code, output = bash(ASKED)
    assert output.splitlines() == ['noetic', conda + '/bin/roscore', str(copy), '/exercise5_6', conda], output
    assert (copy / 'made' / 'image_5.jpg').is_file()
    assert bash('script/setup', CONDA_PREFIX=conda)[1].count('\n') == 2  # nothing is made anew


def test_the_containers_use_the_commands_of_readme_and_nothing_else(package):
    def lines(name):
        with open(os.path.join(package, name)) as file:
            return file.read().splitlines()
    docker = dict(line.split(' ', 1) for line in lines('Dockerfile') if not line.startswith('#'))
    container = json.loads('\n'.join(lines('.devcontainer/devcontainer.json')))
    setup, demo = docker.pop('RUN'), json.loads(docker.pop('CMD'))
    assert [setup, *demo] == [container['postCreateCommand'], container['postAttachCommand']]
    assert docker.pop('FROM') == container['image'] == 'debian:12' and set(docker) == {'COPY', 'WORKDIR'}
    page = '\n'.join(lines('README.md'))
    for command in (setup, *demo):
        assert '`%s`' % command in page and os.access(os.path.join(package, command), os.X_OK)
