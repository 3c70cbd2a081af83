"""The camera's calibration, from its sensor_msgs/CameraInfo."""
import re
import time
from typing import Any, Dict, List

import numpy as np
import rospy
from aruco_ar.base.errors import InputError, shorten
from aruco_ar.geometry.lens import Lens
from rosgraph.names import is_legal_name
from sensor_msgs.msg import CameraInfo

from aruco_node.health.faults import fault_barrier, log_notes
from aruco_node.health.silence import SILENCE_S
from aruco_node.parameters.parameters import AUTO
from aruco_node.ros_internals.master import published_topics
from aruco_node.ros_internals.subscribers import tolerant

PLUMB_BOB, RATIONAL, FISHEYE, NONE = 'plumb_bob', 'rational_polynomial', 'equidistant', 'none'
# Other names of distortion models, in small letters and with _ between words.
READ_AS = {'': PLUMB_BOB, 'radtan': PLUMB_BOB, 'radial_tangential': PLUMB_BOB, 'brown_conrady': PLUMB_BOB,
           'pinhole': PLUMB_BOB, 'perspective': PLUMB_BOB, 'opencv': PLUMB_BOB, 'rational': RATIONAL,
           'fisheye': FISHEYE, 'equi': FISHEYE, 'kannala_brandt': FISHEYE, 'kannala_brandt4': FISHEYE,
           'kannalabrandt': FISHEYE, 'opencv_fisheye': FISHEYE, 'no_distortion': NONE, 'undistorted': NONE}
# How many coefficients each may have. 0 of them mean no distortion. Those of a plumb_bob are the first of a
# rational_polynomial, so their number tells the two apart.
COEFFICIENTS = {PLUMB_BOB: (0, 4, 5, 8, 12, 14), RATIONAL: (0, 4, 5, 8, 12, 14), FISHEYE: (0, 4)}
MOST_OF_PLUMB_BOB = 5
# In the names of models whose lens bends lines even if all coefficients are 0.
OF_FISHEYE = 'fish', 'equi', 'kannala', 'theta', 'omni'
# Kinds of InputErrors.
NO_CAMERA_INFO, NO_CALIBRATION = 'no camera_info', 'camera_info without calibration'
CALIBRATE = 'Calibrate it: rosrun unit5 calibrate_camera.py --help'
MAX_FOCAL_PX = 1e6
FOCAL_SHARES = 0.1, 100  # limits of the focal length, divided by the image's longer side: 157 to 0.6 degrees
MIDDLE = 0.1             # the center of a lens is within this share of a side around the middle
MAX_ASPECT = 2           # limit of the ratio of the focal lengths across and down
RECTIFIED = 'image_rect'  # image_proc's name of the topic of rectified frames
MAX_BLIND = 0.05         # this share of the image may show no ray before that is told
LOOK_S = 1.0             # if no CameraInfo has arrived after this time, others are looked for


