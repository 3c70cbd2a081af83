"""Names for the types of arrays, for annotations; the docstrings give shapes, dtypes and units.

The names are plain strings when the program runs, since NumPy may be too old to have such types. Only a type
checker evaluates them.
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import cv2.typing
    import numpy as np
    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import TypeAlias

Image: TypeAlias = 'cv2.typing.MatLike'  # OpenCV's images: frames, pictures, masks; uint8
Floats: TypeAlias = 'NDArray[np.floating[Any]]'
Integers: TypeAlias = 'NDArray[np.integer[Any]]'
Complexes: TypeAlias = 'NDArray[np.complexfloating[Any, Any]]'
Booleans: TypeAlias = 'NDArray[np.bool_]'
Numbers: TypeAlias = 'ArrayLike'         # an array, or a list that can be made into one

Color: TypeAlias = 'tuple[float, float, float]'  # blue, green, red

NO_ARRAY: Any = None  # for OpenCV's optional arrays: its annotations do not allow None, though its functions do

# Rotation (3, 3), translation (3,) and covariance (6, 6). For several things, or for two poses of each, the
# arrays have further axes in front of these.
Pose: TypeAlias = 'tuple[Floats, Floats, Floats]'

# A camera's extrinsics: rotation (3, 3) and translation (3,), meters, from wall coordinates to the camera's.
Extrinsics: TypeAlias = 'tuple[Floats, Floats]'
