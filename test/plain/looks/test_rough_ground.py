"""Where a tag was hidden, the ground is as rough as beside it."""
import cv2
import numpy as np
import pytest
from aruco_ar import Area, Tag, draw_tag
from aruco_ar.looks.hidden_tags import HiddenTags

HEIGHT, WIDTH, SIDE = 240, 320, 64
AREA = Area(np.float32([[20, 20], [300, 20], [300, 220], [20, 220]]))
TURNED = cv2.getRotationMatrix2D((SIDE / 2 - 0.5, SIDE / 2 - 0.5), 20, 1) + [[0, 0, 128], [0, 0, 88]]
TAG = Tag(7, np.float32(TURNED[:, :2] @ (np.float32([[0, 0], [1, 0], [1, 1], [0, 1]]) * SIDE - 0.5).T
                        + TURNED[:, 2:]).T)


def rough(deviation, grain_px=1.5, seed=0):
    """(h, w, 3) float32: ground of about one color, with a random pattern of that standard deviation."""
    pattern = cv2.GaussianBlur(np.random.RandomState(seed).normal(0, 1, (HEIGHT, WIDTH)), (0, 0), grain_px)
    return np.float32(np.array([120, 130, 140]) + deviation / pattern.std() * pattern[..., None])


def tagged(ground):
    """(h, w, 3) float32: the ground with a tag on it."""
    cells = cv2.resize(draw_tag('DICT_6X6_250', 7), (SIDE, SIDE), interpolation=cv2.INTER_AREA)
    share = cv2.warpAffine(255.0 - cells, TURNED, (WIDTH, HEIGHT))
    return ground * (1 - 0.9 * cv2.GaussianBlur(share, (0, 0), 0.7)[..., None] / 255)


def hide(hidden, frame, off=0.0, keep=False):
    frame = np.uint8(np.clip(np.round(frame), 0, 255))
    image = frame.copy()
    hidden.hide(frame, image, AREA, [Tag(7, TAG.corners + np.float32(off))], is_located=True, keep=keep)
    return image.astype(float)


def around(least, most):
    """(h, w) bool: the pixels whose distance from the tag is that, in pixels, less than 0 inside of it."""
    outside = np.ones((HEIGHT, WIDTH), np.uint8)
    cv2.fillConvexPoly(outside, np.int32(np.round(TAG.corners)), 0)
    away = cv2.distanceTransform(outside, cv2.DIST_L2, 5) - cv2.distanceTransform(1 - outside, cv2.DIST_L2, 5)
    return (away >= least) & (away <= most)


def fine(image):
    return image - cv2.GaussianBlur(image, (0, 0), 3)


@pytest.mark.parametrize('deviation, grain_px', [(12, 0.6), (12, 1.5), (20, 3), (3, 1)])
def test_it_has_the_texture_of_the_ground(deviation, grain_px):
    image = fine(hide(HiddenTags(), tagged(rough(deviation, grain_px))))
    assert 0.8 < image[around(-100, -3)].std() / image[around(8, 40)].std() < 1.2


def test_the_texture_stays_where_it_is_and_the_noise_changes_from_frame_to_frame():
    hidden, random = HiddenTags(), np.random.RandomState(1)
    frame = tagged(rough(12))
    images = [hide(hidden, frame + random.normal(0, 4, frame.shape), random.normal(0, 0.2, (4, 2)))
              for _ in range(25)][5:]
    inside, beside = around(-100, -3), around(8, 40)
    texture, noise = fine(np.mean(images, axis=0)), np.std(images, axis=0)
    assert 0.8 < texture[inside].std() / texture[beside].std() < 1.2
    assert 0.85 < noise[inside].mean() / noise[beside].mean() < 1.15


def test_ground_may_become_rough_only_after_the_first_frame():
    hidden, ground = HiddenTags(), tagged(rough(1.2))
    hide(hidden, tagged(rough(0)))  # a video's first frame may be smooth
    images = [fine(hide(hidden, ground)) for _ in range(10)]
    assert 0.7 < images[-1][around(-100, -3)].std() / images[-1][around(8, 40)].std() < 1.3


def test_light_that_falls_off_goes_on_under_a_tag_without_a_step():
    y, x = np.indices((HEIGHT, WIDTH))
    ground = (60 + 0.5 * x + 0.3 * y)[..., None] * np.float32([0.9, 1, 1.05])
    off = np.abs(hide(HiddenTags(), tagged(ground)) - ground)[around(-100, -3)]
    assert off.max() < 2  # half a pixel of the cover, which is 16 pixels wide, makes 2.7


def test_edges_of_other_things_beside_a_tag_are_not_under_it():
    ground = rough(2)
    ground[:78], ground[:, 205:] = (30, 30, 30), (220, 220, 240)
    inside = around(-100, -3)
    image, bare = fine(hide(HiddenTags(), tagged(ground)))[inside], fine(rough(2))[inside]
    assert np.abs(image).max() < 12  # in the edges, it is 60
    assert 0.7 < image.std() / bare.std() < 1.3


@pytest.mark.parametrize('smear_px', [15, 41])
def test_the_smear_of_a_moving_camera_is_hidden_with_the_tag(smear_px):
    kernel = np.zeros((51, 51), np.float32)
    kernel[25, 25 - smear_px // 2:26 + smear_px // 2] = 1 / smear_px
    kernel = cv2.warpAffine(kernel, cv2.getRotationMatrix2D((25, 25), 20, 1), (51, 51))  # along the tag's sides
    bare = rough(2)
    image = hide(HiddenTags(), cv2.filter2D(tagged(bare), -1, kernel))
    assert np.abs(image - cv2.filter2D(bare, -1, kernel)).max() < 8  # the tag is darker by 110


def under_finger(ground):
    """(h, w, 3) float32: the ground with a finger over a part of the tag; and its share, (h, w, 1) float32."""
    finger = np.zeros((HEIGHT, WIDTH), np.float32)
    cv2.ellipse(finger, (220, 130), (60, 14), 15, 0, 360, 1, -1)
    finger = cv2.GaussianBlur(finger, (0, 0), 1.2)[..., None]
    return ground * (1 - finger) + (90, 110, 160) * finger, finger[..., 0]


def test_no_rim_of_the_tag_is_left_around_a_finger_over_it():
    hidden, bare = HiddenTags(), rough(1)
    for _ in range(10):
        hide(hidden, tagged(bare), keep=True)
    truth, finger = under_finger(bare)
    image = hide(hidden, under_finger(tagged(bare))[0], keep=True)
    rim = around(-100, -6) & (finger > 0.1) & (finger < 0.9)
    assert np.abs(image - truth)[rim].mean() < 9


def test_a_finger_beside_a_tag_does_not_color_what_is_under_it():
    hidden, ground = HiddenTags(), tagged(rough(4))
    for _ in range(10):
        hide(hidden, ground, keep=True)
    seen, finger = under_finger(ground)
    image, free = hide(hidden, seen, keep=True), cv2.dilate(finger, np.ones((9, 9))) < 0.01
    red = image[..., 2] - image[..., 0] - 20  # the finger's is 50
    assert np.mean(np.abs(red[around(-100, -3) & free]) > 6) < 0.005
