"""The launch file that shows the wall in Gazebo, tested without Gazebo."""
import os
import re
import subprocess

WORLD = 'worlds/wall.world'


def launch(*arguments, **environment):
    done = subprocess.run(['roslaunch', *arguments], env=dict(os.environ, **environment),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    return done.stdout


def test_the_launch_file_lists_its_arguments_without_gazebo():
    assert 'place the ROSbot in front of the wall' in launch('--ros-args', 'unit5', 'wall_gazebo.launch')


def test_the_launch_file_starts_gazebo_and_the_rosbot(package, tmp_path):
    """Stand-ins replace Gazebo's packages, which are not installed everywhere."""
    files = {'gazebo_ros/launch/empty_world.launch':
             '<launch><arg name="world_name"/><arg name="gui"/>'
             '<node name="gazebo" pkg="gazebo_ros" type="gzserver" args="$(arg world_name)"/></launch>',
             'gazebo_ros/gzserver': '', 'gazebo_ros/spawn_model': '',
             'rosbot_description/urdf/rosbot.xacro': '<robot/>',
             'robot_state_publisher/robot_state_publisher': '',
             'bin/xacro': '#!/bin/sh\ncat "$1"\n'}
    for path, text in files.items():
        place = tmp_path / path
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text)
        place.chmod(0o755)
        name = path.split('/')[0]
        (tmp_path / name / 'package.xml').write_text(
            '<package><name>%s</name><version>0.0.0</version><description/><license/>'
            '<maintainer email="one@example.com">one</maintainer></package>' % name)
    environment = dict(ROS_PACKAGE_PATH='%s:%s' % (tmp_path, os.environ['ROS_PACKAGE_PATH']),
                       PATH='%s/bin:%s' % (tmp_path, os.environ['PATH']), GAZEBO_MODEL_PATH='/others')
    start = launch('--args', '/gazebo', 'unit5', 'wall_gazebo.launch', **environment)
    assert 'GAZEBO_MODEL_PATH="%s/gazebo/models:/others"' % package in start
    assert ' %s/gazebo/%s ' % (package, WORLD) in start
    with open(package + '/nodes/wall_camera.py') as file:
        x, y, heading = re.search(r'START = Pose\((.*), (.*), (.*)\)', file.read()).groups()
    spawn = launch('--args', '/spawn_rosbot', 'unit5', 'wall_gazebo.launch', **environment)
    assert '-x %s -y %s -z 0.05 -Y %s ' % (x, y, heading) in spawn
    alone = launch('--nodes', 'unit5', 'wall_gazebo.launch', 'robot:=false', **environment)
    assert alone.split() == ['/gazebo']
