"""The picture gets the sharpness and the noise of the camera's image."""
import cv2
import numpy as np
import pytest
from aruco_ar import Tag, draw_tag
from aruco_ar.looks.grain import Grain, edge_variance, noise_of
from test_looks import FRAMES_PER_S, Drive, hand, painted, stage

SIDE = 96


def board(blur, smear=1, noise=0.0, turn=0.0):
    """A frame with a tag on gray, and the Tag. ``turn``: degrees."""
    paper = draw_tag('DICT_6X6_250', 40, 8 * SIDE, 1, 1)
    side, scale = len(paper), 8
    margin = side / 10
    to_frame = cv2.getRotationMatrix2D((side / 2 - 0.5, side / 2 - 0.5), turn, 1.0)
    to_frame[:, 2] += 960 - side / 2
    big = np.full((1920, 1920), 170, np.uint8)
    cv2.warpAffine(np.where(paper > 0, 200, 30).astype(np.uint8), to_frame, big.shape, big,
                   borderMode=cv2.BORDER_TRANSPARENT)
    corners = np.array([[margin, margin], [side - margin, margin], [side - margin, side - margin],
                        [margin, side - margin]]) - 0.5
    corners = cv2.transform(corners[None], to_frame)[0]
    image = cv2.resize(big, (240, 240), interpolation=cv2.INTER_AREA).astype(np.float32)
    image = cv2.GaussianBlur(image, (0, 0), blur)
    image = cv2.blur(image, (smear, 1))[..., None] + np.random.RandomState(0).normal(0, noise, (240, 240, 3))
    return np.clip(np.round(image), 0, 255).astype(np.uint8), Tag(1, np.float32((corners + 0.5) / scale - 0.5))


@pytest.mark.parametrize('turn', [0.0, 20.0, 45.0])
@pytest.mark.parametrize('noise', [0.0, 5.0])
@pytest.mark.parametrize('blur', [0.7, 1.3, 2.2])
def test_the_edges_of_a_tag_show_the_blur(blur, noise, turn):
    sharp, soft = (np.array(edge_variance(*_with_tag(board(each, 1, noise, turn)))) for each in (0.01, blur))
    if turn == 45:  # all edges have the same two directions, which show the sum only
        sharp, soft = sharp.mean(), soft.mean()
    np.testing.assert_allclose(np.sqrt(np.maximum(soft - sharp, 0)), blur, rtol=0.2 if noise else 0.1)


def _with_tag(pair):
    return pair[0], [pair[1]]


def test_motion_blurs_in_its_own_direction_only():
    sharp = edge_variance(*_with_tag(board(0.7)))
    across, down = edge_variance(*_with_tag(board(0.7, smear=5))) - sharp
    assert across == pytest.approx((5**2 - 1) / 12, rel=0.15) and abs(down) < 0.1


@pytest.mark.parametrize('deviation', [1.0, 3.0, 10.0])
def test_noise_is_measured_as_it_is_also_on_a_wall_with_a_pattern(deviation, random):
    gray = 120 + 40 * np.sin(np.arange(320) / 5)[:, None] + np.zeros((320, 320))
    colors = gray[..., None] + random.normal(0, deviation, (320, 320, 3))
    color, of_gray = noise_of(np.clip(np.round(colors), 0, 255).astype(np.uint8))
    assert color == pytest.approx(deviation, rel=0.1)
    assert of_gray == pytest.approx(deviation * np.sqrt(0.114**2 + 0.587**2 + 0.299**2), rel=0.1)
    same = np.repeat((gray + random.normal(0, deviation, gray.shape))[..., None], 3, axis=2)
    same = np.clip(np.round(same), 0, 255).astype(np.uint8)
    assert noise_of(same) == pytest.approx([deviation] * 2, rel=0.12)


