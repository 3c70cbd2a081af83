"""Files are written completely or not at all."""
import errno
import glob
import os
import random
import signal
import subprocess
import sys
import tempfile
import time

import pytest
from aruco_ar import InputError
from aruco_ar.base.files import in_package, write_whole

WRITING = '''
import sys
from aruco_ar.base.files import write_whole
print('begins', flush=True)
while True:
    write_whole(sys.argv[1] + '/new/file', bytes(1 << 25))
'''


@pytest.mark.long
def test_a_killed_writer_leaves_no_incomplete_file():
    at_random = random.Random(6)
    for _ in range(6):
        with tempfile.TemporaryDirectory(dir='/dev/shm') as folder:
            with subprocess.Popen([sys.executable, '-c', WRITING, folder], stdout=subprocess.PIPE) as writing:
                assert writing.stdout.readline() == b'begins\n'
                time.sleep(at_random.uniform(0, 0.05))
                writing.send_signal(signal.SIGKILL)
            # There may be a second one, which was about to replace the first.
            for path in glob.glob(folder + '/new/.*') + glob.glob(folder + '/new/*'):
                assert os.path.getsize(path) == 1 << 25


@pytest.mark.parametrize('has_nameless', [True, False])
def test_a_file_is_replaced_or_stays_as_it_was(tmp_path, monkeypatch, has_nameless):
    if not has_nameless:
        def without_nameless(path, flags, *others, before=os.open):
            if flags & os.O_TMPFILE == os.O_TMPFILE:
                raise OSError(errno.EOPNOTSUPP, 'Operation not supported')
            return before(path, flags, *others)
        monkeypatch.setattr(os, 'open', without_nameless)
    path = tmp_path / 'made' / 'for' / 'it.txt'
    before = os.umask(0o027)
    try:
        for text in b'one', b'another':
            write_whole(str(path), text)
            assert path.read_bytes() == text and path.stat().st_mode & 0o777 == 0o640
    finally:
        os.umask(before)
    with pytest.raises(InputError, match='Cannot write ".*for": Is a directory. Choose another place'):
        write_whole(str(path.parent), b'a third')
    with pytest.raises(TypeError):
        write_whole(str(path), 'no bytes')
    assert [each.name for each in path.parent.iterdir()] == ['it.txt'] and path.read_bytes() == b'another'
    assert [each.name for each in path.parent.parent.iterdir()] == ['for']


def test_a_path_may_be_given_as_an_address():
    assert in_package('file:///home/me/my%20wall.png') == '/home/me/my wall.png'
    assert in_package('file:/home/me/wall.png') == '/home/me/wall.png'
    assert in_package('file://localhost/wall.png') == '/wall.png'
    for name in 'file:me', 'files/wall.png':  # these are names
        assert in_package(name).endswith('/' + name)
