"""What the page says on its pictures, of what nodes say on /diagnostics."""
import pytest
from aruco_node.health.diagnostics import ERROR, OK, WARN
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from page_server.advice import sentence_of

AREA = {'area': 'Four tags have not been seen together.', 'area last seen (s ago)': 'none seen'}
SEEN = {'area': 'Its tags show it.', 'area last seen (s ago)': '0.0'}
HINT = '4 tags of DICT_4X4_50 are in sight.'
HANGS = 'The picture hangs upside down.'


@pytest.mark.parametrize('level, message, values, expected', [
    (ERROR, 'Waiting for frames on /eye.', AREA, 'Waiting for frames on /eye.'),
    (OK, '30.0 frames a second', SEEN, ''),
    (OK, '30.0 frames a second', AREA, AREA['area']),
    (OK, '30.0 frames a second', {'area': 'None of its tags is in sight.', 'area last seen (s ago)': '1.5'},
     'None of its tags is in sight.'),
    (WARN, HINT, {**AREA, 'hint': HINT}, HINT),
    (WARN, 'Slow: 40 of 120 frames were dropped within 5 s.', SEEN, ''),
    (OK, '30.0 frames a second', {**SEEN, 'upside down': HANGS}, HANGS),
    (OK, '30.0 frames a second', {'calibration': '3 views'}, '3 views'),
])
def test_it_says_why_there_is_no_picture_and_what_to_do(level, message, values, expected):
    status = DiagnosticStatus(level=level, message=message,
                              values=[KeyValue(key, value) for key, value in values.items()])
    assert sentence_of(status) == expected
