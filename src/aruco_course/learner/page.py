"""The page at the end, to be printed: what was done and when, with the learner's own pictures."""
from __future__ import annotations

import base64
from datetime import datetime
from html import escape
from typing import Sequence

from aruco_ar import InputError
from aruco_ar.base.files import read_whole

from aruco_course.check import Exercise

from .package import Package, template
from .progress import Done, read

MAX_PICTURE_BYTES = 16 * 1024 * 1024
MONTHS = ('January', 'February', 'March', 'April', 'May', 'June', 'July', 'August', 'September', 'October',
          'November', 'December')


def page(package: Package, checks: Sequence[Exercise], name: str = '') -> str:
    """The page as HTML, in one file. ``name``: the learner's; if empty, there is a line to write it on."""
    progress = read(package)
    done = [progress.of(check.number) for check in checks]
    count = sum(bool(each.passed) for each in done)
    times = [each.passed for each in done if each.passed]
    when = ''
    if times:
        times.append(progress.started or times[0])
        first, last = _day(min(times, key=_moment)), _day(max(times, key=_moment))
        when = ', on %s' % first if first == last else ', from %s to %s' % (first, last)
    sections = [_section(package, check, each) for check, each in zip(checks, done)]
    return template('course.html', {
        'name': escape(name) or '&nbsp;', 'done': str(count), 'all': str(len(done)), 'when': when,
        'package': escape(package.name), 'sections': '\n'.join(sections)}).decode()


def _section(package: Package, check: Exercise, done: Done) -> str:
    mark = '✔' if done.passed else '○'
    parts = ['<section>', '<h2>%s %s %s</h2>' % (mark, check.number, escape(check.title))]
    if not done.passed:
        sentence = 'Begun, and not right yet.' if done.attempts else 'Not begun yet.'
        return '\n'.join([*parts, '<p class="quiet">%s</p>' % sentence, '</section>'])
    picture = _picture(package, check)
    if picture:
        parts.append('<div class="both">\n<div><img src="data:image/png;base64,%s" alt="What the code of '
                     'exercise %s shows"></div>' % (picture, check.number))
    parts.append('<div>\n<p>%s</p>' % escape(_how(done)))
    if done.challenges:
        survived = ', '.join(name for name, survives in done.challenges.items() if survives)
        parts.append('<p>Challenges survived: %s.</p>' % escape(survived or 'none yet'))
    if done.faults:
        parts.append('<p class="quiet">Mended on the way:</p>\n<ul class="quiet">')
        parts += ['<li>%s</li>' % escape(sentence) for sentence in done.faults]
        parts.append('</ul>')
    return '\n'.join([*parts, '</div>', *(['</div>'] if picture else []), '</section>'])


def _how(done: Done) -> str:
    """When it was right, after what."""
    moment = _moment(done.passed)
    parts = ['Right on %s at %s' % (_day(done.passed), moment.strftime('%H:%M')),
             'after %s' % _counted(done.attempts, 'attempt')]
    if done.hints:
        parts.append('with %s' % _counted(done.hints, 'hint'))
    # After the pass everybody may see it.
    if done.solution_seen and _moment(done.solution_seen) < moment:
        parts.append('having seen a solution')
    text = ', '.join(parts) + '.'
    return text + (' It also ran as a ROS node.' if done.node_passed else '')


def _picture(package: Package, check: Exercise) -> str:
    try:
        data = read_whole(package.passed_picture(check), MAX_PICTURE_BYTES)
    except InputError:
        return ''
    return base64.b64encode(data).decode()


def _counted(number: int, thing: str) -> str:
    return '%d %s%s' % (number, thing, '' if number == 1 else 's')


def _moment(text: str) -> datetime:
    return datetime.fromisoformat(text)


def _day(text: str) -> str:
    moment = _moment(text)
    return '%d %s %d' % (moment.day, MONTHS[moment.month - 1], moment.year)
