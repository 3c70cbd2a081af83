"""Refuses to be imported, with a TooOld, where something is missing or too old."""
from .versions import need

for each in 'python', 'numpy', 'cv2', 'PIL':
    need(each)
