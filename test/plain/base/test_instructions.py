"""How many instructions a tracked second and each kernel in C take: nothing else shows that one became slower.

A change on purpose is recorded by `python3 -m rig.instructions.counting` in the folder test.
"""
import shutil

import pytest
from rig.instructions.counting import count, machine, recorded

MOST = 0.03  # change, as a share


@pytest.mark.long
@pytest.mark.skipif(shutil.which('valgrind') is None, reason='there is no valgrind')
def test_nothing_takes_more_instructions_than_recorded(tmp_path):
    if machine() not in recorded():
        pytest.skip('no numbers are recorded for %s' % machine())
    counted, before = count(str(tmp_path)), recorded()[machine()]
    changes = {name: round(counted.get(name, 0) / before.get(name, 1) - 1, 3)
               for name in {*counted, *before}}
    assert all(abs(change) < MOST for change in changes.values()), changes
