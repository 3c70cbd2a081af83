#!/usr/bin/env python3
"""Finds where the tags are, and where the camera is relative to their wall.

From frames and the camera's calibration it computes the poses of every tag in
sight, of the area, of the camera and of the robot. It publishes them as
messages, TF frames and markers for RViz, and draws axes on the frame.
"""
import time
from dataclasses import dataclass, field, replace
from typing import Any, Dict, List, Optional

import aruco_program  # noqa: F401  before all else
import rospy
import tf2_ros
import yaml
from aruco_ar import InputError, PoseEstimator
from aruco_ar.base.errors import shorten
from aruco_ar.base.files import in_package
from aruco_ar.exercise import TRACKER, Exercise, Result, find_tags
from aruco_ar.painting.marks import mark_poses
from aruco_ar.poses.wall_watch import WallWatch
from aruco_ar.tags.tag import DICTIONARIES
from aruco_ar.walls.wall import load_wall
from aruco_node.health.diagnostics import ERROR, WARN
from aruco_node.health.faults import log_once
from aruco_node.health.silence import SILENCE_S
from aruco_node.messages import pose_messages
from aruco_node.messages.frame_names import WALL_FRAME, frame_name
from aruco_node.nodes.camera_node import CameraNode
from aruco_node.nodes.manual import camera_manual
from aruco_node.nodes.node import run_node
from aruco_node.parameters.parameters import AUTO
from aruco_node.parameters.settings import ID, LEARN, PoseSettings
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
# After a change of one of these parameters, the places of the tags are learned anew.
RELEARN_AFTER = 'dictionary', 'tag_size', 'tag_sizes', 'wall'


@dataclass(frozen=True)
class PoseResult(Result):
    """A Result with poses.

    ``lens``: the Lens of the frame, None until the camera's calibration is known. ``poses``: a TagPose for
    each tag, by id. ``area_pose``: an AreaPose. ``camera``: the camera's pose relative to the wall. Each of
    the two is None if it is not known. ``problems``: sentences about what is wrong, by kind.
    """

    lens: Optional[Any] = None
    poses: List[Any] = field(default_factory=list)
    area_pose: Optional[Any] = None
    camera: Optional[Any] = None
    problems: Dict[str, str] = field(default_factory=dict)


