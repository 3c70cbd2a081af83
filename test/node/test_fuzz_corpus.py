"""What fuzzing found worth keeping, once more: script/torture --only fuzzing begins with it."""
import os

import pytest
from fuzz.targets import TARGETS


@pytest.mark.filterwarnings('ignore:::PIL')  # the package does so, but not in pytest
@pytest.mark.parametrize('target', TARGETS)
def test_nothing_in_the_corpus_is_a_fault(package, target):
    folder = os.path.join(package, 'test', 'fuzz', 'corpus', target)
    names = sorted(os.listdir(folder))
    assert names
    for name in names:
        with open(os.path.join(folder, name), 'rb') as file:
            data = file.read()
        try:
            TARGETS[target](data)
        except Exception as error:
            raise AssertionError('%s of %s' % (name, target)) from error
