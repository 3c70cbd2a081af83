"""script/bench --peers: what it counts as found, and as wrong, and how exact, where all of this is known."""
import re
import sys

import cv2
import numpy as np
import pytest
from aruco_ar import InputError, draw_tag
from benchmark.peers import compare
from benchmark.peers.detectors import DEFAULT, SUBPIX

SIDE = 80
APRIL = 'DICT_APRILTAG_36h11'


@pytest.fixture
def draw(tmp_path):
    """A function that draws a photo into tmp_path, and lists its tags."""
    def drawn(name, tags, truth=None, dictionary='DICT_6X6_250'):
        """``tags``: {id: the left and top pixel of a tag}. ``truth``: the same, or a list of ids, or None."""
        photo = np.full((240, 320, 3), 255, np.uint8)
        for tag_id, (left, top) in tags.items():
            photo[top:top + SIDE, left:left + SIDE] = draw_tag(dictionary, tag_id, SIDE)[..., None]
        cv2.imwrite(str(tmp_path / (name + '.png')), photo)
        if truth is not None:
            (tmp_path / (name + '.txt')).write_text('\n'.join(
                line(tag_id, *truth[tag_id]) if isinstance(truth, dict) else str(tag_id) for tag_id in truth))
    return drawn


def line(tag_id, left, top):
    """A line of the file, from the tag's top left; the middle of a pixel is a whole number."""
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * SIDE - 0.5 + [left, top]
    return '%d, %s' % (tag_id, ', '.join('(%.4f %.4f)' % tuple(corner) for corner in corners))


def table(folder, capsys, dictionary='DICT_6X6_250'):
    """{detector: its figures as text}, of the only scene that is shown, and all that is printed."""
    compare.run([str(folder)], dictionary)
    text = capsys.readouterr().out
    rows = re.findall(r'^  ((?:OpenCV|AprilTag 3|ours)(?:, \w+(?: 3)?)?) +(\d.*)$', text, re.MULTILINE)
    return {name: re.split(r' {2,}', figures) for name, figures in rows}, text


def test_what_is_found_and_what_is_missed(tmp_path, draw, capsys):
    draw('one', {3: (20, 20), 7: (160, 100)}, {3: (20, 20), 7: (160, 100), 9: (20, 130)})
    draw('two', {5: (120, 60)}, {5: (120, 60)})
    rows, text = table(tmp_path, capsys)
    assert len(rows) == 7 and '2 photos, corners known, DICT_6X6_250' in text
    for figures in rows.values():
        assert figures[:3] == ['3 of 4', '0', '0']
    exact, default = (float(rows[name][3]) for name in ('ours, normal', DEFAULT))
    assert exact < 0.1 and 0.3 < default < 1  # OpenCV has the middles of the outermost pixels
    assert rows[DEFAULT][-1].endswith(' = 1.00x')


def test_a_tag_that_is_not_there_is_wrong(tmp_path, draw, capsys):
    draw('one', {3: (20, 20), 7: (160, 100)}, {3: (20, 20)})
    for figures in table(tmp_path, capsys)[0].values():
        assert figures[:3] == ['1 of 1', '1', '0']


def test_a_photo_of_which_is_known_that_it_has_no_tag(tmp_path, draw, capsys):
    draw('one', {3: (20, 20)}, [])
    for figures in table(tmp_path, capsys)[0].values():
        assert figures[:3] == ['0 of 0', '1', '0']


def test_a_tag_far_from_its_place_is_neither_right_nor_another(tmp_path, draw, capsys):
    draw('one', {3: (20, 20), 7: (160, 100)}, {3: (20, 20), 7: (160, 130)})
    for figures in table(tmp_path, capsys)[0].values():
        assert figures[:3] == ['1 of 2', '0', '1']


def test_where_only_the_ids_are_known_no_corner_is_judged(tmp_path, draw, capsys):
    draw('one', {3: (20, 20), 7: (160, 100)}, [7, 8])
    rows, text = table(tmp_path, capsys)
    assert '1 photo, ids known' in text
    for figures in rows.values():
        assert figures[:6] == ['1 of 2', '1', '0', '-', '-', '-']


def test_without_truth_it_says_by_how_many_each_id_is_found(tmp_path, draw, capsys):
    draw('one', {3: (20, 20), 7: (160, 100)})
    rows, text = table(tmp_path, capsys)
    for figures in rows.values():
        assert figures[:3] == ['2', '-', '-']
    assert 'ids found, by how many of the 7: 2 by 7\n' in text


def test_half_a_pixel_is_taken_off_the_corners_of_apriltag(tmp_path, draw, capsys):
    pytest.importorskip('pupil_apriltags')
    draw('one', {3: (20, 20), 7: (160, 100)}, {3: (20, 20), 7: (160, 100)}, APRIL)
    rows, _ = table(tmp_path, capsys, APRIL)
    assert len(rows) == 9
    for name in 'AprilTag 3', 'AprilTag 3, whole', 'OpenCV, APRILTAG', SUBPIX:
        assert rows[name][:3] == ['2 of 2', '0', '0'] and float(rows[name][3]) < 0.5


def test_it_says_why_apriltag_is_missing(tmp_path, draw, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, 'pupil_apriltags', None)
    draw('one', {3: (20, 20)}, [3], APRIL)
    rows, text = table(tmp_path, capsys, APRIL)
    assert len(rows) == 7
    assert re.search('AprilTag 3 +pupil-apriltags cannot be loaded: .*pupil_apriltags', text)


@pytest.mark.parametrize('words', [
    '7, (10 10), (50 10)', 'seven', '7.5', '-7', '7.5, (10 10), (50 10), (50 50), (10 50)'])
def test_a_wrong_line_is_named(tmp_path, draw, words):
    draw('one', {3: (20, 20)}, [3])
    (tmp_path / 'one.txt').write_text('3\n%s\n' % words)
    with pytest.raises(InputError, match=r'Line 2 of ".*one.txt" is not a tag; give its id'):
        compare.run([str(tmp_path)], 'DICT_6X6_250')


def test_a_folder_without_photos_is_named(tmp_path):
    with pytest.raises(InputError, match='has no photo and no clip'):
        compare.run([str(tmp_path)], 'DICT_6X6_250')
