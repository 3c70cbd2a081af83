#!/usr/bin/env python3
"""Where the tags are, and where the camera is before their wall.

From frames and the camera's calibration: the pose of every tag in sight, of the
area, of the camera and of the robot, as messages, TF frames, markers for RViz,
and axes drawn on the frame.
"""
import time

import aruco_program  # noqa: F401  before all else
import rospy
import tf2_ros
from aruco_ar import InputError, PoseEstimator
from aruco_ar.base.errors import shorten
from aruco_ar.base.files import in_package
from aruco_ar.exercise import TRACKER, Result, find_tags
from aruco_ar.painting.marks import mark_poses
from aruco_ar.poses.wall_watch import WallWatch
from aruco_ar.walls.wall import load_wall
from aruco_node.health.diagnostics import ERROR, WARN
from aruco_node.health.faults import say_once
from aruco_node.health.silence import SILENCE_S
from aruco_node.messages import pose_messages
from aruco_node.messages.frame_names import frame_name
from aruco_node.messages.wall_messages import WALL_FRAME
from aruco_node.nodes.calibration import Calibration
from aruco_node.nodes.camera_node import CameraNode
from aruco_node.nodes.manual import camera_manual
from aruco_node.nodes.node import run_node
from aruco_node.parameters.parameters import AUTO
from aruco_node.parameters.settings import ID, LEARN, PoseSettings
from aruco_node.process.memory import keep_memory
from aruco_node.ros_internals.tf_listener import OthersFrames
from geometry_msgs.msg import PoseWithCovarianceStamped
from unit5.msg import AreaPose, TagPoseArray
from visualization_msgs.msg import MarkerArray

TOPICS = [('~poses', TagPoseArray, 'every tag: id, corners, center, pose with covariance'),
          ('~area', AreaPose, 'the area: corners, center, width, height, pose with covariance'),
          ('~markers', MarkerArray, 'tags and area, for RViz'),
          ('~camera_pose', PoseWithCovarianceStamped, 'the camera in the frame of the wall'),
          ('~robot_pose', PoseWithCovarianceStamped, 'the robot in the frame of the wall')]
LEARNED = 'learned_wall'  # another frame than that of a known wall: its origin is a tag
# Parameters after whose change the places of the tags are learned anew.
BEGINS = 'dictionary', 'tag_size', 'tag_sizes', 'wall'


