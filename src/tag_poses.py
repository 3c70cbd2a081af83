#!/usr/bin/env python3
"""Where the tags are, and where the camera is before their wall.

From frames and the camera's calibration: the pose of every tag in sight, of the
area, of the camera and of the robot, as messages, TF frames, markers for RViz,
and axes drawn on the frame.
"""
import os

import rospy
import tf2_ros
from aruco_ar import InputError, PoseEstimator, mark_tags
from aruco_ar.files import package_folder
from aruco_ar.paint import mark_axes
from aruco_ar.wall import load_wall
from aruco_node import pose_messages
from aruco_node.calibration import Calibration
from aruco_node.camera_node import CameraNode
from aruco_node.health import OK, WARN
from aruco_node.manual import camera_manual
from aruco_node.memory import keep_memory
from aruco_node.names import frame_name
from aruco_node.node import run_node
from aruco_node.settings import ID, LEARN, PoseSettings
from geometry_msgs.msg import PoseWithCovarianceStamped
from unit5.msg import AreaPose, TagPoseArray
from visualization_msgs.msg import MarkerArray

TOPICS = [('~poses', TagPoseArray, 'every tag: id, corners, center, pose with covariance'),
          ('~area', AreaPose, 'the area: corners, center, width, height, pose with covariance'),
          ('~markers', MarkerArray, 'tags and area, for RViz'),
          ('~camera_pose', PoseWithCovarianceStamped, 'the camera in the frame of the wall'),
          ('~robot_pose', PoseWithCovarianceStamped, 'the robot in the frame of the wall')]
# Parameters after whose change the places of the tags are learnt anew.
BEGINS = 'dictionary', 'tag_size', 'tag_sizes', 'wall'


class TagPoses(CameraNode):
    """Publishes the poses of what it sees."""

    def __init__(self):
        super().__init__(['tags', 'area'], ['image'], PoseSettings)
        self._estimator = self._make_estimator(self.settings)
        self._calibration = Calibration(self.settings, self.camera)
        self._fault = None
        self._publishers = {topic[1:]: self.advertise(topic, kind) for topic, kind, _ in TOPICS}
        self._transforms = tf2_ros.TransformBroadcaster()
        self._frames, self._listener = tf2_ros.Buffer(), None  # the TF of others, while the robot's pose is wanted

    def is_wanted(self):
        others = self._transforms.pub_tf.get_num_connections() - (self._listener is not None)
        return super().is_wanted() or others > 0 or \
            any(publisher.get_num_connections() for publisher in self._publishers.values())

    def follow(self, wanted):
        super().follow(wanted)
        self._calibration.follow(wanted)
        placed = self._publishers['robot_pose'].get_num_connections() > 0
        if placed and self._listener is None:
            self._listener = tf2_ros.TransformListener(self._frames)
        elif not placed and self._listener is not None:
            self._listener.unregister()
            self._listener = None

    def prepare(self, settings):
        changes = super().prepare(settings)
        if all(getattr(settings, name) == getattr(self.settings, name) for name in BEGINS):
            return changes
        estimator = self._make_estimator(settings)

        def change():
            self._estimator = estimator
        return changes + [change]

    def reset(self):
        super().reset()
        self._estimator = self._make_estimator(self.settings)

    def answer(self, frame, given, header, stamp):
        tags, area = given[0]
        lens = self._lens(frame.shape[1::-1])
        self.ready = lens is not None or self._fault is not None
        if lens is None:
            return [mark_tags(frame, tags)]
        estimator = self._estimator
        poses = estimator.update(tags, lens, stamp)
        area = None if area is None else estimator.area(area, lens)
        self._publish(poses, area, estimator.camera(), lens, header)
        return [mark_axes(mark_tags(frame, tags), poses, lens) if self.is_seen('image') else frame]

    def report(self):
        level, sentence, values = super().report()
        if level == OK and self._fault:
            level, sentence = WARN, self._fault
        return level, sentence, values

    def _make_estimator(self, settings):
        wall = None
        if settings.wall != LEARN:
            wall = load_wall(os.path.join(package_folder(), os.path.expanduser(settings.wall)))
            if wall.dictionary != settings.dictionary:
                raise InputError('The tags of the wall "%s" are of %s, those that are looked for of %s; give the '
                                 'same: dictionary:=%s.' % (settings.wall, wall.dictionary, settings.dictionary,
                                                            wall.dictionary))
        return PoseEstimator(settings.tag_size, dict(settings.tag_sizes), wall)

    def _lens(self, size):
        """The Lens of frames of that size, or None; what is wrong with it is said, once."""
        scale = self.settings.scale
        try:
            lens = self._calibration.lens(size, scale)
        except InputError as error:
            self._fault = 'Tags are found, but not their poses, by what camera_info on %s says: %s.' % (
                self._calibration.topic, error)
            self.say_once(error.kind, self._fault, rospy.logwarn)
            return None
        self._fault = None
        return lens

    def _publish(self, poses, area, camera, lens, header):
        publish = {name: publisher.publish for name, publisher in self._publishers.items()
                   if publisher.get_num_connections()}
        if 'poses' in publish:
            publish['poses'](pose_messages.tag_poses(poses, lens, header))
        if 'area' in publish:
            publish['area'](pose_messages.area_pose(area, lens, header))
        if 'markers' in publish:
            publish['markers'](pose_messages.markers(poses, area, lens, header))
        ids = [pose.id for pose in poses]
        # Of two tags with one id nobody could say which the frame is of.
        single = [pose for pose in poses if ids.count(pose.id) == 1]
        if single:
            self._transforms.sendTransform([
                pose_messages.transform(pose, header, frame_name(self.settings.tag_frame.replace(ID, str(pose.id))))
                for pose in single])
        if camera is None:
            return
        wall = frame_name(self.settings.wall_frame)
        if 'camera_pose' in publish:
            publish['camera_pose'](pose_messages.stamped(camera, header.stamp, wall))
        if 'robot_pose' in publish:
            robot = self._robot(camera, header)
            if robot is not None:
                publish['robot_pose'](pose_messages.stamped(robot, header.stamp, wall))

    def _robot(self, camera, header):
        """The robot's pose by the camera's, or None if nobody knows where on the robot the camera is."""
        frame = frame_name(self.settings.robot_frame)
        try:
            found = self._frames.lookup_transform(header.frame_id.lstrip('/'), frame, rospy.Time(0)).transform
        except tf2_ros.TransformException as error:
            self.say_once('no robot', 'The pose of the robot is not known: no transform from %s to %s (%s). Is '
                          'robot_frame right?' % (frame, header.frame_id, error), rospy.logwarn)
            return None
        return camera.carry(*pose_messages.from_transform(found))


if __name__ == '__main__':
    keep_memory()
    run_node('tag_poses', lambda: TagPoses().spin(), camera_manual(
        ['image'], PoseSettings, True,
        [('camera/rgb/camera_info', 'sensor_msgs/CameraInfo', "the camera's calibration, beside its images"),
         ('/tf', 'tf2_msgs/TFMessage', 'where on the robot the camera is, for ~robot_pose'),
         ('/tf_static', 'tf2_msgs/TFMessage', 'the same')],
        [(topic, kind._type, what) for topic, kind, what in TOPICS] +
        [('/tf', 'tf2_msgs/TFMessage', 'the tags, tag_1 and so on, in the frame of the camera')]))
