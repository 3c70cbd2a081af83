"""Names for the types of arrays, for annotations; shapes, dtypes and units are in the docstrings.

Only a type checker looks at them: when the program runs they are mere words, and NumPy may be too old to
know of types.
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import cv2.typing
    import numpy as np
    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import TypeAlias

Image: TypeAlias = 'cv2.typing.MatLike'  # what OpenCV takes and gives: frames, pictures, masks; uint8
Floats: TypeAlias = 'NDArray[np.floating[Any]]'
Integers: TypeAlias = 'NDArray[np.integer[Any]]'
Complexes: TypeAlias = 'NDArray[np.complexfloating[Any, Any]]'
Booleans: TypeAlias = 'NDArray[np.bool_]'
Numbers: TypeAlias = 'ArrayLike'         # an array, or a list that becomes one

Color: TypeAlias = 'tuple[float, float, float]'  # blue, green, red

NO_ARRAY: Any = None  # where OpenCV takes None for one, which its own annotations do not say

# Rotation (3, 3), translation (3,) and covariance (6, 6); of several things, or of both poses of each, with
# axes before these.
Pose: TypeAlias = 'tuple[Floats, Floats, Floats]'

View: TypeAlias = 'tuple[Floats, Floats]'  # rotation (3, 3) and translation (3,), meters: from wall to camera
