"""Skips rostests. The results of rosunit do not contain the reason, so it is printed for script/test."""
from unittest import SkipTest


def skip(what, reason):
    """Skip a test, or a class of tests, with that name."""
    print('SKIPPED %s: %s' % (what, reason))
    raise SkipTest(reason)
