#!/usr/bin/env python3
"""A simulated ROSbot with a camera, which drives in front of a wall with tags and publishes what it sees."""
import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Any, Tuple

import aruco_program  # noqa: F401  before all else
import numpy as np
import rospy
import tf2_ros
from aruco_ar.base.files import in_package
from aruco_ar.settings.declaration import Number, Settings, choice, number, parsed, text
from aruco_ar.simulation.figures import NOBODY, VISITORS
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import (
    MAX_ANGULAR,
    MAX_LINEAR,
    Camera,
    Pose,
    drive,
    hand_held,
    load_path,
    wall_to_camera,
)
from aruco_ar.walls.wall import load_wall
from aruco_node.health.diagnostics import OK, PERIOD_S, WARN, WINDOW_S, Diagnostics
from aruco_node.health.faults import fault_barrier
from aruco_node.messages.publishing import ImagePublisher
from aruco_node.messages.wall_messages import fixed_transforms, observe, robot_transform
from aruco_node.nodes.frame_node import CAMERA
from aruco_node.nodes.manual import Manual
from aruco_node.nodes.node import read_settings, run_node
from aruco_node.parameters.reconfigure import Reconfigurer
from aruco_node.process.memory import keep_memory
from aruco_node.ros_internals.subscribers import tolerant
from geometry_msgs.msg import Twist

MAX_LATE_S = 5.0  # rendering never takes this long; if the time is later than this, the clock was set
COMMAND_S = 0.5   # without a command for this long, the robot stops
START = Pose(-2.2, 0.0, 0.0)
SWING_S = 4.0     # the period in which the exposure goes up and down
LOOP_S = 3600.0   # the motion of the hand repeats after this time, since seconds since 1970 are too large

MANUAL_TOPICS = [
    (CAMERA, 'sensor_msgs/Image', 'the frames of the camera: rgb8'),
    (CAMERA + '/compressed', 'sensor_msgs/CompressedImage', 'the same frames as JPEG'),
    ('camera/rgb/camera_info', 'sensor_msgs/CameraInfo', "the camera's calibration"),
    ('odom', 'nav_msgs/Odometry', "the robot's true pose"),
    ('/tf', 'tf2_msgs/TFMessage', 'the same pose: odom -> base_link'),
    ('/tf_static', 'tf2_msgs/TFMessage', 'base_link -> camera_rgb_optical_frame, odom -> wall'),
    ('~tags', 'unit5/TagArray', 'true corners of all tags in front of the camera'),
    ('~area', 'geometry_msgs/PolygonStamped', 'true corners of the area')]


COEFFICIENT = Number(-1000, 1000)


def coefficients(value):
    k1, k2, p1, p2, k3 = map(COEFFICIENT.read, value)
    return k1, k2, p1, p2, k3


@dataclass(frozen=True)
class WallCameraSettings(Settings):
    """The parameters. After a change of their defaults or words, run script/remake/launch_args."""

    wall: str = text(
        'config/wall.yaml', 'the path of a YAML file, which may be within the package',
        'file that describes the simulated wall and its tags', live=False)
    path: str = text(
        'none', 'none, or the full path of a YAML file',
        'file that says where the simulated robot drives until the first /cmd_vel comes. none: it stands still',
        live=False)
    rate: float = number(30.0, 0.1, 1000, 'frames per second', live=False)
    seed: float = number(0.0, 0, 2**31, 'seed of the random noise', live=False)
    distortion: Tuple[float, ...] = parsed(
        (0.0,) * 5, 'five numbers: k1, k2, p1, p2, k3', 'distortion coefficients of the lens', coefficients,
        list, live=False)
    noise: float = number(2.0, 0, 100, 'standard deviation of the noise, in gray levels')
    blur: float = number(0.0, 0, 20, 'standard deviation of the blur, in pixels')
    falloff: float = number(
        0.3, 0, 1, 'how much darker the right end of the wall is than its left end; 0: not at all')
    exposure: float = number(
        1.0, 0, 20, 'factor on the brightness of the whole frame; above 1, light parts of it turn white')
    swing: float = number(0.0, 0, 4, 'stops by which the exposure rises and falls, once in 4 seconds')
    hand: float = number(
        0.0, 0, 10, 'how much the camera shakes, as if held by hand; 1 is usual; TF does not show it')
    shutter: float = number(
        0.0, 0, 100, 'milliseconds within which the rows of a frame are read, one after the other')
    visitor: str = choice(
        NOBODY, VISITORS,
        'who moves in front of the wall: nobody, a person who walks past, or a hand that writes')
    jpeg: float = number(0.0, 0, 100, 'quality of the JPEG compression that each frame goes through; 0: none')


class Driver:
    """The motion of the robot: along the path, until the first /cmd_vel takes over."""

    def __init__(self, path):
        self._path = path
        self._pose = path.start if path else START
        self._command: Any = None  # the last one: when it came, and the speeds, m/s and rad/s
        self._started = self._moved = rospy.Time.now()
        rospy.Subscriber('cmd_vel', tolerant(Twist), self._on_command, queue_size=1)

    @fault_barrier
    def _on_command(self, command):
        speed = np.array([command.linear.x, command.angular.z])
        if not np.all(np.isfinite(speed)):
            rospy.logwarn_once('A /cmd_vel was ignored, since its speeds are not finite numbers.')
            return
        limit = [MAX_LINEAR, MAX_ANGULAR]
        self._command = rospy.Time.now(), tuple(np.clip(speed, np.negative(limit), limit))

    def now(self, stamp):
        """(Pose, linear m/s, angular rad/s) of the robot at that time."""
        seconds = max(0.0, (stamp - self._moved).to_sec())  # 0 if the clock was set back
        self._moved = stamp
        command = self._command  # read once, since another thread replaces it
        if self._path and command is None:
            self._pose, linear, angular = self._path.at((stamp - self._started).to_sec())
            return self._pose, linear, angular
        is_late = command is None or abs((stamp - command[0]).to_sec()) > COMMAND_S
        linear, angular = (0.0, 0.0) if is_late else command[1]
        self._pose = drive(self._pose, linear, angular, seconds)
        return self._pose, linear, angular


