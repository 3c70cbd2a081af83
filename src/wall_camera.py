#!/usr/bin/env python3
"""A stand-in for the ROSbot and its camera: drives before a wall with tags, and shows it."""
import numpy as np
import rospy
import tf2_ros
from aruco_ar.errors import InputError
from aruco_ar.files import package_folder
from aruco_ar.render import WallRenderer
from aruco_ar.robot import MAX_ANGULAR, MAX_LINEAR, Camera, Pose, drive, load_path, wall_to_camera
from aruco_ar.wall import load_wall
from aruco_node.exercise import CAMERA
from aruco_node.memory import keep_memory
from aruco_node.node import parameter, run_node
from aruco_node.publishing import ImagePublisher
from aruco_node.settings import number
from aruco_node.wall_messages import fixed_transforms, observe, robot_transform
from dynamic_reconfigure.server import Server
from geometry_msgs.msg import Twist
from unit5.cfg import WallCameraConfig

LOOK = {'noise': (2.0, 100), 'blur': (0.0, 20), 'light': (0.3, 1)}  # default and most
COMMAND_S = 0.5  # a robot that hears no command for this long stops
START = Pose(-2.2, 0.0, 0.0)


def check_look(get):
    """Check the parameters of LOOK; ``get(name, default)`` looks one up. Raises InputError."""
    for name, (default, most) in LOOK.items():
        number(get, name, default, 0, most)


class Driver:
    """Where the robot is: along the path, until the first /cmd_vel takes over."""

    def __init__(self, path):
        self._path = path
        self._pose = path.start if path else START
        self._speed = 0.0, 0.0
        self._commanded = None
        self._began = self._moved = rospy.Time.now()
        rospy.Subscriber('cmd_vel', Twist, self._on_command, queue_size=1)

    def _on_command(self, command):
        speed = np.array([command.linear.x, command.angular.z])
        if not np.all(np.isfinite(speed)):
            rospy.logwarn_once('A /cmd_vel that is not a number was passed over.')
            return
        limit = [MAX_LINEAR, MAX_ANGULAR]
        self._speed = tuple(np.clip(speed, np.negative(limit), limit))
        self._commanded = rospy.Time.now()

    def now(self, stamp):
        """(Pose, linear, angular) at that time."""
        seconds = max(0.0, (stamp - self._moved).to_sec())  # 0 where the clock was set back
        self._moved = stamp
        if self._path and self._commanded is None:
            self._pose, linear, angular = self._path.at((stamp - self._began).to_sec())
            return self._pose, linear, angular
        if self._commanded is None or abs((stamp - self._commanded).to_sec()) > COMMAND_S:
            self._speed = 0.0, 0.0
        self._pose = drive(self._pose, *self._speed, seconds)
        return (self._pose,) + self._speed


class WallCamera:
    """Publishes what the robot sees, where it is, and the truth about both."""

    def __init__(self):
        distortion = parameter('distortion', [0.0] * 5)
        if not (isinstance(distortion, list) and len(distortion) == 5
                and all(isinstance(value, (int, float)) for value in distortion)):
            raise InputError('The parameter ~distortion is %s; it must be five numbers: k1, k2, p1, '
                             'p2, k3.' % (distortion,))
        self._camera = Camera(distortion=distortion)
        self._wall = load_wall(parameter('wall', package_folder() + '/config/wall.yaml'))
        check_look(parameter)  # what is too large, the server would cut without a word
        self._seed = int(number(parameter, 'seed', 0, 0, 2**31))
        Server(WallCameraConfig, self._reconfigure)
        self._rate = number(parameter, 'rate', 30.0, 0.1, 1000)
        path = parameter('path', '')
        self._driver = Driver(load_path(path) if path not in ('', 'none') else None)

        self._image = ImagePublisher(CAMERA, encoding='rgb8')
        self._publishers = {}
        self._transforms = tf2_ros.TransformBroadcaster()
        self._fixed = tf2_ros.StaticTransformBroadcaster()
        self._fixed.sendTransform(fixed_transforms(rospy.Time.now()))

    def _reconfigure(self, config, level):
        """What dynamic_reconfigure calls, first with the node's parameters; returns what it becomes."""
        try:
            check_look(config.get)
        except InputError as error:
            rospy.logerr('%s Nothing is changed.', error)
            return self._config
        config.update({name: float(config[name]) for name in LOOK})  # of noise:=5 a whole number came
        self._config = config
        self._renderer = WallRenderer(self._wall, self._camera, noise=config['noise'], blur=config['blur'],
                                      light=config['light'], seed=self._seed)
        return config

    def spin(self):
        """Publish until shutdown, each frame stamped with the very time at which it is due."""
        start, count = rospy.Time.now(), 0
        while not rospy.is_shutdown():
            late = (rospy.Time.now() - start).to_sec() * self._rate
            if late < count - 1:  # the clock was set back
                start, count, late = rospy.Time.now(), 0, 0
            count = max(count + 1, int(late))  # what cannot be rendered in time is left out
            stamp = start + rospy.Duration(count / self._rate)
            try:
                rospy.sleep(stamp - rospy.Time.now())
            except rospy.ROSTimeMovedBackwardsException:
                continue
            except rospy.ROSInterruptException:
                return
            self._publish(stamp)

    def _publish(self, stamp):
        pose, linear, angular = self._driver.now(stamp)
        header, messages = observe(self._wall, self._camera, pose, linear, angular, stamp)
        for topic, message in messages.items():
            if topic not in self._publishers:
                self._publishers[topic] = rospy.Publisher(topic, type(message), queue_size=1)
            self._publishers[topic].publish(message)
        self._transforms.sendTransform(robot_transform(pose, stamp))
        if self._image.has_listeners():
            self._image.publish(self._renderer.render(*wall_to_camera(pose)), header)


if __name__ == '__main__':
    keep_memory()
    run_node('wall_camera', lambda: WallCamera().spin())