class TagPoses(CameraNode):
    """Publishes the poses of what it sees."""

    def __init__(self):
        super().__init__([TRACKER], ['image'], PoseSettings)
        self._wall = _load_wall(self.settings)
        self._estimator, self._watch = self._begin(self.settings, self._wall)
        self._calibration = Calibration(self.settings, self.camera)
        self._faults = {}  # what is wrong, by its kind
        self._publishers = {topic[1:]: self.advertise(topic, kind) for topic, kind, _ in TOPICS}
        self.results = [publisher.resolved_name for publisher in self._publishers.values()]
        self._transforms, self._framed = tf2_ros.TransformBroadcaster(), None  # the stamp of the last
        # The TF of others, while the robot's pose is wanted.
        self._frames, self._listener = tf2_ros.Buffer(), None

    def is_wanted(self):
        others = self._transforms.pub_tf.get_num_connections() - (self._listener is not None)
        return super().is_wanted() or others > 0 or \
            any(publisher.get_num_connections() for publisher in self._publishers.values())

    def follow(self, wanted):
        super().follow(wanted)
        self._calibration.follow(wanted)
        placed = self._publishers['robot_pose'].get_num_connections() > 0
        if placed and self._listener is None:
            self._listening_since = time.monotonic()
            self._listener = OthersFrames(self._frames)
        elif not placed and self._listener is not None:
            self._listener.unregister()
            self._listener = None

    def prepare(self, settings):
        changes = super().prepare(settings)
        if all(getattr(settings, name) == getattr(self.settings, name) for name in BEGINS):
            return changes
        wall = self._wall if settings.wall == self.settings.wall else _load_wall(settings)
        begun = self._begin(settings, wall)

        def change():
            self._wall, (self._estimator, self._watch) = wall, begun
        return changes + [change]

    def reset(self):
        super().reset()
        self._estimator, self._watch = self._begin(self.settings, self._wall)

    def step(self, scene, header):
        tags, area = find_tags(scene), scene.tracker.update(scene.frame, scene.stamp)
        faults: dict[str, str] = {}
        lens = self._lens(scene.frame.shape[1::-1], faults)
        self.ready = lens is not None or bool(faults)
        poses, on_wall, camera = [], None, None
        if lens is not None:
            estimator = self._estimator
            poses = sorted(estimator.update(tags, lens, scene.stamp), key=lambda pose: pose.id)
            camera = estimator.camera()
            on_wall = None if area is None else estimator.area(area, lens)
            misfit = self._watch.check(poses, camera, scene.stamp)
            if misfit:
                faults[misfit] = misfit
        self._made = poses, on_wall, camera, lens, faults
        image = mark_poses(scene.image, tags, poses, lens, area) if self.is_seen('image') else scene.image
        return Result([image], tags, area)

    def publish(self, messages, header):
        poses, area, camera, lens, faults = self._made
        if lens is not None:
            self._publish_poses(poses, area, camera, lens, header, faults)
        super().publish(messages, header)
        for kind, sentence in faults.items():
            say_once(kind, sentence, rospy.logwarn)
        self._faults = faults

    def report(self):
        level, sentence, values = super().report()
        faults = list(self._faults.values())
        # Frames that are dropped are not worth a word where all poses are missing.
        return (WARN, faults[0], values) if faults and level < ERROR else (level, sentence, values)

    def _begin(self, settings, wall):
        """A PoseEstimator and a WallWatch. Raises InputError if the wall has tags of another dictionary."""
        if wall is not None and wall.dictionary != settings.dictionary:
            raise InputError('The tags of the wall "%s" are of %s, those that are looked for of %s; give the '
                             'same: dictionary:=%s.' % (settings.wall, wall.dictionary, settings.dictionary,
                                                        wall.dictionary))
        return PoseEstimator(settings.tag_size, dict(settings.tag_sizes), wall), WallWatch(wall, settings.wall)

    def _lens(self, size, faults):
        """The Lens of frames of that size, or None."""
        try:
            return self._calibration.lens(size, self.scale)
        except InputError as error:
            faults[error.kind] = 'Tags are found, but no poses: %s: %s.' % (self._calibration.topic, error)
            return None

    def _publish_poses(self, poses, area, camera, lens, header, faults):
        publish = {name: publisher.publish for name, publisher in self._publishers.items()
                   if publisher.get_num_connections()}
        if 'poses' in publish:
            publish['poses'](pose_messages.tag_poses(poses, lens, header))
        if 'area' in publish:
            publish['area'](pose_messages.area_pose(area, lens, header))
        if 'markers' in publish:
            publish['markers'](pose_messages.markers(poses, area, header))
        named = header.frame_id.lstrip('/')
        if not named:
            faults['frame_id'] = 'Frames come without a frame_id, so no TF frames of tags are published; set ' \
                                 'it in the camera driver.'
        else:
            self._publish_frames(poses, header)
        if camera is None:
            return
        name = self.settings.wall_frame
        wall = frame_name(name if name != AUTO else LEARNED if self.settings.wall == LEARN else WALL_FRAME)
        if 'camera_pose' in publish:
            publish['camera_pose'](pose_messages.stamped(camera, header.stamp, wall))
        if 'robot_pose' in publish and named:
            robot = self._robot(camera, header, faults)
            if robot is not None:
                publish['robot_pose'](pose_messages.stamped(robot, header.stamp, wall))

    def _publish_frames(self, poses, header):
        """The tags as TF frames; of two with one id nobody could say which the frame is of.

        TF takes no two of one stamp, and says a line for each, to everybody who listens.
        """
        stamp = header.stamp or rospy.Time.now()
        ids = [pose.id for pose in poses]
        single = [pose for pose in poses if ids.count(pose.id) == 1]
        if single and stamp != self._framed:
            self._framed = stamp
            names = [frame_name(self.settings.tag_frame.replace(ID, str(pose.id))) for pose in single]
            self._transforms.sendTransform([pose_messages.transform(pose, stamp, header.frame_id, name)
                                            for pose, name in zip(single, names)])

    def _robot(self, camera, header, faults):
        """The robot's pose by the camera's, or None if nobody knows where on the robot the camera is."""
        frame = frame_name(self.settings.robot_frame)
        try:
            found = self._frames.lookup_transform(header.frame_id.lstrip('/'), frame, rospy.Time(0)).transform
        except (tf2_ros.TransformException, ValueError) as error:  # of a null character in a frame_id
            if time.monotonic() - self._listening_since > SILENCE_S:
                faults['robot'] = 'The pose of the robot is not known: no transform from %s to %s (%s). Is ' \
                                  'robot_frame right?' % (frame, shorten(header.frame_id, 40),
                                                          shorten(str(error), 200))
            return None
        return camera.carry(*pose_messages.from_transform(found))


def _load_wall(settings):
    """The Wall that settings name, or None where it is learned. Raises InputError if there is no such wall."""
    if settings.wall == LEARN:
        return None
    return load_wall(in_package(settings.wall))


if __name__ == '__main__':
    keep_memory()
    run_node('tag_poses', lambda: TagPoses().spin(), camera_manual(
        ['image'], PoseSettings, True,
        [('camera/rgb/camera_info', 'sensor_msgs/CameraInfo', "the camera's calibration, beside its images"),
         ('/tf', 'tf2_msgs/TFMessage', 'where on the robot the camera is, for ~robot_pose'),
         ('/tf_static', 'tf2_msgs/TFMessage', 'the same')],
        [(topic, kind._type, what) for topic, kind, what in TOPICS] +
        [('/tf', 'tf2_msgs/TFMessage', 'the tags, tag_1 and so on, in the frame of the camera')]))
