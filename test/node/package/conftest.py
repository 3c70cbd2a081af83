import os
import subprocess

import pytest


@pytest.fixture(scope='session')
def wheels(package, tmp_path_factory):
    """The folder of the wheels that script/wheels makes of this package; of Windows, if it was made before."""
    folder = tmp_path_factory.mktemp('wheels')
    done = subprocess.run(
        [package + '/script/wheels', '--quick', '--into', str(folder)],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        text=True, env={**os.environ, 'SOURCE_DATE_EPOCH': '1700000000'})
    if 'Is there a network?' in done.stdout:
        pytest.skip('pip cannot get Zig')
    assert done.returncode == 0, done.stdout
    return folder
