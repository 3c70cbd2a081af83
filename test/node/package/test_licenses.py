"""All that is shipped has a license: script/licenses says so."""
import os
import subprocess

import pytest


@pytest.mark.long
def test_all_files_and_all_python_packages_have_a_license_that_permits_their_use(package):
    if not os.path.exists(package + '/.git'):
        pytest.skip('what git ignores is not known here')
    if not os.path.exists(package + '/.venv/bin/pip-licenses'):
        pytest.skip('pip-licenses needs Python 3.10')
    done = subprocess.run(['script/licenses'], cwd=package, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True)
    assert done.returncode == 0, done.stdout
    assert 'tornado' in done.stdout
