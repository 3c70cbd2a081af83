"""Tags that OpenCV misses: white on black, with wide borders, half in a shadow, at the frame's rim."""
import cv2
import numpy as np
import pytest
from aruco_ar import Detector, InputError, draw_tag
from aruco_ar.tags.detector import SEARCHES

PLACES = (120, 100), (500, 110), (510, 370), (110, 360)
SIDE = 60
SQUARE = np.float32([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
FINE = 4  # samples per pixel, in each direction


def paint(frame, quad, dictionary, tag_id, border=1):
    """Paint a tag with its white margin into a frame, (h, w) float64, with its corners at a quad, (4, 2)."""
    tag = draw_tag(dictionary, tag_id, 800, border, quiet=1)
    margin = (len(tag) - 800) / 2
    end, least = margin + 800, np.floor(quad.min(axis=0)).astype(int) - 20
    corners = np.float32([[margin, margin], [end, margin], [end, end], [margin, end]]) - 0.5
    size = int(np.ptp(quad, axis=0).max()) + 40
    to_fine = cv2.getPerspectiveTransform(corners, np.float32((quad - least + 0.5) * FINE - 0.5))
    fine, mask = (cv2.warpPerspective(image, to_fine, (size * FINE, size * FINE)) for image in
                  (tag, np.full_like(tag, 255)))
    patch, share = (np.float64(cv2.resize(image, (size, size), interpolation=cv2.INTER_AREA))
                    for image in (fine, mask))
    y, x = np.mgrid[:size, :size] + least[::-1, None, None]
    inside = (x >= 0) & (y >= 0) & (x < frame.shape[1]) & (y < frame.shape[0])
    x, y, share = x[inside], y[inside], share[inside] / 255
    frame[y, x] = frame[y, x] * (1 - share) + patch[inside] * share


def seen(frame, random):
    """A frame as a camera sees it: (h, w) uint8, with blur and noise."""
    blurred = cv2.GaussianBlur(frame, (0, 0), 0.7) * 0.85 + 12
    return np.uint8(np.clip(blurred + random.randn(*frame.shape) * 3, 0, 255))


def wall(dictionary, turn, border=1):
    """A frame, (480, 640) float64, with tags 1 to 4, and their corners {id: (4, 2)}."""
    frame, rotation = np.full((480, 640), 170.0), cv2.getRotationMatrix2D((0, 0), turn, 1)[:, :2]
    quads = {tag_id: np.float32(SIDE * SQUARE @ rotation.T + place)
             for tag_id, place in zip((1, 2, 3, 4), PLACES)}
    for tag_id, quad in quads.items():
        paint(frame, quad, dictionary, tag_id, border)
    return frame, quads


def assert_found(tags, quads, atol):
    assert sorted(tag.id for tag in tags) == sorted(quads)
    for tag in tags:
        np.testing.assert_allclose(tag.corners, quads[tag.id], atol=atol)


@pytest.mark.parametrize('dictionary', ['DICT_6X6_250', 'DICT_4X4_50', 'DICT_APRILTAG_36h11'])
@pytest.mark.parametrize('search', SEARCHES)
def test_white_tags_on_black_are_found_as_exactly(random, dictionary, search):
    frame, quads = wall(dictionary, 8)
    detector = Detector(dictionary, search=search)
    white = seen(255 - frame, random)
    assert_found(detector.detect(white), quads, 0.3)
    assert_found(detector.search(white, 24), quads, 0.3)
    # In their places, they are fitted as what they were found to be.
    fitted, found, likeness = detector.fit(white, [1, 2], np.array([quads[1] + 1, quads[2] - 1]))
    assert found.all() and likeness.min() > 0.9
    np.testing.assert_allclose(fitted, [quads[1], quads[2]], atol=0.3)
    assert_found(detector.detect(seen(frame, random)), quads, 0.3)


@pytest.mark.parametrize('dictionary', ['DICT_6X6_250', 'DICT_4X4_50', 'DICT_APRILTAG_36h11'])
@pytest.mark.parametrize('search', SEARCHES)
def test_white_tags_are_found_beside_black_ones(random, dictionary, search):
    frame, quads = wall(dictionary, 8)
    frame[:, 320:] = 255 - frame[:, 320:]
    detector = Detector(dictionary, search=search)
    for found in detector.detect(seen(frame, random)), detector.search(seen(frame, random), 24):
        assert_found(found, quads, 0.3)


@pytest.mark.parametrize('search', SEARCHES)
def test_tags_with_a_wide_border_are_found_if_its_width_is_given(random, search):
    frame, quads = wall('DICT_6X6_250', 5, border=2)
    assert_found(Detector(search=search, border=2).detect(seen(frame, random)), quads, 0.3)
    assert Detector(search=search).detect(seen(frame, random)) == []


@pytest.mark.parametrize('border', [0, 11, 1.5, 'wide'])
def test_an_impossible_border_is_refused(border):
    with pytest.raises(InputError, match='^The border of tags cannot be %s cells wide; choose from 1' % border):
        Detector(border=border)


@pytest.mark.parametrize('dictionary', ['DICT_6X6_250', 'DICT_4X4_50', 'DICT_APRILTAG_36h11'])
@pytest.mark.parametrize('turn', [0, 8])
def test_tags_half_in_a_hard_shadow_are_found(random, dictionary, turn):
    frame, quads = wall(dictionary, turn)
    frame[:, :115] *= 0.35
    assert_found(Detector(dictionary).detect(seen(frame, random)), quads, 0.4)


@pytest.mark.parametrize('dictionary, side, turn', [
    ('DICT_6X6_250', 25, 0), ('DICT_6X6_250', 60, 12), ('DICT_4X4_50', 60, 0), ('DICT_4X4_50', 120, 12),
    ('DICT_APRILTAG_36h11', 120, 0), ('DICT_APRILTAG_36h11', 25, 12)])
def test_a_tag_that_slides_out_of_the_frame_is_found_in_its_place_or_not_at_all(random, dictionary, side, turn):
    rotation = cv2.getRotationMatrix2D((0, 0), turn, 1)[:, :2]
    middle, detector = np.float32(side * SQUARE @ rotation.T + (160, 120)), Detector(dictionary)
    for edge in range(4):
        for step in range(20):
            gap = 5 - 0.5 * step  # from the outermost corner to the middle of the frame's outermost pixel
            quad = np.copy(middle)
            axis, is_far = edge % 2, edge // 2
            far = (320, 240)[axis] - 1 - gap
            quad[:, axis] += far - quad[:, axis].max() if is_far else gap - quad[:, axis].min()
            frame = np.full((240, 320), 170.0)
            paint(frame, quad, dictionary, 3)
            tags = detector.detect(seen(frame, random))
            if gap >= 0:
                assert [tag.id for tag in tags] == [3], gap
            for tag in tags:
                assert tag.id == 3
                np.testing.assert_allclose(tag.corners, quad, atol=0.75)
