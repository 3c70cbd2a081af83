"""Long tasks show their progress: as a bar on a terminal, as plain lines in a log."""
import fcntl
import os
import pty
import struct
import subprocess
import sys
import termios

WORK = '''
import itertools, sys
from aruco_ar.base import progress
clock = itertools.count(step=float(sys.argv[1]))  # seconds per call
progress.time.monotonic = lambda: next(clock)
for item in progress.progress(range(6), 'pages'):
    if item == 2:
        progress.tell('a line')
'''


def log_of(seconds):
    return subprocess.run([sys.executable, '-c', WORK, seconds], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=True, text=True).stdout


def test_a_log_gets_plain_lines_and_none_for_short_tasks():
    assert log_of('0.1') == 'a line\n'
    lines = log_of('6').splitlines()
    assert 'a line' in lines and lines[-1] == 'pages: all 6 done'
    assert 'pages: 2 of 6' in lines and not any('\r' in line for line in lines)


def test_a_terminal_gets_a_bar_that_disappears():
    here, there = pty.openpty()
    fcntl.ioctl(there, termios.TIOCSWINSZ, struct.pack('4H', 24, 80, 0, 0))
    with subprocess.Popen([sys.executable, '-c', WORK, '6'], stdout=there, stderr=there) as work:
        assert work.wait(30) == 0
    os.close(there)
    printed = b''
    try:
        while True:
            printed += os.read(here, 4096)
    except OSError:  # everything is read
        pass
    os.close(here)
    printed = printed.decode()
    assert 'pages:   0%|' in printed and 'a line\r\n' in printed and ' of 6' not in printed