def lens_from_info(info, size, rectified=False, scale=1.0, notes=None):
    """The Lens that a CameraInfo describes, for frames of this size, (width, height) pixels.

    ``rectified``: whether the distortion has been removed from the frames. ``scale``: the factor by which the
    frames were resized after they arrived. ``notes``: a dict that gets {kind: sentence} for what was read in
    the only sensible way. Raises InputError, with a kind, if the CameraInfo cannot be used.
    """
    notes, (width, height), size = {} if notes is None else notes, size, np.array(size)
    binning = np.maximum([info.binning_x, info.binning_y], 1)
    corner = np.array([info.roi.x_offset, info.roi.y_offset])
    uses_p = rectified and np.any(info.P)
    if rectified and not uses_p:
        notes['P'] = 'its P is all zero, so its K is used for the rectified frames.'
    matrix = np.array(info.P).reshape(3, 4)[:, :3] if uses_p else np.array(info.K).reshape(3, 3)
    whole, region = np.array([info.width, info.height]), np.array([info.roi.width, info.roi.height])
    if 0 in region:
        if 0 in whole and _is_middle(matrix[:2, 2], size / scale * binning):
            whole = size / scale * binning
            notes['size'] = 'it does not say for what size of frames it is, but its center fits these.'
        region = whole
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
                         'camera at the size at which it runs' % (*original, *np.round(size / scale)),
                         kind='camera_info of another size')
    if not np.all(np.isfinite(matrix)) or np.any(matrix[[0, 1], [0, 1]] <= 0) or \
            np.any(matrix[2] != [0, 0, 1]) or matrix[1, 0] != 0 or np.any(np.abs(matrix) > MAX_FOCAL_PX):
        raise InputError('its %s is not a camera matrix, so the camera is not calibrated. %s'
                         % ('P' if uses_p else 'K', CALIBRATE), kind=NO_CALIBRATION)
    _check_possible(matrix, *whole)
    distortion, fisheye = (np.array([]), False) if rectified else _distortion(info, notes)
    # CameraInfo.msg explains the region and the binning. The middle of the first pixel is (0, 0) before
    # and after resizing, hence the 0.5.
    matrix[:2, 2] -= corner
    matrix[:2] /= binning[:, None]
    resized = size / original
    matrix[:2, 2] += 0.5
    matrix[:2] *= resized[:, None]
    matrix[:2, 2] -= 0.5
    lens = Lens(width, height, matrix, distortion, fisheye)
    blind = 0.0 if fisheye else _blind_share(lens)  # a fisheye's image may be round
    if blind > MAX_BLIND:
        notes['blind'] = 'its distortion folds back, so %.0f %% of the image show no ray, and tags there are ' \
            'not used. Calibrate with the sheet in the corners, too (calibrate_live.launch), or give ' \
            'lens:=ignore.' % (100 * blind)
    return lens


def _blind_share(lens):
    """Which share of a lens's image has no ray."""
    across, down = np.linspace(0, lens.width - 1, 33), np.linspace(0, lens.height - 1, 25)
    return np.isnan(lens.rays(np.stack(np.meshgrid(across, down), axis=-1))).any(axis=-1).mean()


def _is_middle(center, size):
    """Whether the center of a lens, (2,) pixels, is that of images of this size."""
    return bool(np.all(np.abs(center / size - 0.5) < MIDDLE))


def _distortion(info, notes):
    """(coefficients, (n,) float64, whether they are those of the fisheye model) of a CameraInfo."""
    given, coefficients = info.distortion_model, np.array(info.D, np.float64)
    name = re.sub(r'[\s_-]+', '_', given.strip().lower()) if len(given) < 40 else given
    model, kind = READ_AS.get(name, name), 'distortion model'
    if model == NONE:
        notes[kind] = 'its distortion model is "%s"%s.' % (
            given, ', so its coefficients are not used' if np.any(coefficients) else ', so the lens has none')
        return np.array([]), False
    if not np.all(np.isfinite(coefficients)):
        raise InputError('the coefficients of its distortion, D, are not all numbers: %s. %s' % (
            shorten(', '.join('%.4g' % each for each in coefficients[:99]), 80), CALIBRATE),
            kind='camera_info with a broken distortion')
    unknown = () if any(part in name.lower() for part in OF_FISHEYE) else (0,)
    lengths = [length for length in COEFFICIENTS.get(model, unknown)
               if length <= len(coefficients) and not np.any(coefficients[length:])]
    if not lengths:
        raise InputError('its distortion model "%s" with %d coefficients is not supported. Supported are '
                         'plumb_bob (4 or 5), rational_polynomial (8, 12 or 14) and equidistant (4)'
                         % (shorten(given, 40), len(coefficients)), kind='camera_info with another distortion')
    coefficients = coefficients[:max(lengths)]  # without the zeros that some drivers append
    if model != FISHEYE and len(coefficients):
        model = RATIONAL if len(coefficients) > MOST_OF_PLUMB_BOB else PLUMB_BOB
    if given and (given != model or model not in COEFFICIENTS):
        notes[kind] = 'its distortion model "%s" with %d coefficients is read as %s.' % (
            shorten(given, 40), len(info.D),
            model if len(coefficients) or model == FISHEYE else 'no distortion')
    if model == FISHEYE and not len(coefficients):
        coefficients = np.zeros(4)  # a fisheye lens without distortion is not a pinhole
    return coefficients, model == FISHEYE


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


