"""What a sensor_msgs/CameraInfo says of the camera, and what may be wrong with it."""
import time

import numpy as np
import rospy
from aruco_ar.base.errors import InputError, shorten
from aruco_ar.poses.lens import Lens
from rosgraph.names import is_legal_name
from sensor_msgs.msg import CameraInfo

from aruco_node.health.faults import guarded
from aruco_node.health.silence import SILENCE_S
from aruco_node.parameters.parameters import AUTO
from aruco_node.ros_internals.tolerant import tolerant

# How many distortion coefficients each model may have; none means no distortion.
MODELS = {'plumb_bob': (0, 4, 5), 'rational_polynomial': (0, 8, 12, 14), 'equidistant': (0, 4),
          '': (0, 4, 5, 8)}
FISHEYE = 'equidistant'
MAX_FOCAL_PX = 1e6
RECTIFIED = 'image_rect'  # so image_proc calls the topics of frames without distortion


def lens_from_info(info, size, rectified=False, scale=1.0):
    """The Lens of frames of that size, (width, height) pixels, by a CameraInfo.

    ``rectified``: whether the lens is corrected in the frames already.
    ``scale``: by which they were resized after they came. Raises InputError,
    with a kind, if the CameraInfo cannot be used.
    """
    binning = np.maximum([info.binning_x, info.binning_y], 1)
    corner = np.array([info.roi.x_offset, info.roi.y_offset])
    part = (info.roi.width, info.roi.height)
    if 0 in part:
        part = (info.width, info.height)
    came = part // binning
    if np.any(came == 0):
        raise InputError('it does not say for what size of frames it is. Calibrate the camera: rosrun '
                         'camera_calibration cameracalibrator.py', kind='camera_info without a size')
    if np.any(np.abs(came * scale - size) > 1):
        raise InputError('it is for frames of %d x %d pixels, but they have %d x %d. Calibrate the camera at '
                         'the size at which it runs' % (*came, *np.round(np.array(size) / scale)),
                         kind='camera_info of another size')
    matrix = np.array(info.P).reshape(3, 4)[:, :3] if rectified else np.array(info.K).reshape(3, 3)
    if not np.all(np.isfinite(matrix)) or np.any(matrix[[0, 1], [0, 1]] <= 0) or \
            np.any(matrix[2] != [0, 0, 1]) or matrix[1, 0] != 0 or np.any(np.abs(matrix) > MAX_FOCAL_PX):
        raise InputError('its %s is that of no camera, so it is not calibrated. Calibrate it: rosrun '
                         'camera_calibration cameracalibrator.py' % ('P' if rectified else 'K'),
                         kind='camera_info without calibration')
    distortion = np.array([] if rectified else info.D, np.float64)
    fisheye = not rectified and info.distortion_model == FISHEYE
    if fisheye and not len(distortion):
        distortion = np.zeros(4)  # which is not the same as a pinhole without distortion
    if not rectified and (len(distortion) not in MODELS.get(info.distortion_model, ())
                          or not np.all(np.isfinite(distortion))):
        raise InputError('its distortion "%s" of %d numbers is not known; known are plumb_bob (4 or 5), '
                         'rational_polynomial (8, 12 or 14) and equidistant (4)'
                         % (shorten(info.distortion_model, 40), len(distortion)),
                         kind='camera_info with another distortion')
    # As CameraInfo.msg says; and the middle of the first pixel is (0, 0) before and after resizing.
    matrix[:2, 2] -= corner
    matrix[:2] /= binning[:, None]
    resized = size / came
    matrix[:2, 2] += 0.5
    matrix[:2] *= resized[:, None]
    matrix[:2, 2] -= 0.5
    return Lens(size[0], size[1], matrix, distortion, fisheye)


def info_topic(camera):
    """The name of the calibration beside a camera's raw images."""
    return camera.rpartition('/')[0] + '/camera_info'


def is_rectified(settings, camera):
    """Whether the lens is corrected in frames on the raw topic ``camera`` already, by PoseSettings."""
    return camera.rpartition('/')[2].startswith(RECTIFIED) if settings.rectified == AUTO else settings.rectified


class Calibration:
    """The Lens of the camera's frames, as soon as it is known."""

    def __init__(self, settings, camera):
        """``camera``: the resolved name of the camera's raw topic.

        Raises InputError if there can be no such topic.
        """
        if not is_legal_name(settings.camera_info):
            raise InputError('The parameter ~camera_info is "%s"; that is no name of a topic.'
                             % settings.camera_info)
        self.rectified = is_rectified(settings, camera)
        self.topic = info_topic(camera) if settings.camera_info == AUTO else \
            rospy.resolve_name(settings.camera_info)
        self._info = self._made_for = self._lens = self._subscriber = None

    def follow(self, wanted):
        """Listen to the topic, or leave it."""
        if wanted and self._subscriber is None:
            self._since = time.monotonic()
            self._subscriber = rospy.Subscriber(self.topic, tolerant(CameraInfo), self._on_info, queue_size=1)
        elif not wanted and self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None

    def lens(self, size, scale):
        """The Lens of frames of that size, (width, height) pixels; None until a camera_info has come.

        ``scale``: by which they were resized. Raises InputError if none comes for
        long, or if it cannot be used.
        """
        info = self._info
        if info is None:
            if time.monotonic() - self._since < SILENCE_S:
                return None
            raise InputError('nothing arrives on it. Start the camera with its calibration, or say where it '
                             'is: camera_info:=TOPIC', kind='no camera_info')
        if self._made_for != (info, size, scale):
            self._lens = lens_from_info(info, size, self.rectified, scale)
            self._made_for = info, size, scale
        return self._lens

    @guarded
    def _on_info(self, info):
        info.header = None  # else each is another
        if info != self._info:
            self._info = info
