"""Showing the progress of long work: as a bar on a terminal, as plain lines in a log."""
from __future__ import annotations

import sys
import time
from operator import length_hint
from typing import Iterable, Iterator, TypeVar

from tqdm import tqdm

Item = TypeVar('Item')

LOG_INTERVAL_S = 10.0  # between the lines in a log


def progress(items: Iterable[Item], title: str, count: int | None = None) -> Iterator[Item]:
    """Iterate over items, and report on stderr how many of them are done.

    ``count``: how many items there are, if ``len`` cannot tell.
    """
    count = length_hint(items) if count is None else count
    if sys.stderr.isatty():
        yield from tqdm(items, title, count, leave=False, dynamic_ncols=True)
        return
    started = reported = time.monotonic()
    for number, item in enumerate(items, start=1):
        yield item
        if time.monotonic() - reported > LOG_INTERVAL_S and number < count:
            reported = time.monotonic()
            print('%s: %d of %d' % (title, number, count), file=sys.stderr, flush=True)
    if time.monotonic() - started > LOG_INTERVAL_S:
        print('%s: all %d done' % (title, count), file=sys.stderr, flush=True)


def tell(line: str) -> None:
    """Print a line on stdout, above the progress bar if there is one."""
    tqdm.write(line)
    sys.stdout.flush()
