"""artag_generator.py as a user runs it: its files, its sheet, and its errors."""
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import cv2
import numpy as np
import pypdfium2
import pytest
from aruco_ar import Detector, find_area
from aruco_ar.tags.sheet import PAGES, tag_sheet

DPI = 150
MM_PER_PX = 25.4 / DPI


@pytest.fixture
def generate(package, tmp_path):
    """A function that runs the generator in an empty folder, and returns (exit code, output)."""
    def run(*arguments):
        done = subprocess.run([sys.executable, package + '/src/artag_generator.py', *arguments],
                              cwd=str(tmp_path), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              env=dict(os.environ, PYTHONPATH=package + '/src'), text=True)
        return done.returncode, done.stdout
    return run


def read_pages(path):
    """The pages of a PDF as gray pictures with a resolution of DPI."""
    return [np.array(page.render(scale=DPI / 72).to_pil().convert('L'))
            for page in pypdfium2.PdfDocument(path)]


def test_the_four_tags_of_the_course_are_included(package):
    for tag_id in (1, 2, 3, 4):
        image = cv2.imread('%s/Tags/image_%d.jpg' % (package, tag_id), cv2.IMREAD_GRAYSCALE)
        assert image.shape == (700, 700)
        framed = cv2.copyMakeBorder(image, 100, 100, 100, 100, cv2.BORDER_CONSTANT, value=255)
        assert [tag.id for tag in Detector().detect(framed)] == [tag_id]


@pytest.mark.parametrize('form', ['jpg', 'png'])
def test_written_pictures_are_detected(generate, tmp_path, form):
    code, output = generate('--ids', '7,20-22', '--size', '300', '--quiet', '1', '--format', form,
                            '--dictionary', 'DICT_5X5_100', '--output', 'mine')
    assert code == 0 and 'image_7.' + form in output
    assert sorted(os.listdir(str(tmp_path / 'mine'))) == ['image_%d.%s' % (i, form)
                                                          for i in (20, 21, 22, 7)]
    for tag_id in (7, 20, 21, 22):
        image = cv2.imread(str(tmp_path / 'mine' / ('image_%d.%s' % (tag_id, form))))
        assert image.shape == (386, 386, 3)  # 300 px are 7 cells; there is one more on each side
        assert [tag.id for tag in Detector('DICT_5X5_100').detect(image)] == [tag_id]


def test_a_written_svg_is_detected(generate, tmp_path):
    assert generate('--ids', '17', '--format', 'svg', '--quiet', '2', '--output', '.', '--side', '120')[0] == 0
    svg = ElementTree.parse(str(tmp_path / 'image_17.svg')).getroot()
    cells = int(svg.get('viewBox').split()[2])
    assert cells == 12 and svg.get('width') == svg.get('height') == '180mm'  # 120 mm are 8 cells
    image = np.full((cells, cells), 255, np.uint8)
    path = svg.find('{http://www.w3.org/2000/svg}path').get('d')
    for run in path.replace('M', ' ').split('z')[:-1]:
        column, rest = run.split()
        row, length = rest.split('v')[0].split('h')
        image[int(row), int(column):int(column) + int(length)] = 0
    assert [tag.id for tag in Detector().detect(image.repeat(20, 0).repeat(20, 1))] == [17]


@pytest.mark.parametrize('page, width_mm, height_mm', [('A4', 210, 297), ('Letter', 215.9, 279.4)])
def test_the_tags_on_a_sheet_have_the_exact_size(generate, tmp_path, page, width_mm, height_mm):
    assert generate('--sheet', 'tags.pdf', '--page', page, '--ids', '1-8', '--side', '75')[0] == 0
    pages = read_pages(str(tmp_path / 'tags.pdf'))
    assert len(pages) == 3  # the last one says how to hang them
    found = []
    for image in pages:
        assert abs(image.shape[1] * MM_PER_PX - width_mm) < 0.3
        assert abs(image.shape[0] * MM_PER_PX - height_mm) < 0.3
        tags = Detector().detect(image)
        found += [tag.id for tag in tags]
        for tag in tags:
            sides = np.linalg.norm(tag.corners - np.roll(tag.corners, 1, axis=0), axis=1)
            np.testing.assert_allclose(sides * MM_PER_PX, 75, atol=0.25)
    assert sorted(found) == list(range(1, 9))


def test_the_ruler_has_the_right_length(tmp_path):
    file = tmp_path / 'ruler.pdf'
    file.write_bytes(tag_sheet('DICT_6X6_250', [1], 50))
    foot = read_pages(str(file))[0][int(-16 / MM_PER_PX):int(-12.5 / MM_PER_PX)]
    columns = np.flatnonzero((foot < 200).any(axis=0))
    assert abs((columns[-1] - columns[0]) * MM_PER_PX - 100) < 0.4


def test_the_sheet_names_the_tags(tmp_path):
    file = tmp_path / 'text.pdf'
    file.write_bytes(tag_sheet('DICT_4X4_50', [3], 62.5, page='Letter'))
    text = pypdfium2.PdfDocument(str(file))[0].get_textpage().get_text_range()
    assert 'DICT_4X4_50 id 3 side 62.5 mm' in ' '.join(text.split()) and '100 %' in text
    assert 'tag_size:=0.0625' in text
    assert set(PAGES) == {'A4', 'A3', 'Letter'}


