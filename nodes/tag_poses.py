#!/usr/bin/env python3
"""Finds where the tags are, and where the camera is relative to their wall.

From frames and the camera's calibration it computes the poses of every tag in
sight, of the area, of the camera and of the robot. It publishes them as
messages, TF frames and markers for RViz, and draws axes on the frame.
"""
import time

import aruco_program  # noqa: F401  before all else
import rospy
import tf2_ros
import yaml
from aruco_ar.base.errors import shorten
from aruco_ar.calibration.lens_check import LensCheck
from aruco_ar.painting.marks import mark_poses
from aruco_ar.poses.pose_runner import PoseRunner
from aruco_ar.settings.settings import LEARN
from aruco_node.health.diagnostics import ERROR, WARN
from aruco_node.health.faults import log_once
from aruco_node.health.silence import SILENCE_S
from aruco_node.messages import pose_messages
from aruco_node.messages.frame_names import WALL_FRAME, frame_name
from aruco_node.nodes.camera_node import CameraNode
from aruco_node.nodes.frame_node import Answer
from aruco_node.nodes.manual import camera_manual
from aruco_node.nodes.node import run_node
from aruco_node.parameters.parameters import AUTO
from aruco_node.parameters.settings import ID, PoseSettings
from aruco_node.process.memory import keep_memory
from aruco_node.ros_internals.tf import Broadcaster, OthersFrames
from geometry_msgs.msg import PoseWithCovarianceStamped
from unit5.msg import AreaPose, TagPoseArray
from visualization_msgs.msg import MarkerArray

TOPICS = [('~poses', TagPoseArray, 'every tag: id, corners, center, pose with covariance'),
          ('~area', AreaPose, 'the area: corners, center, width, height, pose with covariance'),
          ('~markers', MarkerArray, 'tags and area, for RViz'),
          ('~camera_pose', PoseWithCovarianceStamped, 'the camera in the frame of the wall'),
          ('~robot_pose', PoseWithCovarianceStamped, 'the robot in the frame of the wall')]
# The TF frame of a learned wall. A known wall has another name, since the origin of a learned one is a tag.
LEARNED_WALL_FRAME = 'learned_wall'


