"""The edges and the noise of a painted picture against those of a printed one."""
import cv2
import numpy as np
from aruco_ar import Tag
from aruco_ar.base.progress import tell
from aruco_ar.geometry.homography import homography_to, transform
from aruco_ar.looks.grain import edge_variance
from aruco_ar.settings.settings import GRAINS

from .painter import Painter
from .scenes import Scene

SECONDS = 3
FIRST_S = 1.0
DARK, LIGHT = 60, 190
PICTURE_PX = np.array([900, 600])
# Pixels of the picture. A smaller level of it shows an edge the sharper, the better its pixels fit the edge.
# So no two sides fit alike.
SQUARE_PX = np.array([[360, 211], [542, 211], [542, 389], [360, 389]])
SQUARE = SQUARE_PX / PICTURE_PX
SCENES = {'noise of 1': Scene(noise=1.0), 'noise of 3': Scene(noise=3.0), 'noise of 10': Scene(noise=10.0),
          'blur of 1 px': Scene(blur=1.0), 'blur of 2 px': Scene(blur=2.0),
          'motion blur of 9 px': Scene(smear=9)}


def target():
    """A dark square with a light checkerboard in it, much like a tag, in a light picture, (h, w, 3) BGR."""
    width, height = PICTURE_PX
    picture = np.full((height, width, 3), LIGHT, np.uint8)
    (left, top), (right, foot) = SQUARE_PX[[0, 2]]
    cells = np.pad(np.indices((6, 6)).sum(axis=0) % 2, 1).astype(np.uint8) * (LIGHT - DARK) + DARK
    picture[top:foot, left:right] = cv2.resize(cells, (right - left, foot - top),
                                               interpolation=cv2.INTER_NEAREST)[..., None]
    return picture


def grain_of(frame, corners):
    """(edges across, edges down, noise): deviations, pixels and gray levels, of the square in a frame."""
    to_frame = homography_to(corners)
    square = transform(to_frame, SQUARE)
    across, down = np.sqrt(edge_variance(frame, [Tag(0, np.float32(square))]))
    x, y = np.round(transform(to_frame, np.array([0.2, 0.5]))).astype(int)
    flat = frame[y - 15:y + 15, x - 15:x + 15].astype(float)
    return across, down, (flat - cv2.GaussianBlur(flat, (0, 0), 5)).std()


def run():
    """Print the table."""
    picture = target()
    tell('\ngrain:=match: the deviations of the edges (across, down, pixels) and of the noise (gray levels)\n'
         'of a picture, medians over the frames\n\n%-22s %-18s %-18s %s' % ('', 'printed', *GRAINS))
    for name, scene in SCENES.items():
        painters = {each: Painter(picture, grain=each) for each in GRAINS}
        found = {each: [] for each in ('printed', *GRAINS)}
        for moment in scene.moments(picture, SECONDS):
            results = {each: painter.paint(moment.bare, moment.stamp)[1]
                       for each, painter in painters.items()}
            results['printed'] = moment.printed
            if moment.stamp >= FIRST_S:
                for each, image in results.items():
                    found[each].append(grain_of(image, moment.corners))
        tell('%-22s %s' % (name, ' '.join('%5.2f %5.2f %5.2f ' % tuple(np.median(values, axis=0))
                                          for values in found.values())))