class WallCamera:
    """Publishes the camera's frames, the robot's pose, and the true positions of the tags and of the area."""

    def __init__(self):
        self._settings = read_settings(WallCameraSettings)
        self._camera = Camera(distortion=list(self._settings.distortion))
        self._wall = load_wall(in_package(self._settings.wall))
        self._renderer = self._make_renderer(self._settings)
        path = self._settings.path
        self._driver = Driver(load_path(path) if path != 'none' else None)
        Reconfigurer(self._settings, self._reconfigure)
        self._diagnostics, self._left_out = Diagnostics(self._report), 0
        self._frame_times: deque[float] = deque()  # monotonic seconds, when frames were published
        self._subscribed_since = None  # monotonic seconds, or None while nobody subscribes to the frames

        self._image = ImagePublisher(CAMERA, encoding='rgb8')
        self._namespace = self._image.name[:self._image.name.rindex('/') + 1]  # even if the topic is remapped
        self._publishers = {}
        self._transforms = tf2_ros.TransformBroadcaster()
        self._fixed = tf2_ros.StaticTransformBroadcaster()
        self._fixed.sendTransform(fixed_transforms(rospy.Time.now()))

    def _make_renderer(self, settings):
        return WallRenderer(self._wall, self._camera, noise=settings.noise, blur=settings.blur,
                            light=settings.falloff, seed=int(settings.seed), quality=int(settings.jpeg))

    def _reconfigure(self, settings):
        self._renderer, self._settings = self._make_renderer(settings), settings

    def _report(self):
        """The state of the camera: see Diagnostics."""
        now, subscribed_since = time.monotonic(), self._subscribed_since  # a copy: another thread changes it
        while self._frame_times and now - self._frame_times[0] > WINDOW_S:
            self._frame_times.popleft()
        rate = len(self._frame_times) / WINDOW_S
        values = {'frames a second': '%.1f' % rate, 'frames left out': self._left_out}
        if subscribed_since and now - subscribed_since > WINDOW_S and rate < 0.9 * self._settings.rate:
            return WARN, 'Slow: %.1f frames a second, not %g.' % (rate, self._settings.rate), values
        return OK, '%.1f frames a second' % rate, values

    def _diagnose(self):
        """Report the state regularly, even while a simulated clock stands still and no frames are due."""
        while not rospy.is_shutdown():
            self._diagnostics.update()
            time.sleep(PERIOD_S)

    def spin(self):
        """Publish frames until shutdown. The stamp of a frame is the exact time at which it is due."""
        threading.Thread(target=self._diagnose, daemon=True).start()
        rate = self._settings.rate
        start, count = rospy.Time.now(), 0
        while not rospy.is_shutdown():
            due = (rospy.Time.now() - start).to_sec() * rate  # the number of frames that are due by now
            if not count - 1 <= due <= count + MAX_LATE_S * rate:  # the clock was set
                start, count, due = rospy.Time.now(), 0, 0
            self._left_out += max(int(due) - count - 1, 0)  # frames that cannot be rendered in time
            count = max(count + 1, int(due))
            stamp = start + rospy.Duration(count / rate)
            try:
                rospy.sleep(stamp - rospy.Time.now())
            except rospy.ROSTimeMovedBackwardsException:
                continue
            except rospy.ROSInterruptException:
                return
            self._publish(stamp)

    @fault_barrier
    def _publish(self, stamp):
        settings, seconds = self._settings, stamp.to_sec() % LOOP_S
        pose, linear, angular = self._driver.now(stamp)
        first, last = (hand_held(wall_to_camera(drive(pose, linear, angular, passed)), seconds + passed,
                                 settings.hand) for passed in (0, settings.shutter / 1000))
        header, messages = observe(self._wall, self._camera, pose, linear, angular, stamp, first, last)
        for topic, message in messages.items():
            if topic not in self._publishers:
                name = self._namespace + topic if topic == 'camera_info' else topic
                self._publishers[topic] = rospy.Publisher(name, type(message), queue_size=1)
            self._publishers[topic].publish(message)
        self._transforms.sendTransform(robot_transform(pose, stamp))
        if not self._image.has_listeners():
            self._subscribed_since = None
        else:
            self._subscribed_since = self._subscribed_since or time.monotonic()
            exposure = settings.exposure * 2**(settings.swing * np.sin(2 * np.pi * seconds / SWING_S))
            self._image.publish(self._renderer.render(*first, exposure=exposure,
                                                      last=last if settings.shutter else None,
                                                      visitor=settings.visitor, seconds=seconds), header)
            self._frame_times.append(time.monotonic())


if __name__ == '__main__':
    keep_memory()
    run_node('wall_camera', lambda: WallCamera().spin(), Manual(
        [('cmd_vel', 'geometry_msgs/Twist', 'drives; without a command for half a second the robot stops')],
        MANUAL_TOPICS, [], WallCameraSettings))
