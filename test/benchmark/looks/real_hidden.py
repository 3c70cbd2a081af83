"""A tag painted onto bare ground of a published clip, and hidden, against the frame without it."""
import os

import cv2
import numpy as np
from aruco_ar import Area, Tag
from aruco_ar.base.progress import tell
from aruco_ar.looks.hidden_tags import HiddenTags
from aruco_ar.tags.tag import tag_cells

from .hidden import psnr

# Where the ground is bare: clip, frame, middle and side of the tag in pixels.
SPOTS = {'paper': ('board.mp4', 10, (1740, 551), 80),
         'floor': ('pushed.mp4', 44, (842, 326), 70),
         'floor, light falls off': ('pushed.mp4', 44, (614, 490), 70)}
# The tag is slanted. Corners in sides of the tag; its ink as a share of the paper; the blur in pixels.
CORNERS = np.array([[-0.56, -0.43], [0.56, -0.38], [0.4, 0.55], [-0.56, 0.41]])
INK, BLUR_PX = 0.14, 0.8
FINER, CELL_PX = 4, 20
NEAR_PX = 7  # width of the window around the tag's pixels that are judged


def with_tag(frame, middle, side, tag_id=3):
    """(the frame with a tag on it, the Tag, (h, w) bool: the pixels that it changes)."""
    corners = np.array(middle) + side * CORNERS
    cells = np.kron(np.where(tag_cells('DICT_6X6_250', tag_id) > 0, 1, INK), np.ones((CELL_PX, CELL_PX)))
    square = np.float32([[0, 0], [1, 0], [1, 1], [0, 1]]) * len(cells) - 0.5
    height, width = frame.shape[:2]
    to_fine = cv2.getPerspectiveTransform(square, np.float32((corners + 0.5) * FINER - 0.5))
    ink = cv2.warpPerspective(cells, to_fine, (width * FINER, height * FINER), borderValue=1)
    ink = cv2.GaussianBlur(cv2.resize(ink, (width, height), interpolation=cv2.INTER_AREA), (0, 0), BLUR_PX)
    return np.uint8(np.round(frame * ink[..., None])), Tag(tag_id, np.float32(corners)), ink < 0.98


def run(clips):
    """Print the table, for those of the clips (see clips.Clip) that have a spot."""
    tell('\ntags:=hide on real ground, in the first frame: PSNR in dB against the frame without the tag\n')
    for name, (file, number, middle, side) in SPOTS.items():
        for clip in clips:
            if os.path.basename(clip.path) == file:
                frame = clip.frames()[0][number]
                image, tag, changed = with_tag(frame, middle, side)
                height, width = frame.shape[:2]
                area = Area(np.float32([[0, 0], [width, 0], [width, height], [0, height]]))
                HiddenTags().hide(image.copy(), image, area, [tag], is_located=True, keep=False)
                near = cv2.dilate(changed.astype(np.uint8), np.ones((NEAR_PX, NEAR_PX))) > 0
                tell('%-26s %-12s %6.1f' % (name, file, psnr(image, frame, near)))