def test_four_tags_on_a_page_are_placed_as_they_belong_each_with_its_id_in_its_margin(tmp_path):
    file = tmp_path / 'four.pdf'
    file.write_bytes(tag_sheet('DICT_6X6_250', [1, 2, 3, 4], 75))
    image = read_pages(str(file))[0]
    tags = {tag.id: tag for tag in Detector().detect(image)}
    assert [find_area(list(tags.values())).corners.tolist().index(tags[number].center.tolist())
            for number in (1, 2, 3, 4)] == [0, 1, 2, 3]
    for tag in tags.values():  # within the cut line, above the tag, and not at its edge
        (left, top), (right, _) = tag.corners[:2].astype(int)
        margin = image[top - int(9 / MM_PER_PX):top - 1, left:right]
        marked = np.flatnonzero((margin < 200).any(axis=1))
        assert len(marked) and marked.max() < 0.5 * len(margin)


def test_the_last_page_says_how_to_hang_them(tmp_path):
    file = tmp_path / 'how.pdf'
    file.write_bytes(tag_sheet('DICT_6X6_250', [5, 6, 7, 8], 75))
    text = ' '.join(pypdfium2.PdfDocument(str(file))[1].get_textpage().get_text_range().split())
    for words in 'How to hang the tags', 'up to 2.1 m away', 'tag_size:=0.075', '5', '6', '7', '8':
        assert words in text


@pytest.mark.parametrize('page', ['A4', 'A3', 'Letter'])
def test_one_page_is_a_wall_of_its_own(generate, tmp_path, page):
    assert generate('--sheet', 'wall.pdf', '--around-picture', '--page', page, '--ids', '4,7,9,2')[0] == 0
    (image,) = read_pages(str(tmp_path / 'wall.pdf'))
    assert image.shape[1] > image.shape[0]
    tags = {tag.id: tag for tag in Detector().detect(image)}
    corners = find_area(list(tags.values())).corners
    np.testing.assert_allclose(corners, [tags[number].center for number in (4, 7, 9, 2)])
    size = np.ptp(corners, axis=0) * MM_PER_PX
    text = pypdfium2.PdfDocument(str(tmp_path / 'wall.pdf'))[0].get_textpage().get_text_range()
    said = re.search('center to center: (\\d+) x (\\d+) mm', text).groups()
    np.testing.assert_allclose(size, [int(each) for each in said], atol=1)
    assert 'tag_size:=0.05' in text
    for tag in tags.values():
        np.testing.assert_allclose(np.linalg.norm(tag.corners[1] - tag.corners[0]) * MM_PER_PX, 50, atol=0.25)


@pytest.mark.parametrize('arguments, words', [
    (['--around-picture'], '--sheet tags.pdf'),
    (['--sheet', 'sheet.pdf', '--around-picture', '--ids', '1-3'], 'four different tags, not 3'),
    (['--sheet', 'sheet.pdf', '--around-picture', '--side', '80'], 'around a picture on A4; the largest'),
    (['--ids', '249-250'], 'id 250 is not in DICT_6X6_250'),
    (['--ids', 'one'], '"one" is not a list of ids'),
    (['--ids', '4-1'], 'smaller number first'),
    (['--size', '7'], 'from 8 to 10000'),
    (['--size', '700', '--format', 'svg'], 'in an svg is --side MM'),
    (['--size', '700', '--sheet', 'sheet.pdf'], 'on a sheet or in an svg is --side MM'),
    (['--format', 'svg', '--sheet', 'sheet.pdf'], '--format is for single tags; a sheet is always a PDF'),
    (['--output', 'mine', '--sheet', 'sheet.pdf'], 'before its name: --sheet mine/sheet.pdf'),
    (['ids:=5-8'], 'unrecognized arguments: ids:=5-8'),
    (['--output', ''], '--output takes the name of a folder'),
    (['--side', '75'], 'in a jpg or png is --size PIXELS'),
    (['--side', '0', '--format', 'svg'], 'from 1 to 1000'),
    (['--page', 'A3'], '--sheet tags.pdf'),
    (['--ids', '1-4,9-7'], '"9-7" contains no id; write the smaller number first'),
    (['--ids', '1,99999'], 'there is no tag 99999'),
    (['--size', '70000'], 'from 8 to 10000'),
    (['--ids', '1-'], '"1-" is not a list of ids'),
    (['--ids', '1-1000000000'], 'there is no tag 1000000000'),
    (['--sheet', 'sheet.png'], 'name of a PDF file'),
    (['--sheet', ''], 'name of a PDF file'),
    (['--sheet', 'sheet.pdf', '--side', 'inf'], 'from 1 to 1000'),
    (['--sheet', 'sheet.pdf', '--quiet', '9999'], 'from 0 to 10'),
    (['--dictionary', 'DICT_6x6'], 'no tag dictionary "DICT_6x6"'),
    (['--border', '0'], 'from 1 to 10'),
    (['--quiet', '-1'], 'from 0 to 10'),
    (['--output', '/dev/null/tags'], '/dev/null/tags'),
    (['--sheet', '/dev/null/sheet.pdf'], '/dev/null/sheet.pdf'),
    (['--sheet', 'sheet.pdf', '--side', '300'], 'do not fit on A4; the largest possible side is'),
    (['--sheet', 'sheet.pdf', '--side', '-5'], 'from 1 to 1000'),
])
def test_errors_are_sentences_and_leave_nothing_behind(generate, tmp_path, arguments, words):
    if '--output' not in arguments and '--sheet' not in arguments:
        arguments = arguments + ['--output', '.']
    code, output = generate(*arguments)
    assert code != 0 and words in output and 'Traceback' not in output
    assert os.listdir(str(tmp_path)) == []


def test_a_write_that_fails_halfway_leaves_nothing(generate, tmp_path):
    (tmp_path / 'out' / 'image_2.jpg').mkdir(parents=True)
    code, output = generate('--output', 'out')
    assert code != 0 and 'image_2.jpg' in output
    assert all(not name.startswith('.') for name in os.listdir(str(tmp_path / 'out')))