class TagPoses(CameraNode):
    """Publishes the poses of the tags, the area, the camera and the robot."""

    needs_calibration = True

    def __init__(self):
        super().__init__(Exercise('tag_poses', self._locate, [TRACKER]), PoseSettings)
        self._wall = _load_wall(self.settings)
        self._estimator, self._watch = self._new_estimator(self.settings, self._wall)
        self._problems = {}  # sentences about what is wrong, by kind
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

    def prepare(self, settings):
        apply_to_stages = super().prepare(settings)
        if all(getattr(settings, name) == getattr(self.settings, name) for name in RELEARN_AFTER):
            return apply_to_stages
        wall = self._wall if settings.wall == self.settings.wall else _load_wall(settings)
        estimator, watch = self._new_estimator(settings, wall)

        def apply():
            apply_to_stages()
            self._wall, self._estimator, self._watch = wall, estimator, watch
        return apply

    def reset(self):
        super().reset()
        self._estimator, self._watch = self._new_estimator(self.settings, self._wall)

    def answer(self, results, header):
        result, = results  # PoseSettings have no areas file, so there is one area
        answer = super().answer(results, header)

        def publish():
            problems = dict(result.problems)
            if result.lens is not None:
                self._publish_poses(result, header, problems)
            answer.publish()
            for kind, sentence in problems.items():
                log_once(kind, sentence, rospy.logwarn)
            self._problems = problems
        return replace(answer, publish=publish,
                       is_complete=result.lens is not None or bool(result.problems))

    def report(self):
        level, sentence, values = super().report()
        problems = list(self._problems.values()) if self.is_receiving else []
        # Missing poses matter more than dropped frames, but less than an error.
        return (WARN, problems[0], values) if problems and level < ERROR else (level, sentence, values)

    def _locate(self, scene):
        """The step of this node's Exercise: the PoseResult of a Scene."""
        tags, area = find_tags(scene), scene.tracker.update(scene.frame, scene.stamp)
        problems: Dict[str, str] = {}
        lens = self.lens
        if self.lens_fault is not None:
            problems[self.lens_fault.kind] = self.explain(self.lens_fault)
        poses, area_pose, camera = [], None, None
        if lens is not None:
            estimator = self._estimator
            poses = sorted(estimator.update(tags, lens, scene.stamp), key=lambda pose: pose.id)
            camera = estimator.camera()
            area_pose = None if area is None else estimator.area(area, lens)
            misfit = self._watch.check(poses, camera, scene.stamp)
            if misfit:
                problems[misfit] = misfit
        image = scene.image
        if self.is_image_wanted('image'):
            image = mark_poses(image, tags, poses, lens, area)
        return PoseResult([image], tags, area, lens, poses, area_pose, camera, problems)

    def _new_estimator(self, settings, wall):
        """(PoseEstimator, WallWatch). Raises InputError if the wall's tags are of another dictionary."""
        if wall is not None and DICTIONARIES[wall.dictionary] != DICTIONARIES[settings.dictionary]:
            raise InputError('The wall "%s" has tags of the dictionary %s, but the node looks for tags of %s. '
                             "Give the wall's dictionary: dictionary:=%s."
                             % (settings.wall, wall.dictionary, settings.dictionary, wall.dictionary))
        return PoseEstimator(settings.tag_size, dict(settings.tag_sizes), wall), WallWatch(wall, settings.wall)

    def explain(self, fault):
        return 'Tags are found, but no poses: %s.' % fault

    def _publish_poses(self, result, header, problems):
        """Publish the poses on the topics that somebody listens to. Adds to ``problems`` what is missing."""
        publish = {name: publisher.publish for name, publisher in self._publishers.items()
                   if publisher.get_num_connections()}
        if 'poses' in publish:
            publish['poses'](pose_messages.tag_poses(result.poses, result.lens, header))
        if 'area' in publish and result.area_pose is not None:
            publish['area'](pose_messages.area_pose(result.area_pose, result.lens, header))
        if 'markers' in publish:
            publish['markers'](pose_messages.markers(result.poses, result.area_pose, header))
        camera_frame = header.frame_id.lstrip('/')
        if camera_frame:
            self._publish_transforms(result.poses, header)
        else:
            problems['frame_id'] = 'The frames of the camera have no frame_id, so no TF frames of tags are ' \
                                   'published. Set frame_id in the camera driver.'
        if result.camera is None:
            return
        name = self.settings.wall_frame
        if name == AUTO:
            name = LEARNED_WALL_FRAME if self.settings.wall == LEARN else WALL_FRAME
        wall = frame_name(name)
        if 'camera_pose' in publish:
            publish['camera_pose'](pose_messages.stamped(result.camera, header.stamp, wall))
        if 'robot_pose' in publish and camera_frame:
            robot = self._robot(result.camera, camera_frame, header.stamp, problems)
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


def _load_wall(settings):
    """The Wall that settings name, or None if it is learned. Raises InputError if the file holds no wall."""
    if settings.wall == LEARN:
        return None
    return load_wall(in_package(settings.wall))


if __name__ == '__main__':
    keep_memory()
    run_node('tag_poses', lambda: TagPoses().spin(), camera_manual(
        ['image'], PoseSettings, True,
        [('/tf', 'tf2_msgs/TFMessage', 'where the camera is mounted on the robot, for ~robot_pose'),
         ('/tf_static', 'tf2_msgs/TFMessage', 'the same')],
        [(topic, kind._type, what) for topic, kind, what in TOPICS] +
        [('/tf', 'tf2_msgs/TFMessage', 'the tags, tag_1 and so on, in the frame of the camera')]))
