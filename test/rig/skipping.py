"""Skipping a rostest: rosunit's results do not tell, so it is printed, where script/test finds it."""
from unittest import SkipTest


def skip(what, reason):
    """Skip the test, or the class of tests, of that name."""
    print('SKIPPED %s: %s' % (what, reason))
    raise SkipTest(reason)
