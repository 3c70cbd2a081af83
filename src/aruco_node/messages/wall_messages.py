"""The messages that the simulated camera publishes besides frames."""
from math import cos, sin

from aruco_ar.simulation.render import project_rows
from aruco_ar.simulation.robot import CAMERA_FORWARD_M, CAMERA_HEIGHT_M
from aruco_ar.tags.tag import Tag
from geometry_msgs.msg import Quaternion, TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header

from .frame_names import WALL_FRAME, frame_name
from .images import polygon_from_pixels, tags_from_pixels

ODOMETRY_FRAME = 'odom'
ROBOT_FRAME = 'base_link'
CAMERA_FRAME = 'camera_rgb_optical_frame'


def observe(wall, camera, pose, linear, angular, stamp, first, last):
    """The messages that belong to a frame: (the frame's header, {topic: message}).

    ``pose``, ``linear``, ``angular``: the robot's Pose and speed, m/s and rad/s. ``first``, ``last``: the
    views at the moments when the camera reads the frame's first and last row. ``~tags`` and ``~area`` hold the
    true positions in the frame. ``camera_info`` must be published in the namespace of the images.
    """
    header = Header(stamp=stamp, frame_id=frame_name(CAMERA_FRAME))
    return header, {
        'odom': odometry(pose, linear, angular, stamp),
        'camera_info': camera_info(camera, header),
        '~tags': true_tags(wall, first, last, camera, header),
        '~area': true_area(wall, first, last, camera, header),
    }


def camera_info(camera, header):
    """The sensor_msgs/CameraInfo of a simulated Camera."""
    matrix = camera.matrix
    projection = [list(row) + [0.0] for row in matrix]
    return CameraInfo(header=header, width=camera.width, height=camera.height,
                      distortion_model='plumb_bob', D=list(map(float, camera.distortion)),
                      K=matrix.ravel().tolist(), R=[1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0],
                      P=[float(value) for row in projection for value in row])


def odometry(pose, linear, angular, stamp):
    """A Pose and a speed, m/s and rad/s, as nav_msgs/Odometry."""
    message = Odometry(header=Header(stamp=stamp, frame_id=frame_name(ODOMETRY_FRAME)),
                       child_frame_id=frame_name(ROBOT_FRAME))
    message.pose.pose.position.x, message.pose.pose.position.y = pose.x, pose.y
    message.pose.pose.orientation = _heading(pose.heading)
    message.twist.twist.linear.x, message.twist.twist.angular.z = linear, angular
    return message


def robot_transform(pose, stamp):
    """The robot's Pose as the transform from the odometry frame to the robot."""
    return _transform(ODOMETRY_FRAME, ROBOT_FRAME, (pose.x, pose.y, 0.0), _heading(pose.heading),
                      stamp)


def fixed_transforms(stamp):
    """The static transforms: robot to camera, and odometry to wall."""
    return [
        _transform(ROBOT_FRAME, CAMERA_FRAME, (CAMERA_FORWARD_M, 0.0, CAMERA_HEIGHT_M),
                   Quaternion(-0.5, 0.5, -0.5, 0.5), stamp),
        # The wall's x (right) is odometry's -y, its y (up) is z, and its z (out of the wall) is -x.
        _transform(ODOMETRY_FRAME, WALL_FRAME, (0.0, 0.0, 0.0),
                   Quaternion(0.5, -0.5, -0.5, 0.5), stamp)]


def true_tags(wall, first, last, camera, header):
    """The true corners of all tags in front of the camera, inside or outside the frame, as a TagArray."""
    seen = []
    for tag in wall.tags:
        pixels, before_camera = project_rows(tag.corners, first, last, camera)
        if before_camera:
            seen.append(Tag(tag.id, pixels))
    return tags_from_pixels(seen, header)


def true_area(wall, first, last, camera, header):
    """The true corners of the area, inside or outside the frame, as a PolygonStamped.

    It is empty if the wall has no area, or if not all corners are in front of the camera.
    """
    pixels, before_camera = project_rows(wall.area_corners, first, last, camera) if wall.area else ([], True)
    return polygon_from_pixels(pixels if before_camera else [], header)


def _heading(angle):
    return Quaternion(0.0, 0.0, sin(angle / 2), cos(angle / 2))


def _transform(parent, child, place, turn, stamp):
    message = TransformStamped(header=Header(stamp=stamp, frame_id=frame_name(parent)),
                               child_frame_id=frame_name(child))
    message.transform.translation.x, message.transform.translation.y, \
        message.transform.translation.z = place
    message.transform.rotation = turn
    return message
