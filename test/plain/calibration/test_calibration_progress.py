"""What somebody is told who calibrates a camera while it runs."""
import aruco_ar.calibration.calibration_progress as calibration_progress
import numpy as np
import pytest
from aruco_ar import InputError, Lens, draw_tag
from aruco_ar.calibration.calibrated import Calibrated
from aruco_ar.calibration.calibration_progress import SHOW, CalibrationProgress
from aruco_ar.calibration.collection import LIKE, MOVING
from aruco_ar.calibration.sheets import CharucoBoard, TagSheet
from aruco_ar.calibration.views import MAX_VIEWS
from rig.accuracy.views import LENSES, SIZE, sheet, views_of

FRAME = np.full((480, 640, 3), 200, np.uint8)
FOUND = Calibrated(LENSES['barrel'], 0.1, 0.1, 20, 1.0, 0.1)
UNSURE = Calibrated(LENSES['barrel'], 0.1, 0.1, 20, 1.0, 2.0)
BETTER = 'Newer views tell a better lens: at the corners of the image it may be off by 0.2 px, and the saved ' \
         'one is 1.4 px away from it. To save the better one: SAVE'


def frame_with(dictionary, side, border=1):
    frame = FRAME.copy()
    for number in range(4):
        x, y = 60 + 140 * number, 200
        frame[y - 20:y + side + 20, x - 20:x + side + 20] = 255
        frame[y:y + side, x:x + side] = draw_tag(dictionary, number, side, border)[..., None]
    return frame


def show(progress, frame, seconds=0.2, sheet=None):
    """Show a frame for some seconds; returns the text then."""
    sheet = sheet or TagSheet('DICT_6X6_250')
    for stamp in np.arange(0, seconds, 0.1):
        search = progress.update(frame, stamp, sheet.view(frame))
        if search is not None:
            search()
    return progress.text('SAVE', 'RESET')


@pytest.mark.long
def test_what_keeps_a_sheet_from_being_seen_is_named():
    tags = TagSheet('DICT_6X6_250')
    assert CalibrationProgress(SIZE, tags).text('SAVE', 'RESET') == SHOW
    few = SHOW + ' Too little of the sheet is in sight. A view needs two tags of DICT_6X6_250, each at least ' \
                 '20 px wide.'
    for side in 0, 17:
        frame = frame_with('DICT_6X6_250', side) if side else FRAME
        assert show(CalibrationProgress(SIZE, tags), frame, 10) == few
    said = show(CalibrationProgress(SIZE, tags), frame_with('DICT_4X4_50', 60), 20)
    assert said.startswith('4 tags of DICT_4X4_50 (0, 1, 2, 3) are in sight') and \
        'Give dictionary:=DICT_4X4_50.' in said
    said = show(CalibrationProgress(SIZE, tags), frame_with('DICT_6X6_250', 60, border=2), 20)
    assert 'have a black border 2 cells wide, but the node looks for one 1 cell wide. Print other tags' in said
    board = CharucoBoard('DICT_6X6_250', 5, 7, 0.7)
    assert 'of a board of 5 x 7 squares' in show(CalibrationProgress(SIZE, board), FRAME, sheet=board)


def test_why_a_view_is_not_kept_is_said():
    view, other = views_of(LENSES['barrel'], sheet(), 2)
    progress = CalibrationProgress(SIZE, TagSheet('DICT_6X6_250'))
    for number, (each, end) in enumerate([(view, MOVING), (view, SHOW), (view, LIKE), (other, MOVING)]):
        progress.update(FRAME, number / 10, each)
        assert progress.text('SAVE', 'RESET').endswith(end)
    progress.forget_last_frames()
    assert progress.text('SAVE', 'RESET').endswith(SHOW)


def test_a_good_result_outlives_a_later_failure(monkeypatch):
    progress = CalibrationProgress(SIZE, TagSheet('DICT_6X6_250'))

    def fail(*_):
        raise InputError('These views tell nothing.')
    monkeypatch.setattr(calibration_progress, 'calibrate', fail)
    progress.solve(8, False)
    assert progress.found is None and 'These views tell nothing.' in progress.text('SAVE', 'RESET')
    monkeypatch.setattr(calibration_progress, 'calibrate', lambda *_: FOUND)
    progress.solve(9, False)
    assert progress.found is FOUND and progress.text('SAVE', 'RESET').endswith('To save it: SAVE')
    monkeypatch.setattr(calibration_progress, 'calibrate', fail)
    progress.solve(10, False)
    assert progress.found is FOUND
    assert progress.text('SAVE', 'RESET').endswith('there is no better one. To save it: SAVE')
    progress.note_saved(FOUND, 'camera.yaml')
    assert progress.text('SAVE', 'RESET').endswith('It is saved as camera.yaml.')


def calibrated(focal, corners):
    """A Calibrated with a focal length, pixels. One of 562 px is 1.4 px from one of 560 px at the corners."""
    matrix = LENSES['barrel'].matrix * [[focal / 560], [focal / 560], [1]]
    matrix[:2, 2] = LENSES['barrel'].matrix[:2, 2]
    return Calibrated(Lens(*SIZE, matrix, np.zeros(5)), 0.1, 0.1, 20, 1.0, corners)


@pytest.mark.parametrize('focal, corners, end', [
    (560.3, 0.1, 'Newer views move the corners of the image by 0.21 px, too little to matter.'),
    (562, 0.2, BETTER),
    (562, 0.9, 'Newer views tell no better lens.')])
@pytest.mark.parametrize('is_late', [False, True])
def test_what_is_saved_stays_saved_and_a_lens_that_is_better_by_something_that_matters_is_offered(
        focal, corners, end, is_late, monkeypatch):
    progress, saved, newer = CalibrationProgress(SIZE, TagSheet('DICT_6X6_250')), calibrated(560, 0.8), \
        calibrated(focal, corners)
    monkeypatch.setattr(calibration_progress, 'calibrate', lambda *_: newer)
    progress.found = saved
    steps = [lambda: progress.note_saved(saved, 'camera.yaml'), lambda: progress.solve(9, False)]
    for step in steps[::-1] if is_late else steps:  # late: the newer lens is found while the file is written
        step()
    text = progress.text('SAVE', 'RESET')
    assert text.endswith('It is saved as camera.yaml. ' + end)
    assert 'The focal length is %.1f px' % (focal if 'SAVE' in end else 560) in text  # that of the lens to use
    progress.note_saved(newer, 'camera.yaml')
    assert progress.text('SAVE', 'RESET').endswith('It is saved as camera.yaml.')


@pytest.mark.parametrize('found, why, end', [
    (UNSURE, '', 'Save it (SAVE), or begin anew (RESET).'), (FOUND, '', 'To save it: SAVE'),
    (None, 'None.', 'None. To begin anew: RESET'), (None, '', '% of the image.')])
def test_no_more_views_are_asked_for_when_no_more_are_taken(found, why, end):
    progress = CalibrationProgress(SIZE, TagSheet('DICT_6X6_250'))
    progress.collection.views += views_of(LENSES['barrel'], sheet(), 1) * MAX_VIEWS
    progress.found, progress.why = found, why
    text = progress.text('SAVE', 'RESET')
    assert text.endswith(end) and 'more views' not in text
