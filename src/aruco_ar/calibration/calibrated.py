"""The result of a calibration, and which views it lacks."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

from aruco_ar.geometry.lens import Lens

TRY_FISHEYE = ' If straight lines look bent, the lens may be a fisheye: --fisheye, or model:=fisheye.'
GOOD_COVERAGE = 0.8         # less does not tell what the lens does at the corners
GOOD_ERROR = 1 / 1280       # of the frame's width: a lens that is off by more, or than GOOD_ERROR_PX, is bad
GOOD_ERROR_PX = 1.0
MAX_LISTED = 4              # number of parts of the frame that are named at most; more are hard to read
SIDES = 'left side', 'right side', 'top', 'foot'
GOOD_CORNERS_PX = 0.5       # see Calibrated.corners


@dataclass(frozen=True)
class Calibrated:
    """The result. ``lens``: the Lens. ``rms``: how far its points are off, pixels (root of the mean square).

    ``held_out``: the same for views that a lens from the others has not seen. ``views``: how many were used.
    ``coverage``: the share of the frame's cells with points. ``corners``: by how many pixels the lens may be
    off at the corners of the frame. Lenses from two halves of the views are about twice as far apart; it is
    infinite if a half does not tell a lens. ``unseen``: where in the frame too few points were seen, such as
    top left. ``untilted``: those of SIDES of the sheet that no view shows nearer to the camera than the other.
    """

    lens: Lens
    rms: float
    held_out: float
    views: int
    coverage: float
    corners: float
    unseen: tuple[str, ...] = ()
    untilted: tuple[str, ...] = ()

    def lacks(self) -> str:
        """What is wrong with the lens, and which views mend it, in sentences; empty if it is good."""
        good = max(GOOD_ERROR_PX, GOOD_ERROR * self.lens.width)
        if self.held_out > good:
            return 'This lens is bad: points are off by %.1f px, and a good one leaves less than %.1f px. ' \
                   'Put the sheet on a flat board, and hold it still in good light.%s' % (
                       self.held_out, good, '' if self.lens.fisheye else TRY_FISHEYE)
        if self.coverage >= GOOD_COVERAGE and self.corners <= GOOD_CORNERS_PX:
            return ''
        off = 'may be off by %.1f px' % self.corners if self.corners < self.lens.width else 'is not known'
        parts = []
        if self.coverage < GOOD_COVERAGE:
            parts.append('in %s of the image' % _listed(['the ' + each for each in self.unseen])
                         if 0 < len(self.unseen) <= MAX_LISTED else 'near the rims of the image')
        if self.untilted:
            parts.append('tilted, with its %s nearer to the camera' % _listed(self.untilted, 'or'))
        return 'At the corners of the image this lens %s. Show the sheet %s, too.' % (
            off, '; and '.join(parts) or 'in more views, near and far')


def _listed(parts: Sequence[str], word: str = 'and') -> str:
    """Several parts of a sentence as one."""
    return (', '.join(parts[:-1]) + ' %s ' % word if len(parts) > 1 else '') + parts[-1]
