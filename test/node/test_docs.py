"""The documentation: Sphinx builds it without a warning, and what README and docs/ link to is there."""
import glob
import importlib.util
import os
import re
import subprocess
import sys

import pytest

LINK = re.compile(r'\]\(([^)#\s]*)(?:#[^)\s]*)?\)')


def test_sphinx_has_nothing_to_say(package, tmp_path):
    if importlib.util.find_spec('myst_parser') is None:
        pytest.skip('no myst_parser')
    clean = {key: value for key, value in os.environ.items() if key not in ('PYTHONDEVMODE', 'PYTHONWARNINGS')}
    done = subprocess.run([sys.executable, '-W', 'ignore', '-m', 'sphinx', '-q', '-W', '--keep-going', '-d',
                           str(tmp_path / 'doctrees'), 'docs', str(tmp_path / 'html')], cwd=package, env=clean,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    assert (tmp_path / 'html' / 'index.html').is_file()


def test_every_file_that_is_linked_to_is_there(package):
    for page in [package + '/README.md', *glob.glob(package + '/docs/**/*.md', recursive=True)]:
        with open(page, encoding='utf-8') as file:
            targets = {target for target in LINK.findall(file.read()) if target and '://' not in target}
        for target in targets:
            assert os.path.isfile(os.path.join(os.path.dirname(page), target)), '%s: %s' % (page, target)
