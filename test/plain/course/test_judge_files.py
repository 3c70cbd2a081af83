"""Exercise 5.1: files of tags that can be read pass, in whatever style, and each mistake is named."""
import cv2
import numpy as np
import pytest
from aruco_course.check import Written
from aruco_course.judge.tag_files import files_fault, image_files


def draw(tag_id, size=700, dictionary='DICT_6X6_250', border=1):
    chosen = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
    return cv2.aruco.generateImageMarker(chosen, tag_id, size, borderBits=border)


@pytest.fixture
def judge(tmp_path):
    """A function that writes images, {path in the package: image}, and returns what is said of them."""
    def written(images, *flags):
        for name, image in images.items():
            path = tmp_path / name
            path.parent.mkdir(exist_ok=True)
            assert cv2.imwrite(str(path), image, flags)
        fault = files_fault(Written(tmp_path, tuple(image_files(tmp_path))))
        return None if fault is None else str(fault)
    return written


def four(change=draw, name='Tags/image_%d.jpg', ids=(1, 2, 3, 4)):
    return {name % number: change(tag_id) for number, tag_id in enumerate(ids, start=1)}


def framed(image):
    return cv2.copyMakeBorder(image, 60, 60, 60, 60, cv2.BORDER_CONSTANT, value=255)


@pytest.mark.parametrize('change', [
    draw, lambda tag_id: draw(tag_id, 100), lambda tag_id: framed(draw(tag_id)),
    lambda tag_id: cv2.cvtColor(draw(tag_id), cv2.COLOR_GRAY2BGR), lambda tag_id: np.rot90(draw(tag_id)),
    lambda tag_id: draw(tag_id, dictionary='DICT_6X6_1000'),
    lambda tag_id: cv2.resize(draw(tag_id, 8), (400, 400), interpolation=cv2.INTER_NEAREST),
], ids=['plain', 'small', 'white margin', 'colored', 'turned', 'larger dictionary', 'enlarged cells'])
def test_tags_that_can_be_read_pass(judge, change):
    assert judge(four(change)) is None


def test_other_formats_and_names_pass(judge):
    assert judge(four(name='Tags/tag%d.png')) is None
    assert judge(four(), cv2.IMWRITE_JPEG_QUALITY, 20) is None


def test_more_tags_and_a_sheet_of_all_pass(judge):
    sheet = np.vstack([framed(draw(tag_id, 200)) for tag_id in (1, 2, 3, 4)])
    assert judge({**four(ids=(1, 2, 3, 4, 5)), 'Tags/sheet.png': sheet}) is None


@pytest.mark.parametrize('change, says', [
    (lambda tag_id: draw(tag_id, dictionary='DICT_4X4_50'), 'a tag of DICT_4X4, but'),
    (lambda tag_id: draw(tag_id, dictionary='DICT_5X5_100'), 'a tag of DICT_5X5, but'),
    (lambda tag_id: draw(tag_id, dictionary='DICT_APRILTAG_36h11'), 'a tag of DICT_APRILTAG_36H11, but'),
    (lambda tag_id: cv2.bitwise_not(draw(tag_id)), 'black and white are exchanged'),
    (lambda tag_id: cv2.flip(draw(tag_id), 1), 'mirrored'),
    (lambda tag_id: draw(tag_id, 800)[100:700, 100:700], 'black border around the tag is missing'),
    (lambda tag_id: draw(tag_id, border=2), '2 cells wide'),
    (lambda tag_id: draw(tag_id, 50), 'only 50 x 50 pixels'),
    (lambda tag_id: cv2.resize(draw(tag_id, 8), (700, 700)), 'blurred'),
    (lambda tag_id: cv2.resize(draw(tag_id), (700, 350)), '700 x 350 pixels, but a tag is a square'),
    (lambda tag_id: np.full((700, 700), 255, np.uint8), 'one color only'),
    (lambda tag_id: draw(tag_id) // 255, 'white is 255, not 1'),
])
def test_mistake_in_a_file_is_named_with_the_file(judge, change, says):
    sentence = judge(four(change))
    assert says in sentence
    assert sentence.startswith('Tags/image_')


@pytest.mark.parametrize('ids, says', [
    ((0, 1, 2, 3), 'range(4) begins at 0'), ((1, 2, 3), 'Tag 4 is missing: range(1, 4)'),
    ((1, 1, 1, 1), 'All files show tag 1'), ((10, 20, 30, 40), 'The files show the tags 10, 20, 30, 40'),
    ((1, 2, 4, 3), 'Tags/image_3.jpg: it shows tag 4'), ((1, 2, 4), 'Tag 3 is missing'),
])
def test_wrong_ids_are_named(judge, ids, says):
    assert says in judge(four(ids=ids))


def test_files_of_other_places_are_not_enough(judge, tmp_path):
    assert 'no image into the folder Tags' in judge({})
    assert 'Tags of your package' in judge(four(name='image_%d.jpg'))
    assert 'only one file, Tags/image.jpg' in judge({'Tags/image.jpg': draw(4)})


def test_older_files_are_told_from_new_ones(judge, tmp_path):
    judge(four())
    assert 'those in the folder Tags are older' in str(files_fault(Written(tmp_path, ())))


def test_file_that_is_no_image_is_named(judge, tmp_path):
    judge(four())
    (tmp_path / 'Tags' / 'image_2.jpg').write_bytes(b'')
    assert judge({}) == 'Tags/image_2.jpg: it is no image that can be read.'


def test_what_imwrite_refused_is_said(tmp_path):
    fault = files_fault(Written(tmp_path, (), (tmp_path / 'no' / 'image_1.jpg',)))
    assert 'There is no folder' in fault.what
    assert 'no ending' in files_fault(Written(tmp_path, (), (tmp_path / 'image_1',))).what
