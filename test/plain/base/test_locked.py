"""The Python packages that script/setup installs are locked: each version with its hashes."""
import os
import re

import pytest
from packaging.requirements import Requirement
from rig import PACKAGE

FILES = [('requirements.txt', 'run.txt'), ('test/requirements.txt', 'test.txt')]
PYTHONS = '3.8', '3.9', '3.10', '3.11', '3.12', '3.13'


def lines_of(path):
    """The lines of a file of requirements without comments, those that go on in one."""
    with open(os.path.join(PACKAGE, path)) as file:
        text = re.sub(r'(^|\s)#.*', '', file.read()).replace('\\\n', ' ')
    return [line.strip() for line in text.splitlines() if line.strip()]


def name_of(requirement):
    return requirement.name.lower().replace('_', '-')


def counts(requirement, python):
    """Whether a requirement is one for that Python, on a usual machine."""
    return requirement.marker is None or requirement.marker.evaluate({
        'python_version': python, 'python_full_version': python + '.1', 'sys_platform': 'linux',
        'platform_machine': 'x86_64', 'implementation_name': 'cpython',
        'platform_python_implementation': 'CPython'})


@pytest.mark.parametrize('wanted, locked', FILES)
def test_what_is_wanted_is_locked_for_each_python(wanted, locked):
    versions = [Requirement(line.partition(' --hash')[0]) for line in lines_of('script/locked/' + locked)]
    for line in lines_of(wanted):
        requirement = Requirement(line)
        for python in PYTHONS:
            if counts(requirement, python):
                found = [each for each in versions
                         if name_of(each) == name_of(requirement) and counts(each, python)]
                assert len(found) == 1, (line, python, 'run script/remake/locks')
                (version,) = found[0].specifier
                is_wanted = version.operator == '==' and requirement.specifier.contains(version.version)
                assert is_wanted, (line, python, 'run script/remake/locks')


@pytest.mark.parametrize('_, locked', FILES)
def test_all_that_is_locked_has_hashes(_, locked):
    for line in lines_of('script/locked/' + locked):
        assert re.search('--hash=sha256:[0-9a-f]{64}', line), line
