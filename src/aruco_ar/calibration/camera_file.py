"""A camera's calibration as a file."""
from __future__ import annotations

import json

import numpy as np

from aruco_ar.base.errors import InputError
from aruco_ar.base.files import yaml_entries
from aruco_ar.geometry.lens import Lens

MODELS = {False: 'plumb_bob', True: 'equidistant'}
COEFFICIENTS = {'plumb_bob': (4, 5), 'rational_polynomial': (8,), 'equidistant': (4,)}  # how many each may have
MAX_UNLIKE = 0.01  # frames may differ from those of a calibration by this in their shape, a share of the width


def camera_yaml(lens: Lens, name: str) -> str:
    """The YAML file of a Lens, as camera_calibration_parsers of ROS reads it. ``name``: that of the camera.

    Its projection matrix is the camera matrix: a rectified image has the same focal length.
    """
    projection = np.column_stack([lens.matrix, np.zeros(3)])
    parts = [('camera_matrix', lens.matrix), ('distortion_coefficients', lens.distortion[None]),
             ('rectification_matrix', np.eye(3)), ('projection_matrix', projection)]
    lines = ['image_width: %d' % lens.width, 'image_height: %d' % lens.height,
             'camera_name: %s' % json.dumps(name, ensure_ascii=False),  # quoted: it may be true, or 12
             'distortion_model: %s' % MODELS[lens.fisheye]]
    for key, matrix in parts:
        rows, columns = matrix.shape
        values = ', '.join('%.8g' % value for value in matrix.ravel())
        lines += ['%s:' % key, '  rows: %d' % rows, '  cols: %d' % columns, '  data: [%s]' % values]
    return '\n'.join(lines) + '\n'


def read_camera(path: str, size: tuple[int, int]) -> Lens:
    """The Lens that a YAML file such as that of camera_yaml describes, for frames of that size.

    ``size``: width and height, pixels. If it is another one than that of the calibration, but has the same
    shape, the Lens is scaled. Raises InputError, which names the file, if it cannot be used.
    """
    with yaml_entries(path) as entries:
        width, height = int(entries['image_width']), int(entries['image_height'])
        model = entries['distortion_model']
        matrix = np.array(entries['camera_matrix']['data'], np.float64).reshape(3, 3)
        distortion = np.array(entries['distortion_coefficients']['data'], np.float64)
        if model not in COEFFICIENTS or distortion.shape[0] not in COEFFICIENTS[model]:
            raise ValueError('%d coefficients of the model "%s"' % (distortion.shape[0], model))
        if min(width, height) < 1 or not np.isfinite([*matrix.ravel(), *distortion]).all() \
                or min(matrix[0, 0], matrix[1, 1]) <= 0 or matrix[2].tolist() != [0, 0, 1]:
            raise ValueError('its camera_matrix is not one of an image of %d x %d pixels' % (width, height))
    scale = size[0] / width
    if abs(scale * height - size[1]) > MAX_UNLIKE * size[0]:
        raise InputError('The calibration "%s" is for frames of %d x %d pixels, but these have %d x %d. '
                         'Calibrate the camera as it films.' % (path, width, height, *size))
    # The middle of the first pixel is (0, 0), so the image's corner is at -0.5.
    scaled = np.diag([scale, scale, 1.0]) @ matrix
    scaled[:2, 2] += (scale - 1) / 2
    return Lens(*size, scaled, distortion, model == 'equidistant')