def info_topics(camera):
    """The names that the CameraInfo topic of a camera's raw image topic may have: beside it, or below it."""
    return camera.rpartition('/')[0] + '/camera_info', camera + '/camera_info'


def is_rectified(settings, camera):
    """Whether the frames on the raw topic ``camera`` are rectified, by PoseSettings or by the topic's name."""
    return camera.rpartition('/')[2].startswith(RECTIFIED) if settings.rectified == AUTO else settings.rectified


class InfoSubscriber:
    """Subscribes to the CameraInfo of a camera, which may be published beside its images or below them."""

    def __init__(self, topics, on_info):
        """``topics``: names that the topic may have. ``on_info`` is called with each CameraInfo."""
        self._topics, self._on_info = topics, on_info
        self.topic = topics[0]
        self._subscriber: Any = None  # a rospy.Subscriber
        self.others: List[str] = []  # sorted names of all CameraInfo topics, if this one is not published
        self._has_info, self._look_at = False, 0.0

    def update(self, wanted):
        """Subscribe to the topic if it is wanted, else leave it. Called about once a second."""
        if wanted and self._subscriber is None:
            self.since, self._look_at = time.monotonic(), time.monotonic() + LOOK_S
            self._subscribe()
        elif not wanted and self._subscriber is not None:
            self._unsubscribe()
        elif wanted and not self._has_info and time.monotonic() > self._look_at:
            self._look_at = time.monotonic() + SILENCE_S
            self._look_for_others()

    def _look_for_others(self):
        try:
            found = sorted(topic for topic, kind in published_topics().items() if kind == CameraInfo._type)
        except InputError:
            return  # the master does not answer
        self.others = [] if self.topic in found else found
        topic = next((topic for topic in self._topics if topic in self.others), None)
        if topic is not None:
            rospy.loginfo('Nothing publishes %s, so the calibration is taken from %s.', self.topic, topic)
            self._unsubscribe()
            self.topic, self.others = topic, []
            self._subscribe()

    def _subscribe(self):
        self._subscriber = rospy.Subscriber(self.topic, tolerant(CameraInfo), self._on_message, queue_size=1)

    def _unsubscribe(self):
        self._subscriber.unregister()
        self._subscriber = None

    @fault_barrier
    def _on_message(self, info):
        self._has_info = True
        self._on_info(info)


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
        self._subscriber = InfoSubscriber(
            info_topics(camera) if settings.camera_info == AUTO else [rospy.resolve_name(settings.camera_info)],
            self._on_info)
        self._info = self._lens = None
        self._lens_input = None  # what self._lens was made from

    @property
    def topic(self):
        """The resolved name of the CameraInfo topic."""
        return self._subscriber.topic

    def update_subscription(self, wanted):
        """Subscribe to the topic if it is wanted, else leave it. Called about once a second."""
        self._subscriber.update(wanted)

    def lens(self, size, scale):
        """The Lens for frames of this size, (width, height) pixels; None until a CameraInfo has arrived.

        ``scale``: the factor by which the frames were resized. Raises InputError if no CameraInfo arrives
        within SILENCE_S, or if it cannot be used.
        """
        info = self._info
        if info is None:
            if time.monotonic() - self._subscriber.since < SILENCE_S:
                return None
            others = self._subscriber.others
            raise InputError('nothing arrives on it. %s camera_info:=TOPIC' % (
                'These are published: %s. Choose one:' % ', '.join(others) if others else
                'Start the camera with its calibration, or name the topic:'), kind=NO_CAMERA_INFO)
        if self._lens_input != (info, size, scale):
            notes: Dict[str, str] = {}
            self._lens = lens_from_info(info, size, self.rectified, scale, notes)
            self._lens_input = info, size, scale
            log_notes(self.topic, notes)
        return self._lens

    def _on_info(self, info):
        info.header = None  # the stamp would make every message look like a new calibration
        if info != self._info:
            self._info = info
