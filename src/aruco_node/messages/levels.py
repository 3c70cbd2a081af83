"""Gray levels of 16 bits as 8 bits: by the values that a camera really uses, and steadily."""
import cv2
import numpy as np

WHITES = tuple(2**bits - 1 for bits in (8, 10, 12, 14, 16))  # what white is for a camera's number of bits
SAMPLES = 20000     # number of values of a frame that are looked at, roughly
REST = 0.01         # this share of the values may be above or below the range, such as glints and dead pixels
FEW = 64            # values that would become fewer of the 256 gray levels are spread over more of them
LEAST_WIDTH = 255   # no value becomes more than one gray level
GAIN = 8            # the range becomes narrower only if the contrast grows by at least this factor
PATIENCE = 100      # number of frames in sequence after which a range that does not fit is replaced


class Levels:
    """Scales the frames of one camera to 8 bits, with the same range of values from frame to frame.

    The range is from 0 to the white of a camera of 8, 10, 12, 14 or 16 bits. Gray frames whose values are few
    but large, such as temperatures, have a range around these values. It stays while something bright passes,
    and changes at once if it does not contain half of the values.
    """

    def __init__(self):
        self.range = WHITES[-1], 0  # the values of black and white; before the first frame there is none
        self._unfit = 0             # how many frames in sequence the range has not fitted

    def to_8_bits(self, values, is_gray):
        """Values, (h, n) uint16, as (h, n) uint8. ``is_gray``: whether black may be another value than 0."""
        step = int(np.sqrt(values.size / SAMPLES)) | 1  # odd, so that all colors of a mosaic are among them
        some = values[::step, ::step].ravel()
        rest = int(REST * len(some))
        places = rest, len(some) // 2, len(some) - 1 - rest
        least, middle, most = np.partition(some, places)[list(places)].tolist()
        better = _range_of(least, most, is_gray)
        if not self.range[0] <= middle <= self.range[1]:
            self.range, self._unfit = better, 0
        elif least < self.range[0] or most > self.range[1] or _width(self.range) >= GAIN * _width(better):
            self._unfit += 1
            if self._unfit == PATIENCE:
                self.range, self._unfit = better, 0
        else:
            self._unfit = 0
        black, white = self.range
        if black:
            values = np.maximum(values, np.uint16(black)) - np.uint16(black)
        return cv2.convertScaleAbs(values, alpha=255 / (white - black))


def _range_of(least, most, is_gray):
    """(black, white): the range for values between these two."""
    white = next(each for each in WHITES if each >= most)
    spread = most - least
    if not is_gray or spread * 256 >= FEW * (white + 1):
        return 0, white
    margin = max(spread, LEAST_WIDTH - spread) // 2 + 1
    black = min(max(least - margin, 0), WHITES[-1] - LEAST_WIDTH)
    return black, min(max(most + margin, black + LEAST_WIDTH), WHITES[-1])


def _width(values):
    return values[1] - values[0] + 1
