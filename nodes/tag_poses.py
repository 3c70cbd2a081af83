#!/usr/bin/env python3
"""Finds where the tags are, and where the camera is relative to their wall.

From frames and the camera's calibration it computes the poses of every tag in
sight, of the area, of the camera and of the robot. It publishes them as
messages, TF frames and markers for RViz, and draws axes on the frame.
"""
import aruco_program  # noqa: F401  before all else
import rospy
from aruco_ar.painting.marks import mark_poses
from aruco_ar.poses.pose_runner import PoseRunner
from aruco_node.messages import pose_messages
from aruco_node.messages.frame_names import WALL_FRAME, frame_name
from aruco_node.nodes.camera_node import CameraAnswer, CameraNode
from aruco_node.nodes.manual import camera_manual
from aruco_node.nodes.node import run_node
from aruco_node.nodes.robot import Robot
from aruco_node.parameters.parameters import AUTO
from aruco_node.parameters.settings import ID, PoseSettings
from aruco_node.process.memory import keep_memory
from aruco_node.ros_internals.tf import Broadcaster
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
    without_lens = 'Tags are found, but no poses: %s.'

    def __init__(self):
        super().__init__(['image'], PoseSettings, True,
                         lambda settings: PoseRunner(settings[0], in_thread=True))
        self._publishers = {topic[1:]: self.advertise(topic, kind) for topic, kind, _ in TOPICS}
        self.result_topics = [publisher.resolved_name for publisher in self._publishers.values()]
        self._robot = Robot(self.settings.robot_frame, lambda: self._is_heard('robot_pose'))
        self.inputs.append(self._robot)
        self._transforms = Broadcaster()
        self.are_heard.append(lambda: self._transforms.is_heard(own=self._robot.listens))
        self._last_tf_stamp = None

    def _is_heard(self, *names):
        """Whether anybody listens to one of these topics."""
        return any(self._publishers[name].get_num_connections() for name in names)

    def look(self, frame, stamp, is_searched):
        return self.runner.run(frame, stamp, self.lens, self._is_heard('area', 'markers'))

    def answer_to(self, sight, poses, header):
        problems = {}
        if self.lens_fault is not None:
            problems[self.lens_fault.kind] = self.explain(self.lens_fault)
        if poses.misfit:
            problems[poses.misfit] = poses.misfit

        def publish():
            if sight.lens is not None:
                self._publish_poses(sight, poses, header, problems)
        image = sight.frame
        if self.is_image_wanted('image'):
            image = mark_poses(image, sight.tags, poses.tags, sight.lens, sight.areas[0].area)
        return CameraAnswer([image], publish, sight.lens is not None or bool(problems), problems=problems,
                            hint=poses.hint, work=poses.work)

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
            name = LEARNED_WALL_FRAME if self.settings.learns_places else WALL_FRAME
        wall = frame_name(name)
        if 'camera_pose' in publish:
            publish['camera_pose'](pose_messages.stamped(poses.camera, header.stamp, wall))
        if 'robot_pose' in publish and camera_frame:
            robot = self._robot.pose(poses.camera, camera_frame, header.stamp, problems)
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

if __name__ == '__main__':
    keep_memory()
    run_node('tag_poses', lambda: TagPoses().spin(), camera_manual(
        ['image'], PoseSettings, True,
        [('/tf', 'tf2_msgs/TFMessage', 'where the camera is mounted on the robot, for ~robot_pose'),
         ('/tf_static', 'tf2_msgs/TFMessage', 'the same')],
        [(topic, kind._type, what) for topic, kind, what in TOPICS] +
        [('/tf', 'tf2_msgs/TFMessage', 'the tags, tag_1 and so on, in the frame of the camera')]))
