"""Things of the wall's own color that pass in front of it: what keep leaves in front."""
from dataclasses import replace

import cv2
import numpy as np
from aruco_ar.base.progress import tell
from aruco_ar.simulation.figures import Canvas
from aruco_ar.simulation.render import WallRenderer, project
from aruco_ar.simulation.robot import wall_to_camera
from rig.accuracy.drives import WALL

from . import standing
from .painter import Painter
from .scenes import FRAMES_PER_S, PATH, Scene

BOARD, BEIGE = (216, 219, 221), (158, 187, 207)  # BGR, of the walls
LIGHTER = 4           # gray levels: a thing is lighter than the wall by that, where it faces the camera
DARK, SEAM, NAIL = (42, 40, 38), (120, 118, 116), (176, 196, 220)
ROUND_PX = 7.0        # the sides of a thing bend away from the camera within about twice this width
SHADE_LEVELS = 90.0   # how much darker they get on the side away from the light, and lighter on the other one
SHADOW_PX, SHADOW_AT, SHADOW = 5.0, (7, 5), 0.22  # softness, place (down, to the right) and depth of its shadow
EXPOSURE = 0.05       # the camera's exposure drifts by this share
COMES_S = 2.0
LEAST_PX = 200        # a frame with less of the thing in the area is not judged
SECONDS = 9


def white_robot(canvas, seconds):
    """A robot with a white body that drives in from the left, stands for a second, and leaves to the right."""
    away = seconds - COMES_S
    x = -0.2 + 0.3 * (min(away, 2.6) + max(away - 3.6, 0))
    canvas.polygon(_rounded(x, 0.34, 0.11, 0.12), white(BOARD))
    canvas.polygon(_rounded(x, 0.19, 0.06, 0.055), white(BOARD))
    for side in -1, 1:
        canvas.ellipse((x + 0.075 * side, 0.46), (0.037, 0.037), DARK)
        canvas.ellipse((x + 0.025 * side, 0.185), (0.012, 0.012), DARK)
    canvas.line([(x - 0.107, 0.38), (x + 0.107, 0.38)], 0.004, SEAM)
    canvas.line([(x + 0.035, 0.38), (x + 0.035, 0.45)], 0.004, SEAM)


def pale_hand(canvas, seconds):
    """A hand with an arm that reaches in from below, stays for a second, moves on, and leaves again."""
    away = seconds - COMES_S
    x, y = 0.55 + 0.03 * away, 0.42 + 0.5 * abs(min(away - 1, 0)) + 0.5 * max(away - 5, 0)
    x += 0.06 * np.sin(2 * max(away - 2, 0))
    canvas.line([(x + 0.1, y + 0.9), (x + 0.01, y + 0.05)], 0.1, white(BEIGE))
    canvas.ellipse((x, y), (0.07, 0.08), white(BEIGE))
    for finger in range(4):
        tip = x - 0.06 + 0.035 * finger, y - 0.17 + 0.015 * abs(finger - 1.5)
        canvas.line([(x - 0.045 + 0.03 * finger, y), tip], 0.027, white(BEIGE))
        canvas.ellipse((tip[0], tip[1] + 0.003), (0.007, 0.009), NAIL)
    canvas.line([(x + 0.05, y + 0.02), (x + 0.115, y - 0.06)], 0.032, white(BEIGE))


def white(wall):
    """The color, BGR, of what is as white as a wall."""
    return tuple(level + LIGHTER for level in wall)


def _rounded(x, y, half_width, half_height):
    """(n, 2): the outline of a rounded rectangle."""
    angle = np.linspace(0, 2 * np.pi, 64)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.column_stack([x + half_width * np.sign(cos) * np.sqrt(abs(cos)),
                            y + half_height * np.sign(sin) * np.sqrt(abs(sin))])


