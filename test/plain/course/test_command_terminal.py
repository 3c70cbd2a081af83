"""The terminal's look: it fits any width, and as plain text it has words for everything."""
import re

import pytest
from aruco_course import say
from aruco_course.check import Fault
from aruco_course.terminal import Screen
from aruco_course.verdict import Verdict

ESCAPE = re.compile('\x1b\\[[0-9;]*[A-Za-z]')
LONG = 'a sentence with /a/path/that/is/longer/than/any/narrow/terminal/is/wide.png, and more words after it.'


def show(screen, course):
    check = course.exercise('5.4')
    screen.clear()
    screen.progress(course.checks, course.progress, check)
    say.task(screen, check)
    say.verdict(screen, course, Verdict(check, Fault(LONG, 'Frame 12'), printed='printed ' * 60))
    say.verdict(screen, course, Verdict(check, None))
    say.hints(screen, check, check.hints)
    say.solution(screen, course, check, ['--- yours', '+++ ours', '@@ -1 +1 @@', '-' + 'x' * 150, '+y'])


@pytest.mark.parametrize('columns', [1, 24, 40, 41, 80, 200, 1000])
def test_no_line_of_text_is_wider_than_the_terminal(terminal, course, columns):
    screen, stream = terminal(columns)
    show(screen, course)
    lines = [ESCAPE.sub('', line) for line in stream.getvalue().splitlines()]
    # Code and what was printed stay whole, so that they can be copied; the terminal wraps them.
    assert max(len(line) for line in lines if not re.search('x{150}|(printed ){59}', line)) \
        <= min(max(columns, 24), 200)
    assert '-' + 'x' * 150 in lines
    assert 'yours' in stream.getvalue() and '\x1b[' in stream.getvalue()


def test_nothing_of_a_text_is_lost_by_wrapping(terminal, course):
    screen, stream = terminal(40)
    screen.text(LONG, indent=4)
    assert stream.getvalue().replace('\n', '').replace(' ', '') == LONG.replace(' ', '')


def test_without_colors_there_are_none(terminal, course, monkeypatch):
    _, stream = terminal()
    monkeypatch.setenv('NO_COLOR', '1')
    show(Screen(stream), course)
    assert set(ESCAPE.findall(stream.getvalue())) <= {'\x1b[2J', '\x1b[H'}


def test_plain_text_has_neither_escapes_nor_symbols(terminal, course, solve):
    solve('5.4')
    screen, stream = terminal(80, plain=True)
    show(screen, course)
    text = stream.getvalue()
    assert '\x1b' not in text and not re.search('[^\x00-\x7f]', text.replace('…', ''))
    assert '---' not in text.replace('--- yours', '')  # no lines are drawn
    assert '5.4 is not right yet.' in text and '5.4 is right.' in text
    assert '5.1 to do' in text and '5.4 at hand' in text and '0 of 6 done' in text


def test_a_terminal_without_unicode_gets_what_it_can_show(terminal, course):
    screen, stream = terminal(80, encoding='ascii')
    show(screen, course)
    stream.getvalue().encode('ascii')


def test_what_the_learners_code_prints_cannot_disturb_the_terminal(terminal, course):
    screen, stream = terminal(80, plain=True)
    check = course.exercise('5.2')
    say.verdict(screen, course, Verdict(check, Fault('\x1b]0;title\x07'), printed='\x1b[2Jgone\r\n\x00\x9b31m'))
    assert not re.search('[\x00-\x09\x0b-\x1f\x7f-\x9f]', stream.getvalue()) and 'gone' in stream.getvalue()
