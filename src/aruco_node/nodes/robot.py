"""The pose of the robot that the camera is mounted on, by TF."""
import time

import rospy
import tf2_ros
import yaml
from aruco_ar.base.errors import shorten

from aruco_node.health.faults import log_once
from aruco_node.health.silence import SILENCE_S
from aruco_node.messages import pose_messages
from aruco_node.messages.frame_names import frame_name
from aruco_node.ros_internals.tf import OthersFrames


class Robot:
    """Knows where the camera is on the robot. ``listens``: whether it receives TF frames."""

    def __init__(self, frame, is_wanted):
        """``frame``: the robot's TF frame. ``is_wanted()``: whether anybody wants the robot's pose."""
        self._frame, self._is_wanted = frame, is_wanted
        self._buffer, self._listener = tf2_ros.Buffer(), None
        self._since = time.monotonic()

    @property
    def listens(self):
        return self._listener is not None

    def update_subscription(self, wanted):
        """Receive the TF frames of other nodes if the robot's pose is wanted. Called about once a second."""
        if self._is_wanted() and self._listener is None:
            self._since = time.monotonic()
            self._listener = OthersFrames(self._buffer)
        elif not self._is_wanted() and self._listener is not None:
            self._listener.unregister()
            self._listener = None

    def pose(self, camera, camera_frame, stamp, problems):
        """The robot's pose by the camera's, CameraPose; None if TF does not say where the camera is mounted.

        ``camera_frame``: the camera's TF frame. ``stamp``: rospy.Time. Adds to ``problems``, {kind:
        sentence}, what is wrong.
        """
        own, plain = frame_name(self._frame), self._frame.lstrip('/')
        found = self._mounting(camera_frame, own, stamp)
        if found is None and plain != own:
            found = self._mounting(camera_frame, plain, stamp)
            if found is not None:
                log_once('robot frame', 'TF joins %s to the camera, and not %s, so it is taken for the robot.'
                         % (plain, own), rospy.loginfo)
        if found is not None:
            return camera.carry(*pose_messages.from_transform(found.transform))
        if time.monotonic() - self._since > SILENCE_S:
            problems['robot'] = 'The pose of the robot is not known: TF does not join %s to %s. %s' % (
                shorten(own, 40), shorten(camera_frame, 40), self._known_frames())
        return None

    def _mounting(self, camera_frame, frame, stamp):
        """The TransformStamped from a TF frame to the camera at a time; None if it is not known."""
        try:
            return self._buffer.lookup_transform(camera_frame, frame, stamp)
        except tf2_ros.ExtrapolationException:  # TF may come later than the frame; then the newest is the best
            return self._mounting(camera_frame, frame, rospy.Time(0)) if stamp else None
        except (tf2_ros.TransformException, ValueError):  # ValueError: a null character in a name
            return None

    def _known_frames(self):
        """What TF frames there are, and what to do, in a sentence."""
        names = sorted(yaml.safe_load(self._buffer.all_frames_as_yaml()) or [])
        if not names:
            return 'No TF frames are published. Start robot_state_publisher or a static_transform_publisher.'
        return 'Set robot_frame to one of the TF frames that there are: %s.' % shorten(', '.join(names), 200)
