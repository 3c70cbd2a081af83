"""The page at the end, to be printed: what was done and when, with the learner's own pictures."""
from __future__ import annotations

import base64
from datetime import datetime
from html import escape
from typing import Sequence

from aruco_ar import InputError
from aruco_ar.base.files import read_whole
from aruco_course.check import Exercise

from .package import Package
from .progress import Done, read

MAX_PICTURE_BYTES = 16 * 1024 * 1024
MONTHS = ('January', 'February', 'March', 'April', 'May', 'June', 'July', 'August', 'September', 'October',
          'November', 'December')
STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1d2733; background: #fff; max-width: 46rem;
       margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.2rem; margin: 0 0 .25rem; }
p { margin: .25rem 0; }
.who { font-size: 1.2rem; }
.name { display: inline-block; min-width: 60%; border-bottom: 1px solid #1d2733; }
section { border-top: 1px solid #c3ccd6; padding: 1rem 0; overflow-wrap: anywhere; }
img { display: block; max-width: 100%; height: auto; max-height: 20rem; margin: .75rem 0 .25rem;
      border: 1px solid #c3ccd6; }
ul { margin: .25rem 0; padding-left: 1.25rem; }
.quiet { color: #4a5866; }
summary { cursor: pointer; }
@page { size: A4; margin: 18mm; }
@media print {
  body { font-size: 10.5pt; max-width: none; margin: 0; padding: 0; }
  section { break-inside: avoid; }
  img { max-height: 75mm; }
  a { color: inherit; }
}
"""


def page(package: Package, checks: Sequence[Exercise], name: str = '') -> str:
    """The page as HTML, in one file. ``name``: the learner's; if empty, there is a line to write it on."""
    progress = read(package)
    done = [progress.of(check.number) for check in checks]
    count = sum(bool(each.passed) for each in done)
    times = sorted(each.passed for each in done if each.passed)
    when = ''
    if times:
        first, last = _day(min([progress.started or times[0], times[0]], key=_moment)), _day(max(times, key=_moment))
        when = ', on %s' % first if first == last else ', from %s to %s' % (first, last)
    sections = [_section(package, check, each) for check, each in zip(checks, done)]
    return """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Augmented reality with ArUco tags: what was done</title>
<style>%s</style>
</head>
<body>
<main>
<header>
<h1>Augmented reality with ArUco tags</h1>
<p class="who"><span class="name">%s</span></p>
<p>%d of %d exercises done%s. All code is the learner’s own, in the package <b>%s</b>.</p>
</header>
%s
</main>
</body>
</html>
""" % (STYLE, escape(name) or '&nbsp;', count, len(done), when, escape(package.name), '\n'.join(sections))


def _section(package: Package, check: Exercise, done: Done) -> str:
    parts = ['<section>', '<h2>%s %s %s</h2>' % ('✔' if done.passed else '○', check.number, escape(check.title))]
    if not done.passed:
        parts.append('<p class="quiet">%s</p>' % ('Begun, and not right yet.' if done.attempts else 'Not begun yet.'))
        return '\n'.join([*parts, '</section>'])
    parts.append('<p>%s</p>' % escape(_how(done)))
    picture = _picture(package, check)
    if picture:
        parts.append('<img src="data:image/png;base64,%s" alt="What the learner’s code for exercise %s shows">'
                     % (picture, check.number))
    survived = [name for name, survives in done.challenges.items() if survives]
    if done.challenges:
        parts.append('<p>%s</p>' % escape('Challenges survived: %s.' % (', '.join(survived) or 'none yet')))
    if done.faults:
        parts.append('<details open><summary class="quiet">Mended on the way</summary>\n<ul class="quiet">')
        parts += ['<li>%s</li>' % escape(sentence) for sentence in done.faults]
        parts.append('</ul></details>')
    return '\n'.join([*parts, '</section>'])


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
