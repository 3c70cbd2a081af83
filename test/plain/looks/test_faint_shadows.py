"""A faint shadow, or a spot of light, is painted over, however sharp its rim is."""
import cv2
import numpy as np
import pytest
from test_looks import FRAMES_PER_S, Drive, is_painted, painted, stage

pytestmark = pytest.mark.long


def disk(shade, moved):
    cv2.circle(shade, (270 + 3 * moved, 210), 60, 1.0, -1)


def blinds(shade, moved):
    for left in range(0, shade.shape[1], 40):
        shade[:, left + moved:left + moved + 20] = 1


@pytest.mark.parametrize('draw', [disk, blinds])
@pytest.mark.parametrize('depth', [0.05, 0.15, -0.05])
def test_light_that_moves_over_the_wall_with_a_sharp_rim_is_painted_over(wall, draw, depth):
    drive, keeps = Drive(wall), stage(foreground='keep')
    for number in range(3 * FRAMES_PER_S):
        frame, inside = drive.frame(number)
        if number > 2 * FRAMES_PER_S:
            shade = np.zeros(frame.shape[:2], np.float32)
            draw(shade, number % 20)
            light = 1 - depth * cv2.GaussianBlur(shade, (0, 0), 1)[..., None]
            frame = np.uint8(np.clip(frame * light, 0, 255))
        assert is_painted(painted(keeps, frame, number), inside) > 0.99
