"""Importing this module raises SetupError if Python or a library is missing or too old."""
from .versions import need

for each in 'python', 'numpy', 'cv2', 'PIL':
    need(each)
