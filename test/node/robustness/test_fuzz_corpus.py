"""Replays the corpus of fuzzing, with which script/torture --only fuzzing begins."""
import os

import pytest
from fuzz.targets import TARGETS


@pytest.mark.filterwarnings('ignore:::PIL')  # the package's programs ignore them too, but not within pytest
@pytest.mark.parametrize('target', TARGETS)
def test_no_file_of_the_corpus_causes_a_fault(package, target):
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
