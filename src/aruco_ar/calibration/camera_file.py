"""A camera's calibration as a file."""
from __future__ import annotations

import json

import numpy as np

from aruco_ar.geometry.lens import Lens

MODELS = {False: 'plumb_bob', True: 'equidistant'}


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