class AlikeScene(Scene):
    """A figure in front of a wall of its own color. ``figure``: see figures. ``wall``: BGR."""

    def __init__(self, figure, wall):
        super().__init__(figure)
        self._wall = replace(WALL, color=wall, plaster=0.3)

    def moments(self):
        """Yield the standing.Moments. The thing casts a shadow on the wall."""
        renderer, random = WallRenderer(self._wall, self.camera), np.random.RandomState(1)
        for number in range(SECONDS * FRAMES_PER_S):
            stamp = number / FRAMES_PER_S
            view = wall_to_camera(PATH.at(stamp)[0])
            colors, cover = self._front(stamp)
            shadow = cv2.GaussianBlur(np.roll(cover[..., 0], SHADOW_AT, (0, 1)), (0, 0), SHADOW_PX)
            exposure = 1 + EXPOSURE * np.sin(0.9 * stamp)
            noise = random.normal(0, self._noise, (self.camera.height, self.camera.width, 3))
            bare = exposure * renderer.render(*view) * (1 - SHADOW * shadow[..., None])
            frame = self._seen(bare, 1, (exposure * colors, cover), noise)
            corners = project(self._wall.area_corners, *view, self.camera)[0]
            yield standing.Moment(stamp, frame, {'thing': cover[..., 0]},
                                  standing.well_inside(corners, frame.shape[1::-1]))

    def _front(self, seconds):
        canvas = Canvas(self.camera.width, self.camera.height)
        self._figure(canvas, seconds)
        colors, cover = canvas.layer()
        relief = cv2.GaussianBlur(cover[..., 0], (0, 0), ROUND_PX)
        across, down = (cv2.Sobel(relief, -1, *order, scale=1 / 8) for order in ((1, 0), (0, 1)))
        slope = ROUND_PX * (across + 0.7 * down)
        return np.clip(colors + SHADE_LEVELS * np.minimum(slope, 0.1)[..., None], 0, 255), cover


SCENES = {'white robot, white board': AlikeScene(white_robot, BOARD),
          'pale hand, beige wall': AlikeScene(pale_hand, BEIGE)}


def largest_hole(moment, image):
    """The largest connected part of the thing that is painted over, as a share of what is in the area of it."""
    cover = (moment.things['thing'] > 0.5) & moment.inside
    from_paint, from_frame = (np.abs(image.astype(int) - other).max(axis=2)
                              for other in (standing.PAINT, moment.frame))
    holes = cv2.morphologyEx(np.uint8(cover & (from_paint < from_frame)), cv2.MORPH_OPEN, np.ones((3, 3)))
    _, _, stats, _ = cv2.connectedComponentsWithStats(holes, connectivity=4)
    return max(stats[1:, cv2.CC_STAT_AREA], default=0) / max(np.count_nonzero(cover), 1)


def judged(scene):
    """((n, 8), what standing.judge says about the frames with the thing, and (n,), their largest holes)."""
    painter = Painter(np.full((60, 90, 3), standing.PAINT, np.uint8), foreground='keep')
    sums, holes = [], []
    for moment in scene.moments():
        image = painter.paint(moment.frame, moment.stamp)[1]
        if np.count_nonzero(moment.things['thing'][moment.inside] > 0.5) > LEAST_PX:
            sums.append(standing.judge(moment, image))
            holes.append(largest_hole(moment, image))
    return np.array(sums), np.array(holes)


def run():
    """Print the table."""
    tell('\nforeground:=keep, things of the color of the wall behind them: what is kept of them (mean, one\n'
         'frame in ten is worse), the largest hole (median), how much of the wall is painted (mean,\n'
         'worst frame), and bare wall in a band of %d pixels around them\n\n%-26s %8s %8s %8s %8s %8s %8s'
         % (standing.RIM_PX, '', 'kept', '90 %', 'hole', 'painted', 'worst', 'bare'))
    for name, scene in SCENES.items():
        sums, holes = judged(scene)
        shares = 100 * sums[:, ::2] / np.maximum(sums[:, 1::2], 1)
        kept, painted, bare, _ = 100 * sums.sum(axis=0)[::2] / np.maximum(sums.sum(axis=0)[1::2], 1)
        tell('%-26s %6.1f %% %6.1f %% %6.1f %% %6.1f %% %6.1f %% %6.1f %%' % (
            name, kept, np.percentile(shares[:, 0], 10), 100 * np.median(holes), painted, shares[:, 1].min(),
            bare))
