"""Decoding the pictures of a camera, JPEG or PNG, whose headers Pillow has read.

If simplejpeg is installed, it decodes JPEGs in about half of Pillow's time, to the same pixels. Both use the
library libjpeg-turbo, but Pillow has a format of its own in memory, to and from which it copies all pixels.
OpenCV would be almost as fast. But it takes JPEGs that are cut off, and prints a line for each that is damaged.
"""
import cv2
import numpy as np

try:
    from simplejpeg import decode_jpeg
except Exception:  # also others than ImportError, if it was built for another NumPy
    decode_jpeg = None

# Some cameras damage each of their JPEGs a little. After one, simplejpeg is not tried for so many frames.
FRAMES_AFTER_DAMAGE = 300


class PictureDecoder:
    """Decodes the pictures of one camera. The pixels do not depend on whether simplejpeg is installed."""

    def __init__(self):
        self._by_pillow = 0  # how many of the next frames simplejpeg is not tried for

    def __call__(self, picture, data):
        """The frame, (h, w, 3) BGR uint8, of a picture with 8 bits.

        ``picture``: the Pillow image of ``data``, bytes. Only its header has been read. Raises many kinds of
        error if the data is broken.
        """
        if decode_jpeg and not self._by_pillow and picture.format == 'JPEG' and picture.mode in ('L', 'RGB'):
            try:
                return decode_jpeg(data, 'BGR')
            except ValueError:  # it is damaged; Pillow decides whether it can be used
                self._by_pillow = FRAMES_AFTER_DAMAGE
        self._by_pillow = max(0, self._by_pillow - 1)
        rgb = picture if picture.mode == 'RGB' else picture.convert('RGB')
        return cv2.cvtColor(np.asarray(rgb), cv2.COLOR_RGB2BGR)
