"""Conversion of poses to messages."""
from math import copysign, sqrt

import cv2
import numpy as np
from geometry_msgs.msg import (
    Point,
    Pose,
    PoseWithCovariance,
    PoseWithCovarianceStamped,
    Quaternion,
    TransformStamped,
    Vector3,
)
from rospy import Duration
from std_msgs.msg import ColorRGBA, Header
from unit5.msg import AreaPose as AreaPoseMessage
from unit5.msg import TagPose as TagPoseMessage
from unit5.msg import TagPoseArray
from visualization_msgs.msg import Marker, MarkerArray

from .images import points_from_pixels

MARKER_S = 0.5    # RViz removes a marker that is not renewed within this time
THICKNESS_M = 0.002
LINE_M = 0.01
LABEL = 0.85      # distance of the label above the center of its tag, in sides of the tag
TAG_COLOR, TEXT_COLOR, AREA_COLOR = (1, 1, 1, 0.8), (1, 0.8, 0, 1), (0.6, 0, 1, 1)


def quaternion(rotation):
    """A rotation matrix, (3, 3), as a geometry_msgs/Quaternion (S. W. Shepperd, 1978).

    The matrix gives the product of any two of x, y, z and w. The row with the largest square is the most exact,
    for half turns too.
    """
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    products = [(1 + a - e - i, b + d, c + g, h - f), (b + d, 1 - a + e - i, f + h, c - g),
                (c + g, f + h, 1 - a - e + i, d - b), (h - f, c - g, d - b, 1 + a + e + i)]  # four times each
    _, row = max((row[number], row) for number, row in enumerate(products))
    length = copysign(sqrt(sum(product * product for product in row)), row[3])
    return Quaternion(*(product / length for product in row))


def pose_message(pose):
    """An object with rotation, (3, 3), and translation, (3,) meters, as a geometry_msgs/Pose."""
    return Pose(Point(*pose.translation), quaternion(pose.rotation))


def pose_with_covariance(pose):
    """A pose with its covariance, (6, 6), as a geometry_msgs/PoseWithCovariance."""
    return PoseWithCovariance(pose_message(pose), pose.covariance.ravel().tolist())


def stamped(pose, stamp, frame):
    """A pose in the TF frame ``frame``, as a geometry_msgs/PoseWithCovarianceStamped."""
    return PoseWithCovarianceStamped(Header(stamp=stamp, frame_id=frame), pose_with_covariance(pose))


def tag_poses(poses, lens, header):
    """A list of aruco_ar.TagPose as a unit5/TagPoseArray. ``lens``: the Lens of the frame."""
    return TagPoseArray(header, [TagPoseMessage(
        id=pose.id, corners=points_from_pixels(pose.corners), center=_center(pose, lens), size=pose.size,
        pose=pose_with_covariance(pose), ambiguity=pose.ambiguity) for pose in poses])


def area_pose(pose, lens, header):
    """An aruco_ar.AreaPose as a unit5/AreaPose. ``lens``: the Lens of the frame."""
    return AreaPoseMessage(header, points_from_pixels(pose.corners), _center(pose, lens), pose.width,
                           pose.height, pose_with_covariance(pose))


def _center(pose, lens):
    return points_from_pixels(lens.project(pose.translation[None]))[0]


def transform(pose, stamp, parent, child):
    """The geometry_msgs/TransformStamped of a TF frame ``child`` that has this pose in the frame ``parent``."""
    message = TransformStamped(header=Header(stamp=stamp, frame_id=parent.lstrip('/')),
                               child_frame_id=child)
    message.transform.translation = Vector3(*pose.translation)
    message.transform.rotation = quaternion(pose.rotation)
    return message


def from_transform(message):
    """(rotation (3, 3), translation (3,) meters) of a geometry_msgs/Transform."""
    x, y, z, w = (getattr(message.rotation, name) for name in 'xyzw')
    half = np.array([x, y, z])
    turn = half * (2 * np.arctan2(np.linalg.norm(half), w) / max(np.linalg.norm(half), 1e-12))
    place = message.translation
    return cv2.Rodrigues(turn)[0], np.array([place.x, place.y, place.z])


def markers(poses, area, header):
    """A visualization_msgs/MarkerArray for RViz: a plate and a label for each TagPose, and the area's outline.

    ``area``: an AreaPose, or None for no outline.
    """
    found, ids = [], [pose.id for pose in poses]
    for count, pose in enumerate(poses):
        number = pose.id if ids.count(pose.id) == 1 else -1 - count  # RViz needs different ids
        plate = _marker(header, 'tags', number, Marker.CUBE, TAG_COLOR, pose)
        plate.scale = Vector3(pose.size, pose.size, THICKNESS_M)
        label = _marker(header, 'ids', number, Marker.TEXT_VIEW_FACING, TEXT_COLOR, pose)
        label.text, label.scale.z = str(pose.id), pose.size / 2
        label.pose.position = Point(*(pose.translation + LABEL * pose.size * pose.rotation[:, 1]))
        found += [plate, label]
    if area is not None:
        outline = _marker(header, 'area', 0, Marker.LINE_STRIP, AREA_COLOR)
        outline.scale.x = LINE_M
        outline.points = [Point(*point) for point in area.points[[0, 1, 2, 3, 0]]]
        found.append(outline)
    return MarkerArray(found)


def _marker(header, kind, number, shape, color, pose=None):
    return Marker(header=header, ns=kind, id=number, type=shape, action=Marker.ADD, color=ColorRGBA(*color),
                  pose=Pose(orientation=Quaternion(w=1.0)) if pose is None else pose_message(pose),
                  lifetime=Duration(MARKER_S))
