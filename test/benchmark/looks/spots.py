"""Places of bare ground in published clips and photos, and tags that are painted onto them and hidden."""
import os
from dataclasses import dataclass

import cv2
import numpy as np
from aruco_ar import Area, Tag
from aruco_ar.geometry.homography import UNIT_SQUARE
from aruco_ar.looks.hidden_tags import HiddenTags
from aruco_ar.tags.tag import tag_cells

FRAMES = 3  # a tag is hidden in so many frames one after the other, since the cover learns
# The tag is slanted. Corners in sides of the tag; its ink as a share of the paper; the blur in pixels.
CORNERS = np.array([[-0.56, -0.43], [0.56, -0.38], [0.4, 0.55], [-0.56, 0.41]])
INK, BLUR_PX = 0.14, 0.8
FINER, CELL_PX = 4, 20


@dataclass(frozen=True)
class Spot:
    """A place of bare ground. ``number``: of the frame in the file. ``middle``, ``side``: of a tag, pixels."""

    name: str
    file: str
    number: int
    middle: tuple
    side: int

    def frame(self, folder):
        """(h, w, 3) BGR uint8, or None if the file is neither in the folder nor in ``photos`` beside it."""
        for path in (os.path.join(folder, self.file), os.path.join(folder, '..', 'photos', self.file)):
            if os.path.isfile(path):
                video = cv2.VideoCapture(path)
                for _ in range(self.number):
                    video.grab()
                return video.read()[1]
        return None


FAR, NEAR = '34085369442_304b6bafd9_c.jpg', '33369213973_9d9bb4cc96_c.jpg'
SPOTS = (Spot('paper', 'board.mp4', 10, (1740, 551), 80),
         Spot('black print', 'board.mp4', 10, (842, 719), 46),
         Spot('chipboard', 'board.mp4', 10, (1838, 290), 36),
         Spot('floor', 'pushed.mp4', 44, (842, 326), 70),
         Spot('floor, light falls off', 'pushed.mp4', 44, (614, 490), 70),
         Spot('floor, glare', 'pushed.mp4', 44, (560, 870), 70),
         Spot('floor, dark', 'pushed.mp4', 44, (1000, 640), 90),
         Spot('asphalt', FAR, 0, (250, 470), 56),
         Spot('asphalt, near', NEAR, 0, (120, 440), 56),
         Spot('table', 'tag_245-246_d7_14cm.png', 0, (640, 760), 100),
         Spot('paper on a table', 'singlemarkersoriginal.jpg', 0, (200, 370), 40),
         Spot('carpet (negative)', 'turned.avi', 5, (290, 650), 60),
         Spot('door (negative)', 'turned.avi', 5, (1235, 400), 60))


def with_tag(frame, middle, side, tag_id=3, corners=CORNERS):
    """(the frame with a tag on it, the Tag, (h, w) bool: the pixels that it changes)."""
    corners = np.array(middle) + side * corners
    cells = np.kron(np.where(tag_cells('DICT_6X6_250', tag_id) > 0, 1, INK), np.ones((CELL_PX, CELL_PX)))
    square = np.float32(UNIT_SQUARE * len(cells) - 0.5)
    height, width = frame.shape[:2]
    to_fine = cv2.getPerspectiveTransform(square, np.float32((corners + 0.5) * FINER - 0.5))
    ink = cv2.warpPerspective(cells, to_fine, (width * FINER, height * FINER), borderValue=1)
    ink = cv2.GaussianBlur(cv2.resize(ink, (width, height), interpolation=cv2.INTER_AREA), (0, 0), BLUR_PX)
    return np.uint8(np.round(frame * ink[..., None])), Tag(tag_id, np.float32(corners)), ink < 0.98


def hidden(frame, tag):
    """The frame, (h, w, 3) BGR uint8, with the tag in it hidden."""
    height, width = frame.shape[:2]
    area, tags = Area(np.float32([[0, 0], [width, 0], [width, height], [0, height]])), HiddenTags()
    for _ in range(FRAMES):
        image = frame.copy()
        tags.hide(frame, image, area, [tag], is_located=True, keep=False)
    return image
