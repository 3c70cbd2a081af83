"""What the page says on its pictures, of what nodes say on /diagnostics."""
import pytest
from aruco_node.health.diagnostics import ERROR, OK, WARN
from aruco_node.messages.images import ENCODING
from aruco_node.page.advice import MAX_TEXT, sentence_of
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

NOW = 'area in the last frame'
WHY = 'Four tags have not been seen together.'
NONE = {'area': WHY, 'area last seen (s ago)': 'none seen', NOW: 'no'}
LOST = {'area': 'No tag is in sight.', 'area last seen (s ago)': '1.5', NOW: 'no'}
SEEN = {'area': 'Its tags show it.', 'area last seen (s ago)': '0.0', NOW: 'yes'}
HINT = '4 tags of DICT_4X4_50 are in sight.'
SWAPPED = 'Frames with the encoding yuv422 have their bytes in the order of yuv422_yuy2, and are read as such.'
HANGS = 'The picture hangs upside down.'


@pytest.mark.parametrize('level, message, values, expected', [
    (ERROR, 'Waiting for frames on /eye.', NONE, ('Waiting for frames on /eye.', True)),
    (OK, '30.0 frames a second', SEEN, ('', False)),
    (OK, '30.0 frames a second', NONE, (WHY, False)),
    (OK, '30.0 frames a second', LOST, ('No tag is in sight.', False)),
    (OK, '30.0 frames a second', {**LOST, 'area last seen (s ago)': '0.4'}, ('', False)),
    (OK, '0.4 frames a second', {**SEEN, 'area last seen (s ago)': '1.9'}, ('', False)),  # a slow camera
    (OK, 'Nobody listens, so nothing is computed.',
     {'area': 'Its tags show it.', 'area last seen (s ago)': '70.0'}, ('', False)),
    (WARN, HINT, {**NONE, 'hint': HINT}, (HINT, False)),
    (WARN, 'Slow: 40 of 120 frames were dropped within 5 s.', SEEN, ('', False)),
    (OK, '30.0 frames a second', {**SEEN, 'upside down': HANGS}, (HANGS, False)),
    (WARN, 'No tag has been in sight for 11 s.', {NOW: 'no', 'area last seen (s ago)': 'none seen'},
     ('No tag has been in sight for 11 s.', False)),
    (WARN, 'No tag has been in sight for 11 s.', NONE, (WHY, False)),
    (OK, '30.0 frames a second', {'calibration': '3 views'}, ('3 views', False)),
    (OK, '30.0 frames a second', {**SEEN, ENCODING: SWAPPED}, (SWAPPED, False)),
    (OK, '30.0 frames a second', {**NONE, ENCODING: SWAPPED}, (WHY + ' ' + SWAPPED, False)),
    # Not ours:
    (OK, '', {'area': '5 m2'}, ('', False)),
    (OK, '', {**NONE, 'area last seen (s ago)': 'x'}, ('', False)),
    (OK, '', {**NONE, 'area last seen (s ago)': 'nan'}, ('', False)),
    (OK, '', {NOW: 'no', 'area last seen (s ago)': 'none seen'}, ('', False)),
    (ERROR, 'x' * 10000, {}, ('x' * MAX_TEXT, True)),
])
def test_it_says_why_there_is_no_picture_and_what_to_do(level, message, values, expected):
    status = DiagnosticStatus(level=level, message=message,
                              values=[KeyValue(key, value) for key, value in values.items()])
    assert sentence_of(status) == expected
