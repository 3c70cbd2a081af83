"""A tag painted onto bare ground of a published clip or photo, and hidden, against the frame without it."""
import cv2
import numpy as np
from aruco_ar.base.progress import tell

from .hidden import psnr
from .spots import SPOTS, hidden, with_tag

NEAR_PX = 7  # width of the window around the tag's pixels that are judged
FINE_PX = 2  # what is finer than this is the roughness of the ground
MARGIN_PX = 4, 20  # the ground beside a tag is this far from it


def roughness(image, tag):
    """The roughness inside of a Tag as a share of that of the ground around it."""
    fine = image.astype(float) - cv2.GaussianBlur(image.astype(float), (0, 0), FINE_PX)
    beside = np.ones(image.shape[:2], np.uint8)
    cv2.fillConvexPoly(beside, np.int32(np.round(tag.corners)), 0)
    away = cv2.distanceTransform(beside, cv2.DIST_L2, 5)
    inside = cv2.distanceTransform(1 - beside, cv2.DIST_L2, 5) > FINE_PX
    return fine[inside].std() / fine[(away > MARGIN_PX[0]) & (away < MARGIN_PX[1])].std()


def run(folder):
    """Print the table, for the spots whose files are in a folder of clips, or in ``photos`` beside it."""
    tell('\ntags:=hide on real ground: PSNR in dB against the frame without the tag; the roughness where the\n'
         'tag was, as a share of that around it, and the same without the tag\n\n'
         '%-26s %6s %10s %12s' % ('', 'PSNR', 'roughness', 'without'))
    for spot in SPOTS:
        frame = spot.frame(folder)
        if frame is not None:
            tagged, tag, changed = with_tag(frame, spot.middle, spot.side)
            image = hidden(tagged, tag)
            near = cv2.dilate(changed.astype(np.uint8), np.ones((NEAR_PX, NEAR_PX))) > 0
            tell('%-26s %6.1f %10.2f %12.2f' % (spot.name, psnr(image, frame, near), roughness(image, tag),
                                                roughness(frame, tag)))
