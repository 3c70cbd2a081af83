"""Telling how far long work is: a bar on a terminal, plain lines in a log."""
import sys
import time

from tqdm import tqdm

LINE_S = 10.0  # between the lines in a log


def progress(items, title, count=None):
    """Iterate over items, and tell on stderr how many of them are done.

    ``count``: how many there are, where ``len`` does not say.
    """
    count = len(items) if count is None else count
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


def tell(line):
    """Print a line on stdout, above the bar if there is one."""
    tqdm.write(line)
    sys.stdout.flush()
