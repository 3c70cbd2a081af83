"""Telling how far long work is: a bar on a terminal, plain lines in a log."""
from __future__ import annotations

import sys
import time
from operator import length_hint
from typing import Iterable, Iterator, TypeVar

from tqdm import tqdm

Item = TypeVar('Item')

LINE_S = 10.0  # between the lines in a log


def progress(items: Iterable[Item], title: str, count: int | None = None) -> Iterator[Item]:
    """Iterate over items, and tell on stderr how many of them are done.

    ``count``: how many there are, where ``len`` does not say.
    """
    count = length_hint(items) if count is None else count
    if sys.stderr.isatty():
        yield from tqdm(items, title, count, leave=False, dynamic_ncols=True)
        return
    began = said = time.monotonic()
    for number, item in enumerate(items, start=1):
        yield item
        if time.monotonic() - said > LINE_S and number < count:
            said = time.monotonic()
            print('%s: %d of %d' % (title, number, count), file=sys.stderr, flush=True)
    if time.monotonic() - began > LINE_S:
        print('%s: all %d done' % (title, count), file=sys.stderr, flush=True)


def tell(line: str) -> None:
    """Print a line on stdout, above the bar if there is one."""
    tqdm.write(line)
    sys.stdout.flush()
