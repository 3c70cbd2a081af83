"""The sensor_msgs/CameraInfo of a camera: where it is published, and the Lens that it describes."""
import re

import numpy as np
from aruco_ar.base.errors import InputError, shorten
from aruco_ar.geometry.lens import Lens
from sensor_msgs.msg import CameraInfo, RegionOfInterest

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
NO_CALIBRATION = 'camera_info without calibration'  # a kind of InputErrors
CALIBRATE = 'Calibrate it: rosrun unit5 calibrate_camera.py --help'
MAX_FOCAL_PX = 1e6
FOCAL_SHARES = 0.1, 100  # limits of the focal length, divided by the image's longer side: 157 to 0.6 degrees
MIDDLE = 0.1             # the center of a lens is within this share of a side around the middle
MAX_ASPECT = 2           # limit of the ratio of the focal lengths across and down
MAX_BLIND = 0.05         # this share of the image may show no ray before that is told


def info_topics(camera):
    """The names that the CameraInfo topic of a camera's raw image topic may have: beside it, or below it."""
    return camera.rpartition('/')[0] + '/camera_info', camera + '/camera_info'


def lens_from_info(info, size, rectified=False, scale=1.0, notes=None):
    """The Lens that a CameraInfo describes, for frames of this size, (width, height) pixels.

    ``rectified``: whether the distortion has been removed from the frames. ``scale``: the factor by which the
    frames were resized after they arrived. ``notes``: a dict that gets {kind: sentence} for what was read in
    the only sensible way. Raises InputError, with a kind, if the CameraInfo cannot be used.
    """
    notes, (width, height), size = {} if notes is None else notes, size, np.array(size)
    uses_p = rectified and np.any(info.P)
    if rectified and not uses_p:
        notes['P'] = 'its P is all zero, so its K is used for the rectified frames.'
    matrix = np.array(info.P).reshape(3, 4)[:, :3] if uses_p else np.array(info.K).reshape(3, 3)
    whole, arrived = _sizes(info, matrix[:2, 2], size / scale, notes)
    _check_size(arrived, size, scale)
    if not np.all(np.isfinite(matrix)) or np.any(matrix[[0, 1], [0, 1]] <= 0) or \
            np.any(matrix[2] != [0, 0, 1]) or matrix[1, 0] != 0 or np.any(np.abs(matrix) > MAX_FOCAL_PX):
        raise InputError('its %s is not a camera matrix, so the camera is not calibrated. %s'
                         % ('P' if uses_p else 'K', CALIBRATE), kind=NO_CALIBRATION)
    _check_possible(matrix, *whole)
    distortion, fisheye = (np.array([]), False) if rectified else _distortion(info, notes)
    lens = Lens(width, height, _matrix_of_frames(info, matrix, size / arrived), distortion, fisheye)
    blind = 0.0 if fisheye else _blind_share(lens)  # a fisheye's image may be round
    if blind > MAX_BLIND:
        notes['blind'] = 'its distortion folds back, so %.0f %% of the image show no ray, and tags there are ' \
            'not used. Calibrate with the sheet in the corners, too (calibrate_live.launch), or give ' \
            'lens:=ignore.' % (100 * blind)
    return lens


def info_of_frames(info, size, header, scale=1.0):
    """The CameraInfo of frames of this size, (width, height) pixels, with their header.

    ``info``: that of their camera, which lens_from_info accepts. ``scale``: see there.
    """
    about = {name: getattr(info, name) for name in CameraInfo.__slots__}
    size, old = np.array(size), np.array(info.P).reshape(3, 4)
    matrix = np.array(info.K).reshape(3, 3)
    _, arrived = _sizes(info, matrix[:2, 2], size / scale, {})
    if np.any(arrived != (info.width, info.height)) or np.any(arrived != size):  # not the whole image
        resized = size / arrived
        new = np.hstack([_matrix_of_frames(info, old[:, :3], resized), old[:, 3:]])
        new[:2, 3] *= resized / _binning(info)
        about.update(width=int(size[0]), height=int(size[1]), binning_x=0, binning_y=0, roi=RegionOfInterest(),
                     K=_matrix_of_frames(info, matrix, resized).ravel().tolist(),
                     P=(new if np.any(old) else old).ravel().tolist())
    return CameraInfo(**{**about, 'header': header})


def _sizes(info, center, arrived, notes):
    """The sizes, (2,) pixels, of the whole image that a CameraInfo is for, and of the frames it is for.

    The first is 0, 0 if only the size of the region of interest is known. ``center``: that of its matrix.
    ``arrived``: the size of the frames that arrived, which may be what it is for. Raises InputError.
    """
    whole, region = np.array([info.width, info.height]), np.array([info.roi.width, info.roi.height])
    if 0 in region:
        full = arrived * _binning(info)
        if 0 in whole and np.all(np.abs(center / full - 0.5) < MIDDLE):
            whole = full
            notes['size'] = 'it does not say for what size of frames it is, but its center fits these.'
        region = whole
    of_frames = region // _binning(info)
    if np.any(of_frames == 0):
        raise InputError('it does not say for what size of frames it is, so the camera is not calibrated. '
                         + CALIBRATE, kind='camera_info without a size')
    return whole, of_frames


def _binning(info):
    """(2,): how many pixels of the sensor are one of a frame, across and down."""
    return np.maximum([info.binning_x, info.binning_y], 1)


def _check_size(arrived, size, scale):
    """Raise an InputError unless a CameraInfo for frames of the size ``arrived`` is for those of ``size``.

    Both are (2,) pixels. ``scale``: see lens_from_info.
    """
    if np.all(np.abs(arrived * scale - size[::-1]) <= 1) and arrived[0] != arrived[1]:
        raise InputError('it is for frames of %d x %d pixels, but the frames have %d x %d: one of the two is '
                         'turned, as those of a phone that was held upright are. Turn the source of the frames '
                         'back, or calibrate with the frames of this topic: calibrate_live.launch'
                         % (*arrived, *np.round(size / scale)), kind='camera_info of turned frames')
    if np.any(np.abs(arrived * scale - size) > 1):
        raise InputError('it is for frames of %d x %d pixels, but the frames have %d x %d. Calibrate the '
                         'camera at the size at which it runs' % (*arrived, *np.round(size / scale)),
                         kind='camera_info of another size')


def _matrix_of_frames(info, matrix, resized):
    """(3, 3): the camera matrix of the frames, from that of the whole image.

    CameraInfo.msg explains the region of interest and the binning. ``resized``: (2,), by which factors the
    frames were resized after them. The middle of the first pixel is (0, 0) before and after that.
    """
    matrix = matrix.copy()
    matrix[:2, 2] -= info.roi.x_offset, info.roi.y_offset
    matrix[:2] /= _binning(info)[:, None]
    matrix[:2, 2] += 0.5
    matrix[:2] *= resized[:, None]
    matrix[:2, 2] -= 0.5
    return matrix


def _blind_share(lens):
    """Which share of a lens's image has no ray."""
    across, down = np.linspace(0, lens.width - 1, 33), np.linspace(0, lens.height - 1, 25)
    return np.isnan(lens.rays(np.stack(np.meshgrid(across, down), axis=-1))).any(axis=-1).mean()


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
