"""No bare wall shines round what is in front, though it casts a shadow."""
import cv2
import numpy as np
import pytest
from test_looks import FRAMES_PER_S, SKIN, Drive, core, is_kept, painted, stage, with_sheet

pytestmark = pytest.mark.long
FINE, NIGHT, SLEEVE = 4, (70, 40, 30), (60, 62, 64)


def shaded_hand(frame, number, color):
    """Draw a hand that casts a soft shadow; returns how much of each pixel it covers, (h, w) float32."""
    x, y = 3 * (number % 20), 2 * (number % 7)
    fine = np.zeros((FINE * frame.shape[0], FINE * frame.shape[1]), np.uint8)
    cv2.line(fine, (FINE * (330 + x), FINE * 470), (FINE * (290 + x), FINE * (230 + y)), 255, FINE * 46)
    cv2.circle(fine, (FINE * (288 + x), FINE * (215 + y)), FINE * 34, 255, -1)
    cover = cv2.resize(fine, frame.shape[1::-1], interpolation=cv2.INTER_AREA)
    cover = cv2.GaussianBlur(cover, (0, 0), 0.7).astype(np.float32) / 255
    light = 1 - 0.45 * cv2.GaussianBlur(np.roll(cover, (10, 12), (0, 1)), (0, 0), 5)[..., None]
    lit = frame * light
    frame[:] = np.round(lit + cover[..., None] * (np.array(color) - lit))
    return cover


@pytest.mark.parametrize('color, most', [(SKIN, 0.05), (SLEEVE, 0.1)])
@pytest.mark.parametrize('sheet', [None, (225, 228, 230)])
def test_hardly_any_bare_wall_is_seen_in_a_band_round_a_hand(wall, tmp_path, sheet, color, most):
    if sheet is not None:
        cv2.imwrite(str(tmp_path / 'sheet.png'), np.full((600, 800, 3), sheet, np.uint8))
        wall = with_sheet(wall, tmp_path / 'sheet.png')
    drive, keeps = Drive(wall), stage(NIGHT, foreground='keep')
    for number in range(2 * FRAMES_PER_S):
        frame, inside = drive.frame(number)
        if number < FRAMES_PER_S:
            painted(keeps, frame, number)
            continue
        cover = shaded_hand(frame, number, color)
        image = painted(keeps, frame, number)
        band = (cv2.dilate(np.float32(cover > 0.5), np.ones((7, 7))) > 0) & (cover < 0.05) & inside
        toward_wall = ((image.astype(float) - NIGHT)[band] * (frame.astype(float) - NIGHT)[band]).sum(axis=1)
        bare = toward_wall / ((frame.astype(float) - NIGHT)[band]**2).sum(axis=1)
        assert np.mean(bare > 0.3) < most
        assert is_kept(image, frame, core(cover > 0.9) & inside) > 0.97
