"""Views of a sheet of tags through simulated lenses: where its corners are found, without any image."""
import cv2
import numpy as np
from aruco_ar import Lens
from aruco_ar.calibration.views import View
from aruco_ar.tags.corner_rays import found_corners

SIZE = 640, 480
MATRIX = np.array([[560.0, 0, 322.0], [0, 558.0, 236.0], [0, 0, 1]])
LENSES = {'no distortion': Lens(*SIZE, MATRIX, np.zeros(5)),
          'barrel': Lens(*SIZE, MATRIX, np.array([-0.3, 0.1, 0.001, -0.001, 0])),
          'webcam': Lens(*SIZE, MATRIX, np.array([0.08, -0.18, 0.0, 0.002, 0.05])),
          'fisheye': Lens(*SIZE, MATRIX * [[0.6], [0.6], [1]] + [[0, 0, 129], [0, 0, 94], [0, 0, 0]],
                          np.array([0.02, -0.01, 0.0, 0.0]), True)}


def sheet(columns=4, rows=3, gap=1.4):
    """{id: (4, 2)}: tags of side 1, some of them turned, and none exactly in a row."""
    layout, random = {}, np.random.RandomState(5)
    square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    for number in range(columns * rows):
        angle = number % 4 * np.pi / 2 + random.normal(0, 0.05)
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        layout[number + 10] = square @ turn + (number % columns * gap, number // columns * gap) \
            + random.normal(0, 0.05, 2)
    return layout


def views_of(lens, layout, count=40, noise=0.05, tilt=0.6, seed=0, away=0.45):
    """Views of a sheet that is moved and tilted at random, as a Detector finds its tags in the frame.

    ``away``: from the middle of the frame, at most, as a share of its width.
    """
    random, views = np.random.RandomState(seed), []
    middle = np.concatenate(list(layout.values())).mean(axis=0)
    reach = 2 if lens.fisheye else 1
    while len(views) < count:
        turn = cv2.Rodrigues(random.uniform(-tilt, tilt, 3) * (1, 1, 0.5))[0]
        depth = random.uniform(4, 9) / reach
        shift = np.array([*(random.uniform(-away, away, 2) * (1.1, 0.8) * depth * reach), depth])
        view = {}
        for tag_id, corners in layout.items():
            seen = np.column_stack([corners - middle, np.zeros(4)]) @ turn.T + shift
            pixels = found_corners(lens, seen[None, :, :2] / seen[None, :, 2:])[0]
            if np.all(np.isfinite(pixels)) and np.all(pixels > 0) and np.all(pixels < np.array(SIZE) - 1):
                view[tag_id] = pixels + random.normal(0, noise, (4, 2))
        if len(view) >= 2:
            views.append(View(view))
    return views
