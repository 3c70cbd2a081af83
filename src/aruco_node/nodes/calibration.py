"""The camera's calibration, from its sensor_msgs/CameraInfo."""
import time

import numpy as np
import rospy
from aruco_ar.base.errors import InputError, shorten
from aruco_ar.geometry.lens import Lens
from rosgraph.names import is_legal_name
from sensor_msgs.msg import CameraInfo

from aruco_node.health.faults import fault_barrier
from aruco_node.health.silence import SILENCE_S
from aruco_node.parameters.parameters import AUTO
from aruco_node.ros_internals.subscribers import tolerant

# How many distortion coefficients each model may have. 0 of them mean no distortion.
MODELS = {'plumb_bob': (0, 4, 5), 'rational_polynomial': (0, 8, 12, 14), 'equidistant': (0, 4),
          '': (0, 4, 5, 8)}
# Kinds of InputErrors.
NO_CAMERA_INFO, NO_CALIBRATION = 'no camera_info', 'camera_info without calibration'
CALIBRATE = 'Calibrate it: rosrun unit5 calibrate_camera.py --help'
FISHEYE = 'equidistant'
MAX_FOCAL_PX = 1e6
FOCAL_SHARES = 0.1, 100  # limits of the focal length, divided by the image's longer side: 157 to 0.6 degrees
MAX_ASPECT = 2           # limit of the ratio of the focal lengths across and down
RECTIFIED = 'image_rect'  # image_proc's name of the topic of rectified frames


def lens_from_info(info, size, rectified=False, scale=1.0):
    """The Lens that a CameraInfo describes, for frames of this size, (width, height) pixels.

    ``rectified``: whether the distortion has been removed from the frames. ``scale``: the factor by which the
    frames were resized after they arrived. Raises InputError, with a kind, if the CameraInfo cannot be used.
    """
    binning = np.maximum([info.binning_x, info.binning_y], 1)
    corner = np.array([info.roi.x_offset, info.roi.y_offset])
    region = (info.roi.width, info.roi.height)
    if 0 in region:
        region = (info.width, info.height)
    original = region // binning
    if np.any(original == 0):
        raise InputError('it does not say for what size of frames it is, so the camera is not calibrated. '
                         + CALIBRATE, kind='camera_info without a size')
    if np.all(np.abs(original * scale - size[::-1]) <= 1) and original[0] != original[1]:
        raise InputError('it is for frames of %d x %d pixels, but the frames have %d x %d: one of the two is '
                         'turned, as those of a phone that was held upright are. Turn the source of the frames '
                         'back, or calibrate with the frames of this topic: calibrate_live.launch'
                         % (*original, *np.round(np.array(size) / scale)), kind='camera_info of turned frames')
    if np.any(np.abs(original * scale - size) > 1):
        raise InputError('it is for frames of %d x %d pixels, but the frames have %d x %d. Calibrate the '
                         'camera at the size at which it runs' % (*original, *np.round(np.array(size) / scale)),
                         kind='camera_info of another size')
    matrix = np.array(info.P).reshape(3, 4)[:, :3] if rectified else np.array(info.K).reshape(3, 3)
    if not np.all(np.isfinite(matrix)) or np.any(matrix[[0, 1], [0, 1]] <= 0) or \
            np.any(matrix[2] != [0, 0, 1]) or matrix[1, 0] != 0 or np.any(np.abs(matrix) > MAX_FOCAL_PX):
        raise InputError('its %s is not a camera matrix, so the camera is not calibrated. %s'
                         % ('P' if rectified else 'K', CALIBRATE), kind=NO_CALIBRATION)
    _check_possible(matrix, info.width, info.height)
    distortion = np.array([] if rectified else info.D, np.float64)
    fisheye = not rectified and info.distortion_model == FISHEYE
    if fisheye and not len(distortion):
        distortion = np.zeros(4)  # a fisheye lens without distortion is not a pinhole
    if not rectified and (len(distortion) not in MODELS.get(info.distortion_model, ())
                          or not np.all(np.isfinite(distortion))):
        raise InputError('its distortion model "%s" with %d coefficients is not supported. Supported are '
                         'plumb_bob (4 or 5), rational_polynomial (8, 12 or 14) and equidistant (4)'
                         % (shorten(info.distortion_model, 40), len(distortion)),
                         kind='camera_info with another distortion')
    # CameraInfo.msg explains the region and the binning. The middle of the first pixel is (0, 0) before
    # and after resizing, hence the 0.5.
    matrix[:2, 2] -= corner
    matrix[:2] /= binning[:, None]
    resized = size / original
    matrix[:2, 2] += 0.5
    matrix[:2] *= resized[:, None]
    matrix[:2, 2] -= 0.5
    return Lens(size[0], size[1], matrix, distortion, fisheye)