class TagPoses(CameraNode):
    """Publishes the poses of the tags, the area, the camera and the robot."""

    needs_calibration = True

    def __init__(self):
        super().__init__(['image'], PoseSettings, True, lambda settings: PoseRunner(*settings))
        self._problems = {}  # sentences about what is wrong, by kind
        self._lens_check = LensCheck()
        self._publishers = {topic[1:]: self.advertise(topic, kind) for topic, kind, _ in TOPICS}
        self.result_topics = [publisher.resolved_name for publisher in self._publishers.values()]
        self._transforms = Broadcaster()
        self._last_tf_stamp = None
        # Transforms of other nodes, which are received only while somebody listens to ~robot_pose.
        self._tf_buffer, self._tf_listener = tf2_ros.Buffer(), None
        self._tf_listening_since = time.monotonic()

    def is_wanted(self):
        return super().is_wanted() or self._transforms.is_heard(own=self._tf_listener is not None) or \
            any(publisher.get_num_connections() for publisher in self._publishers.values())

    def update_subscriptions(self, wanted):
        super().update_subscriptions(wanted)
        needs_tf = self._publishers['robot_pose'].get_num_connections() > 0
        if needs_tf and self._tf_listener is None:
            self._tf_listening_since = time.monotonic()
            self._tf_listener = OthersFrames(self._tf_buffer)
        elif not needs_tf and self._tf_listener is not None:
            self._tf_listener.unregister()
            self._tf_listener = None

    def forget_last_frames(self):
        super().forget_last_frames()
        self._problems = {}

    def look(self, frame, stamp, is_searched):
        wants_area = any(self._publishers[name].get_num_connections() for name in ('area', 'markers'))
        return self.runner.run(frame, stamp, self.lens, wants_area)

    def answer_to(self, sight, poses, header):
        problems = {}
        if self.lens_fault is not None:
            problems[self.lens_fault.kind] = self.explain(self.lens_fault)
        if poses.misfit:
            problems[poses.misfit] = poses.misfit

        def publish():
            if sight.lens is not None:
                self._publish_poses(sight, poses, header, problems)
            for kind, sentence in problems.items():
                log_once(kind, sentence, rospy.logwarn)
            self._problems = problems
        image = sight.frame
        if self.is_image_wanted('image'):
            image = mark_poses(image, sight.tags, poses.tags, sight.lens, sight.areas[0].area)
        return Answer([image], publish, is_complete=sight.lens is not None or bool(problems))

    def further_checks(self, sight):
        others = {tag_id for tag_id, _ in self.settings.tag_sizes}
        check = self._lens_check.update(sight.stamp, [tag for tag in sight.tags if tag.id not in others],
                                        sight.lens)
        return [] if check is None else [check]

    @property
    def warning(self):
        return super().warning or self._lens_check.hint

    def report(self):
        level, sentence, values = super().report()
        problems = list(self._problems.values()) if self.is_receiving else []
        # Missing poses matter more than dropped frames, but less than an error.
        return (WARN, problems[0], values) if problems and level < ERROR else (level, sentence, values)

    def explain(self, fault):
        return 'Tags are found, but no poses: %s.' % fault

    def _publish_poses(self, sight, poses, header, problems):
        """Publish the poses on the topics that somebody listens to. Adds to ``problems`` what is missing."""
        publish = {name: publisher.publish for name, publisher in self._publishers.items()
                   if publisher.get_num_connections()}
        if 'poses' in publish:
            publish['poses'](pose_messages.tag_poses(poses.tags, sight.lens, header))
        if 'area' in publish and poses.area is not None:
            publish['area'](pose_messages.area_pose(poses.area, sight.lens, header))
        if 'markers' in publish:
            publish['markers'](pose_messages.markers(poses.tags, poses.area, header))
        camera_frame = header.frame_id.lstrip('/')
        if camera_frame:
            self._publish_transforms(poses.tags, header)
        else:
            problems['frame_id'] = 'The frames of the camera have no frame_id, so no TF frames of tags are ' \
                                   'published. Set frame_id in the camera driver.'
        if poses.camera is None:
            return
        name = self.settings.wall_frame
        if name == AUTO:
            name = LEARNED_WALL_FRAME if self.settings.wall == LEARN else WALL_FRAME
        wall = frame_name(name)
        if 'camera_pose' in publish:
            publish['camera_pose'](pose_messages.stamped(poses.camera, header.stamp, wall))
        if 'robot_pose' in publish and camera_frame:
            robot = self._robot(poses.camera, camera_frame, header.stamp, problems)
            if robot is not None:
                publish['robot_pose'](pose_messages.stamped(robot, header.stamp, wall))

    def _publish_transforms(self, poses, header):
        """Publish the tags as TF frames.

        A tag whose id is in sight twice has none: nobody could tell which of the two the frame means. Nothing
        is published for a stamp that comes again, since every TF listener would log a warning for each
        transform.
        """
        stamp = header.stamp or rospy.Time.now()
        ids = [pose.id for pose in poses]
        unique = [pose for pose in poses if ids.count(pose.id) == 1]
        if unique and stamp != self._last_tf_stamp:
            self._last_tf_stamp = stamp
            names = [frame_name(self.settings.tag_frame.replace(ID, str(pose.id))) for pose in unique]
            self._transforms.sendTransform([pose_messages.transform(pose, stamp, header.frame_id, name)
                                            for pose, name in zip(unique, names)])

    def _robot(self, camera, camera_frame, stamp, problems):
        """The robot's pose by the camera's pose; None if TF does not say where the camera is mounted."""
        own, plain = frame_name(self.settings.robot_frame), self.settings.robot_frame.lstrip('/')
        found = self._mounting(camera_frame, own, stamp)
        if found is None and plain != own:
            found = self._mounting(camera_frame, plain, stamp)
            if found is not None:
                log_once('robot frame', 'TF joins %s to the camera, and not %s, so it is taken for the robot.'
                         % (plain, own), rospy.loginfo)
        if found is not None:
            return camera.carry(*pose_messages.from_transform(found.transform))
        if time.monotonic() - self._tf_listening_since > SILENCE_S:
            problems['robot'] = 'The pose of the robot is not known: TF does not join %s to %s. %s' % (
                shorten(own, 40), shorten(camera_frame, 40), self._known_frames())
        return None

    def _mounting(self, camera_frame, frame, stamp):
        """The TransformStamped from a TF frame to the camera at a time; None if it is not known."""
        try:
            return self._tf_buffer.lookup_transform(camera_frame, frame, stamp)
        except tf2_ros.ExtrapolationException:  # TF may come later than the frame; then the newest is the best
            return self._mounting(camera_frame, frame, rospy.Time(0)) if stamp else None
        except (tf2_ros.TransformException, ValueError):  # ValueError: a null character in a name
            return None

    def _known_frames(self):
        """What TF frames there are, and what to do, in a sentence."""
        names = sorted(yaml.safe_load(self._tf_buffer.all_frames_as_yaml()) or [])
        if not names:
            return 'No TF frames are published. Start robot_state_publisher or a static_transform_publisher.'
        return 'Set robot_frame to one of the TF frames that there are: %s.' % shorten(', '.join(names), 200)


if __name__ == '__main__':
    keep_memory()
    run_node('tag_poses', lambda: TagPoses().spin(), camera_manual(
        ['image'], PoseSettings, True,
        [('/tf', 'tf2_msgs/TFMessage', 'where the camera is mounted on the robot, for ~robot_pose'),
         ('/tf_static', 'tf2_msgs/TFMessage', 'the same')],
        [(topic, kind._type, what) for topic, kind, what in TOPICS] +
        [('/tf', 'tf2_msgs/TFMessage', 'the tags, tag_1 and so on, in the frame of the camera')]))
