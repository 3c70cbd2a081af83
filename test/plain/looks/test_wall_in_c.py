"""Comparing with the wall, and learning it: the C functions against the same in NumPy."""
import cv2
import numpy as np
import pytest
from aruco_ar.compiled import binding
from aruco_ar.looks.difference import DARKEST, LIGHTEST, compare
from aruco_ar.looks.wall_model import VARIANCE_RATE

STEP = 5  # of the planes
SHAPES = [(1, 1), (1, 40), (33, 1), (37, 53), (64, 64)]


def scene(shape, seed=0):
    """(seen, look, whole, variance, usable): pixels of any brightness, and a part that differs."""
    random = np.random.RandomState(seed)
    look = cv2.GaussianBlur(random.uniform(-50, 300, (*shape, 3)), (0, 0), 2).clip(0.2, 255).astype(np.float32)
    whole = np.float32([0.9, 1.0, 1.2])
    seen = look * whole * random.uniform(0.8, 1.2, (*shape, 1)) + random.normal(0, 2, look.shape)
    seen[shape[0] // 3:shape[0] // 2, shape[1] // 3:] = random.choice([0, 255])
    variance = random.uniform(1, 9, shape).astype(np.float32)
    seen = np.clip(np.round(seen), 0, 255).astype(np.uint8)
    return seen, look, whole, variance, random.uniform(size=shape) < 0.9


def contrast_of(look):
    """(h, w, 3) uint8: the largest differences near each pixel of the look."""
    wall = np.clip(np.round(look), 0, 255).astype(np.uint8)
    square = np.ones((3, 3), np.uint8)
    return cv2.subtract(cv2.dilate(wall, square), cv2.erode(wall, square)).reshape(wall.shape)


def in_numpy(seen, look, whole, variance, contrast):
    """{name: plane} of what the comments of wall.c say, and where something is in front."""
    wall, contrast = look * whole, contrast * whole
    gray, wall_gray = seen.mean(axis=2), np.maximum(wall.mean(axis=2), 1)
    light, noise = gray / wall_gray, 2 + 3.5 * np.sqrt(variance)
    off = np.abs(seen - wall * light[..., None])
    share = 0.08 + 0.2 * np.maximum(1 - 2 / np.maximum(light, 1e-9), 0)
    allowed = (share * light)[..., None] * wall + 0.6 * contrast * light[..., None] + noise[..., None]
    excess, error, rim = (off / allowed).max(axis=2), off.max(axis=2), 0.6 * contrast.mean(axis=2)
    square, slack = np.ones((3, 3), np.uint8), (noise * 2 / 3 + rim) / wall_gray
    bright = np.maximum(light, 0.02)
    change = np.log(cv2.dilate(bright, square) / cv2.erode(bright, square))
    step = (change - 2 * slack / np.maximum(light, 0.1)) / 0.22
    front = (excess > 1) | (light < DARKEST - slack) | (light > LIGHTEST + slack) | (step > 1)
    return [gray, wall_gray, light, error, excess, step, noise, rim], front


def ranked(values, percent):
    """The value that so many percent of n values, (n, ...), are below, of each column."""
    return np.sort(values, axis=0)[(len(values) - 1) * percent // 100]


@pytest.mark.parametrize('light', [(0.9, 1.0, 1.2), (1.5, 1.0, 0.6)])
@pytest.mark.parametrize('shape', SHAPES)
def test_the_light_is_that_of_the_same_in_numpy(shape, light):
    seen, look, _, _, usable = scene(shape)
    seen[:shape[0] // 2, :shape[1] // 2, 0] //= 3  # something of another color
    front = np.arange(usable.size).reshape(shape) % 7 == 6
    usable[0, 0] = len(look) > 1
    got, unshaded = binding.measure_light(seen, look, usable, front, np.float32(light))
    lights, grays, sample = (each[::8, ::8] for each in (
        seen / np.maximum(look, 1), look.sum(axis=2), usable & ~front))
    if not sample.any():
        assert unshaded == -1 and got.tolist() == np.float32(light).tolist()
        return
    lights = lights[sample & (grays >= 0.3 * ranked(grays[sample], 90))]
    means = np.maximum(lights.mean(axis=1, keepdims=True), 0.02)
    alike = np.abs(lights / means / (np.float32(light) / np.mean(light)) - 1).max(axis=1) < 0.2
    lights = lights[alike] if alike.sum() > 0.2 * len(alike) else lights
    np.testing.assert_allclose(got, np.maximum(ranked(lights, 50), 0.02), rtol=1e-5)
    np.testing.assert_allclose(unshaded, ranked(lights.mean(axis=1), 90), rtol=1e-5)


@pytest.mark.parametrize('shape', SHAPES)
def test_comparing_finds_what_the_same_in_numpy_finds(shape):
    seen, look, whole, variance, usable = scene(shape)
    contrast = contrast_of(look)
    flags, planes = compare(seen, look, whole, contrast, variance, usable)
    expected, front = in_numpy(seen.astype(float), look, whole, variance, contrast.astype(float))
    assert len(planes) == len(expected) == binding.PLANES
    for plane, (got, wanted) in enumerate(zip(planes, expected)):
        least = 0.5 if plane == STEP else 0  # smaller changes of the light are not computed: they are no rims
        np.testing.assert_allclose(np.maximum(got, least), np.maximum(wanted, least), rtol=2e-3, atol=2e-3,
                                   err_msg=str(plane))
    assert np.count_nonzero(flags != (front & usable)) <= 0.001 * front.size  # those at a limit


@pytest.mark.parametrize('shape', SHAPES)
def test_the_wall_in_a_light_is_rounded_and_limited(shape):
    _, look, whole, _, _ = scene(shape)
    look[0, 0] = -1, 300, 0.5
    wanted = np.clip(look * whole, 0, 255)
    assert np.abs(binding.light_wall(look, whole) - wanted).max() <= 0.5


@pytest.mark.parametrize('shape', SHAPES)
def test_learning_is_the_same_as_in_numpy(shape):
    seen, look, whole, variance, certain = scene(shape, 1)
    _, planes = compare(seen, look, whole, contrast_of(look), variance, certain)
    random = np.random.RandomState(2)
    wall, known = certain | (random.uniform(size=shape) < 0.5), random.uniform(size=shape) < 0.8
    certain = certain & known
    seconds = random.uniform(0, 30, shape).astype(np.float32)
    unlit, new = seen / whole, (wall & ~known)[..., None]
    usual = (certain & (np.abs(planes[2] - 1) < 0.1))[..., None]
    expected = np.where(new, unlit, np.where(usual, look + 0.25 * (unlit - look), look))
    noise = variance + VARIANCE_RATE * (planes[3]**2 - variance)
    varied = np.where(certain & (planes[4] < 0.5), noise, variance)
    longer = np.minimum(seconds + 0.5 * wall, 30)
    binding.learn_wall(seen, whole, planes, wall, certain, 0.5, 30.0, 0.25, VARIANCE_RATE, look, variance,
                       known, seconds)
    np.testing.assert_allclose(look, expected, rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose(variance, varied, rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose(seconds, longer, rtol=1e-5)
    assert known[wall].all()