def _check_possible(matrix, width, height):
    """Raise an InputError if no lens has this camera matrix, (3, 3), for images of width x height pixels."""
    if not width or not height:
        return  # only the size of the region of interest is known, but not where the middle is in it
    focal, center, size = matrix[[0, 1], [0, 1]], matrix[:2, 2], np.array([width, height])
    impossible = (focal < FOCAL_SHARES[0] * size.max()) | (focal > FOCAL_SHARES[1] * size.max())
    why = ''
    if np.any(impossible):
        why = 'says that the focal length is %.4g px' % focal[impossible][0]
    elif focal.max() > MAX_ASPECT * focal.min():
        why = 'has the focal lengths %.4g and %.4g px' % tuple(focal)
    elif np.any(center < 0) or np.any(center > size):
        why = 'has its center at (%.4g, %.4g)' % tuple(center)
    if why:
        raise InputError('it %s, which no lens has for frames of %d x %d pixels, so the camera is not '
                         'calibrated. %s' % (why, width, height, CALIBRATE), kind=NO_CALIBRATION)


def info_topic(camera):
    """The name of the CameraInfo topic that belongs to a camera's raw image topic."""
    return camera.rpartition('/')[0] + '/camera_info'


def is_rectified(settings, camera):
    """Whether the frames on the raw topic ``camera`` are rectified, by PoseSettings or by the topic's name."""
    return camera.rpartition('/')[2].startswith(RECTIFIED) if settings.rectified == AUTO else settings.rectified


class Calibration:
    """Subscribes to the camera's CameraInfo, and makes a Lens of it."""

    def __init__(self, settings, camera):
        """``camera``: the resolved name of the camera's raw topic.

        Raises InputError if the parameter ~camera_info is not a topic name.
        """
        if not is_legal_name(settings.camera_info):
            raise InputError('The parameter ~camera_info is "%s"; it must be the name of a topic.'
                             % settings.camera_info)
        self.rectified = is_rectified(settings, camera)
        self.topic = info_topic(camera) if settings.camera_info == AUTO else \
            rospy.resolve_name(settings.camera_info)
        self._info = self._lens = self._subscriber = None
        self._lens_input = None  # what self._lens was made from

    def update_subscription(self, wanted):
        """Subscribe to the topic if it is wanted, else leave it."""
        if wanted and self._subscriber is None:
            self._subscribed_at = time.monotonic()
            self._subscriber = rospy.Subscriber(self.topic, tolerant(CameraInfo), self._on_info, queue_size=1)
        elif not wanted and self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None

    def lens(self, size, scale):
        """The Lens for frames of this size, (width, height) pixels; None until a CameraInfo has arrived.

        ``scale``: the factor by which the frames were resized. Raises InputError if no CameraInfo arrives
        within SILENCE_S, or if it cannot be used.
        """
        info = self._info
        if info is None:
            if time.monotonic() - self._subscribed_at < SILENCE_S:
                return None
            raise InputError('nothing arrives on it. Start the camera with its calibration, or name the topic: '
                             'camera_info:=TOPIC', kind=NO_CAMERA_INFO)
        if self._lens_input != (info, size, scale):
            self._lens = lens_from_info(info, size, self.rectified, scale)
            self._lens_input = info, size, scale
        return self._lens

    @fault_barrier
    def _on_info(self, info):
        info.header = None  # the stamp would make every message look like a new calibration
        if info != self._info:
            self._info = info
