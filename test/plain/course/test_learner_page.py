"""The page at the end: one file that needs nothing else, with the learner's own pictures."""
import re

import cv2
import numpy as np
from aruco_ar.base.files import write_whole
from aruco_course.learner import progress
from aruco_course.learner.page import page


def test_it_tells_what_was_done_and_shows_the_pictures(course):
    first, second, third = course.checks[:3]
    with progress.changed(course.package) as changing:
        done = changing.of(first.number)
        done.attempt('a', 'Line 3: <script>alert(1)</script> & more.')
        done.attempt('b', None)
        done.hints = 2
        done.challenges = {'no tag in sight': True, 'three tags': False}
        changing.of(second.number).attempt('a', 'Line 1: wrong.')
    data = cv2.imencode('.png', np.full((48, 64, 3), 7, np.uint8))[1].tobytes()
    write_whole(course.package.passed_picture(first), data)
    text = page(course.package, course.checks, 'Ada <Lovelace>')
    assert '1 of 6 exercises done' in text and 'my_unit5' in text
    assert 'after 2 attempts, with 2 hints' in text and 'Challenges survived: no tag in sight.' in text
    assert 'Begun, and not right yet' in text and text.count('Not begun yet') == len(course.checks) - 2
    assert 'Ada &lt;Lovelace&gt;' in text and '<script' not in text
    assert third.title in text and text.count('<img') == 1 and 'alt="' in text


def test_it_needs_nothing_from_elsewhere(course):
    text = page(course.package, course.checks)
    assert not re.search(r'https?:|<link|<script|@import|url\(', text) and '@package@' not in text
    assert '0 of 6 exercises done.' in text


def test_with_a_broken_progress_there_is_a_page_still(course):
    write_whole(course.package.path('.learn', 'progress.json'), b'{')
    assert '0 of 6 exercises done.' in page(course.package, course.checks)
