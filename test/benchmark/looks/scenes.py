"""Scenes: a drive past the bare wall, and the same drive past the wall with the picture printed on it."""
from collections import namedtuple
from dataclasses import replace

import cv2
import numpy as np
from aruco_ar.simulation.figures import Canvas, hand, person, robot
from aruco_ar.simulation.render import WallRenderer, project
from aruco_ar.simulation.robot import Camera, Path, Pose, hand_held, wall_to_camera
from rig.accuracy.drives import WALL

FRAMES_PER_S = 15
# The tags are too small to be seen.
UNTAGGED = replace(WALL, tags=tuple(replace(tag, side=1e-4) for tag in WALL.tags))
PATH = Path(Pose(-2.25, 0.12, -0.05), ((4, 0.05, -0.03), (4, -0.05, 0.03)))

# ``bare``, ``printed``, ``untagged`` (the bare wall without tags): (h, w, 3) BGR uint8.
# ``corners``: (4, 2), the area's. ``front``: (h, w) float32, the share of each pixel that something in
# front of the wall covers.
Moment = namedtuple('Moment', 'stamp bare printed untagged corners front')


def moving_shadow(seconds):
    """The shadow of a board, wall meters, that moves across the area in 4 s, and back."""
    x = -1.6 + 3.2 * (1 - abs(seconds / 4 % 2 - 1))
    return np.array([[x, 0, 0], [x + 0.6, 0, 0], [x + 0.8, 2.5, 0], [x + 0.2, 2.5, 0]])


def changing_light(seconds):
    """(3,): factors of blue, green and red; it gets darker and redder, and lighter again, in 6 s."""
    dim = 0.5 - 0.5 * np.cos(2 * np.pi * seconds / 6)
    return 1 - dim * np.array([0.5, 0.4, 0.3])


class Scene:
    """One scene. ``figure``: see figures. ``shadow``, ``light``: functions of the time, seconds, or None.

    ``noise``, ``blur``: see WallRenderer. ``smear``: pixels, the length of a horizontal motion blur.
    ``distortion``, ``fisheye``: see Camera. ``fall``: how much darker the wall's right end is than its left.
    ``shake``: see hand_held.
    """

    def __init__(self, figure=None, shadow=None, light=None, noise=2.0, blur=0.6, smear=1, distortion=(0,) * 5,
                 fisheye=False, fall=0.0, shake=0.0):
        self._figure, self._shadow, self._light = figure, shadow, light
        self._noise, self._blur, self._smear, self._fall, self._shake = noise, blur, smear, fall, shake
        self.camera = Camera(distortion=list(distortion), fisheye=fisheye)

    @property
    def lens(self):
        """The Lens of the camera if it bends straight lines, else None."""
        return self.camera.lens if self.camera.lens.bends else None

    def moments(self, picture, seconds):
        """Yield the Moments of that many seconds, with ``picture``, (h, w, 3) BGR, printed on the wall."""
        renderers = [WallRenderer(wall, self.camera, light=self._fall, printed=printed)
                     for wall, printed in ((WALL, None), (WALL, picture), (UNTAGGED, None))]
        random = np.random.RandomState(1)
        for number in range(int(seconds * FRAMES_PER_S)):
            stamp = number / FRAMES_PER_S
            view = hand_held(wall_to_camera(PATH.at(stamp)[0]), stamp, self._shake)
            factors, figure = self._lit(view, stamp), self._front(stamp)
            noise = random.normal(0, self._noise, (self.camera.height, self.camera.width, 3))
            frames = [self._seen(renderer.render(*view), factors, figure, noise) for renderer in renderers]
            yield Moment(stamp, *frames, project(WALL.area_corners, *view, self.camera)[0],
                         self._soft(figure[1])[..., 0] if figure else np.zeros(noise.shape[:2], np.float32))

    def _lit(self, view, seconds):
        """(h, w, 3) or (3,): the factors of the light on the wall."""
        factors = np.ones(3, np.float32) if self._light is None else np.float32(self._light(seconds))
        if self._shadow is None:
            return factors
        corners, _ = project(self._shadow(seconds), *view, self.camera)
        shade = np.zeros((self.camera.height, self.camera.width), np.float32)
        cv2.fillPoly(shade, [np.int32(np.round(corners * 16))], 1.0, cv2.LINE_8, 4)
        shade = cv2.GaussianBlur(shade, (0, 0), self.camera.width / 80)
        return factors * (1 - shade[..., None] * np.float32([0.42, 0.46, 0.5]))

    def _front(self, seconds):
        if self._figure is None:
            return None
        canvas = Canvas(self.camera.width, self.camera.height)
        self._figure(canvas, seconds)
        return canvas.layer()

    def _soft(self, image):
        image = cv2.GaussianBlur(image, (0, 0), self._blur) if self._blur else image
        image = cv2.blur(image, (self._smear, 1)) if self._smear > 1 else image
        return image.reshape(*image.shape[:2], -1)

    def _seen(self, wall, factors, figure, noise):
        frame = wall * factors
        if figure is not None:
            colors, cover = figure
            frame = frame + cover * (colors - frame)
        return np.clip(np.round(self._soft(frame) + noise), 0, 255).astype(np.uint8)


SCENES = {
    'plain': Scene(),
    'a person walks past': Scene(person),
    'a hand writes': Scene(hand),
    'a robot drives by': Scene(robot),
    'a shadow moves across': Scene(shadow=moving_shadow),
    'light falls off, changes': Scene(light=changing_light, fall=0.5),
    'lens, k1 = -0.3': Scene(distortion=(-0.3, 0.1, 0, 0, 0)),
    'fisheye': Scene(distortion=(0.02, -0.01, 0, 0), fisheye=True),
    'motion blur of 9 px': Scene(person, smear=9),
    'noise of 5': Scene(person, noise=5.0),
    'all at once': Scene(person, moving_shadow, changing_light, noise=5.0, blur=1.0, smear=5,
                         distortion=(-0.3, 0.1, 0, 0, 0), fall=0.5, shake=0.5),
}