def test_the_edges_of_small_fields_are_no_noise(random):
    y, x = np.mgrid[:80, :90]
    fields = ((0.87 * x + 0.5 * y) // 9 + (0.87 * y - 0.5 * x) // 9) % 2
    gray = cv2.GaussianBlur(20 + 90 * fields, (0, 0), 0.6)
    color, _ = noise_of(np.uint8(np.round(gray[..., None] + random.normal(0, 1, (80, 90, 3)))))
    assert color == pytest.approx(1, abs=0.3)  # from all pixels, it was 2.5


def mosaic(colors):
    """What a sensor of colors sees, taken for gray: (h, w, 3) uint8."""
    gray = colors[..., 1].copy()
    gray[0::2, 0::2], gray[1::2, 1::2] = colors[0::2, 0::2, 2], colors[1::2, 1::2, 0]
    return np.repeat(np.uint8(np.clip(np.round(gray), 0, 255))[..., None], 3, axis=2)


@pytest.mark.parametrize('quality', [None, 95, 80])
@pytest.mark.parametrize('deviation', [1.0, 4.0])
@pytest.mark.parametrize('color', [(90, 140, 110), (120, 140, 135)])
def test_the_colors_of_a_mosaic_are_not_taken_for_noise(color, deviation, quality, random):
    seen = mosaic(np.float64(color) + random.normal(0, deviation, (320, 320, 3)))
    if quality is not None:
        seen = cv2.imdecode(cv2.imencode('.jpg', seen[..., 0], [cv2.IMWRITE_JPEG_QUALITY, quality])[1], 1)
    assert np.all(noise_of(seen) < deviation + 4)  # a JPEG adds some
    grain = Grain()
    grain.measure(seen, seen, [])
    assert grain.noisy(np.full((200, 260, 3), 100, np.uint8)).std() < deviation + 4


@pytest.mark.parametrize('common', [False, True])
def test_the_noise_that_is_added_is_that_of_the_wall(common, random):
    shape = (300, 300, 1 if common else 3)
    wall = 140 + random.normal(0, 4, shape) + np.zeros((300, 300, 3))
    wall = np.clip(np.round(wall), 0, 255).astype(np.uint8)
    grain = Grain()
    grain.measure(wall, wall, [])
    one, other = (grain.noisy(np.full((200, 260, 3), 100, np.uint8)).astype(float) for _ in range(2))
    assert one.std() == pytest.approx(4, rel=0.1) and abs(one.mean() - 100) < 0.1
    assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 0.05  # it is another in each frame
    assert (np.corrcoef(one[..., 0].ravel(), one[..., 2].ravel())[0, 1] > 0.9) == common


def test_what_shows_no_grain_changes_nothing():
    grain = Grain()
    black = np.zeros((200, 200, 3), np.uint8)
    grain.measure(black, black, [])
    grain.measure(black, black[:5, :5], [Tag(1, np.float32([[0, 0], [9, 0], [9, 9], [0, 9]]))])
    picture = np.full((200, 200, 3), 77, np.uint8)
    with_grain, mask = grain.apply(picture, np.full_like(picture, 255))
    assert np.all(with_grain == (77, 77, 77, 255)) and np.all(mask == 255)


def test_a_picture_on_the_wall_is_as_soft_and_noisy_as_the_wall(wall):
    stripes = np.full((600, 900, 3), 60, np.uint8)
    stripes[:, 300:600] = 190
    drive, soft, sharp = Drive(wall, noise=4.0, blur=1.6), stage(stripes, grain='match'), stage(stripes)
    for number in range(FRAMES_PER_S):
        frame, inside = drive.frame(number)
        soft_image, sharp_image = painted(soft, frame, number), painted(sharp, frame, number)
    columns = np.nonzero(inside[240])[0]
    middle = slice(240 - 10, 240 + 10), slice(columns[0] + 10, columns[0] + 40)  # of the left dark stripe
    assert np.std(soft_image[middle]) == pytest.approx(4, rel=0.15)
    assert np.std(sharp_image[middle]) < 0.5

    def steepest(image):
        return np.abs(np.diff(image[220:260].mean(axis=(0, 2))[columns[0] + 10:columns[-1] - 10])).max()
    assert steepest(soft_image) < 0.45 * steepest(sharp_image)


@pytest.mark.long
def test_far_from_what_is_in_front_the_soft_rim_of_the_picture_stays_as_it_is(wall):
    drive = Drive(wall, blur=1.6)
    keeps, paints = stage(grain='match', foreground='keep'), stage(grain='match')
    for number in range(2 * FRAMES_PER_S):
        frame, inside = drive.frame(number)
        things = hand(frame, number) if number > FRAMES_PER_S else np.zeros_like(inside)
        one, other = (painted(each, frame, number) for each in (keeps, paints))
        far = cv2.dilate(things.astype(np.uint8), np.ones((25, 25))) == 0
        assert things.any() == (number > FRAMES_PER_S)
        np.testing.assert_array_equal(one[far], other[far])
