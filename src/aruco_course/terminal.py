"""How things look on a terminal, and as plain text that a screen reader reads well."""
from __future__ import annotations

import os
import shutil
import textwrap
from typing import Iterable, Sequence, TextIO

from aruco_ar.base.system import knows_escapes

from .check import Exercise
from .learner.progress import Progress

NARROWEST, WIDEST = 24, 200  # columns
READABLE = 100               # columns: longer lines of text are hard to read, so only code may have them
CLEAR = '\x1b[2J\x1b[H'
STYLES = {'bold': '1', 'dim': '2', 'red': '1;31', 'green': '1;32', 'yellow': '1;33', 'cyan': '36',
          'added': '32', 'removed': '31'}


class Screen:
    """Writes to a stream. Text is wrapped to the terminal's width.

    ``is_plain``: no clearing, no drawing, and words where there would be a symbol. So it is if the stream is no
    terminal. Colors need a terminal, too, and NO_COLOR must not be set.
    """

    def __init__(self, stream: TextIO, plain: bool = False) -> None:
        self._stream = stream
        terminal = stream.isatty() and os.environ.get('TERM') != 'dumb' and knows_escapes()
        self.is_plain = plain or not terminal
        self._colors = terminal and not plain and not os.environ.get('NO_COLOR')
        self._symbols = not self.is_plain and _can_encode(stream, '✔✘●○─')

    @property
    def width(self) -> int:
        """That of the terminal in columns, within reason."""
        return min(max(shutil.get_terminal_size().columns, NARROWEST), WIDEST)

    def clear(self) -> None:
        """Begin with an empty screen, if there is one."""
        if not self.is_plain:
            self._write(CLEAR)

    def text(self, text: str = '', style: str = '', indent: int = 0, first: str | None = None) -> None:
        """Paragraphs, separated by empty lines. ``first``: begins the first line; as wide as indent."""
        width = min(self.width, READABLE)
        start = ' ' * indent if first is None else first
        for number, paragraph in enumerate(clean(text).split('\n\n')):
            if number:
                self._write('\n')
            lines = textwrap.wrap(' '.join(paragraph.split()), width, initial_indent=start,
                                  subsequent_indent=' ' * indent, break_on_hyphens=False) or ['']
            for line in lines:
                self._write(self._styled(line, style) + '\n')
            start = ' ' * indent

    def lines(self, text: str, style: str = '', indent: int = 2) -> None:
        """Text with its own lines, such as code. The terminal wraps them, so that they can be copied."""
        for line in clean(text).splitlines():
            self._write(' ' * indent + self._styled(line, style) + '\n')

    def title(self, text: str) -> None:
        """A heading."""
        self.text(text, 'bold')
        if self._symbols:
            self._write(self._styled('─' * min(self.width, READABLE), 'dim') + '\n')
        elif not self.is_plain:
            self._write('-' * min(self.width, READABLE) + '\n')

    def right(self, text: str) -> None:
        """A sentence that something is right."""
        self._marked(text, '✔', 'green')

    def wrong(self, text: str) -> None:
        """A sentence that something is wrong."""
        self._marked(text, '✘', 'red')

    def open(self, text: str) -> None:
        """A sentence on what may still be done, but need not."""
        self._marked(text, '○', 'yellow')

    def _marked(self, text: str, symbol: str, style: str) -> None:
        first, indent = (symbol + ' ', 2) if self._symbols else (None, 0)
        self.text(text, style, indent, first)

    def difference(self, lines: Iterable[str]) -> None:
        """A unified diff."""
        for line in lines:
            style = {'+': 'added', '-': 'removed', '@': 'cyan'}.get(line[:1], '')
            self.lines(line.rstrip('\n') or ' ', 'bold' if line.startswith(('+++', '---')) else style, indent=0)

    def progress(self, exercises: Sequence[Exercise], progress: Progress, current: Exercise | None) -> None:
        """Which exercises are done, and which is at hand."""
        done = [bool(progress.of(each.number).passed) for each in exercises]
        sentence = '%d of %d done' % (sum(done), len(done))
        if self.is_plain:
            words = ['%s %s' % (each.number, 'done' if passed else 'at hand' if each is current else 'to do')
                     for each, passed in zip(exercises, done)]
            self.text('%s: %s.' % (sentence, ', '.join(words)))
            return
        parts = []
        for each, passed in zip(exercises, done):
            symbol, style = ('✔', 'green') if passed else ('●', 'yellow') if each is current else ('·', 'dim')
            if not self._symbols:
                symbol = {'✔': 'x', '●': '>', '·': '-'}[symbol]
            part = '%s %s' % (symbol, each.number)
            parts.append((part, self._styled(part, 'bold' if each is current and passed else style)))
        parts.append((sentence, self._styled(sentence, 'dim')))
        self._flow(parts)

    def _flow(self, parts: Iterable[tuple[str, str]]) -> None:
        """Parts side by side, each as it is measured and as it is written."""
        column = 0
        for plain, styled in parts:
            if column and column + 3 + len(plain) > self.width:
                self._write('\n')
                column = 0
            self._write(('   ' if column else '') + styled)
            column += (3 if column else 0) + len(plain)
        self._write('\n')

    def _styled(self, text: str, style: str) -> str:
        return '\x1b[%sm%s\x1b[0m' % (STYLES[style], text) if style and self._colors else text

    def _write(self, text: str) -> None:
        encoding = self._stream.encoding or 'ascii'
        self._stream.write(text.encode(encoding, 'replace').decode(encoding))
        self._stream.flush()


def clean(text: str) -> str:
    """The text, with escapes for what would disturb the terminal, such as what the learner's code prints."""
    return ''.join(each if each.isprintable() or each == '\n' else each.encode('unicode_escape').decode()
                   for each in text.expandtabs(4).replace('\r\n', '\n'))


def _can_encode(stream: TextIO, text: str) -> bool:
    try:
        text.encode(stream.encoding or 'ascii')
    except UnicodeEncodeError:
        return False
    return True
