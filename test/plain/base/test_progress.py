"""Long work tells how far it is: a bar on a terminal, plain lines in a log."""
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
clock = itertools.count(step=float(sys.argv[1]))  # seconds for each look at it
progress.time.monotonic = lambda: next(clock)
for item in progress.progress(range(6), 'pages'):
    if item == 2:
        progress.tell('a line')
'''


def in_a_log(seconds):
    return subprocess.run([sys.executable, '-c', WORK, seconds], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=True, text=True).stdout


def test_in_a_log_it_is_plain_lines_and_for_short_work_none():
    assert in_a_log('0.1') == 'a line\n'
    lines = in_a_log('6').splitlines()
    assert 'a line' in lines and lines[-1] == 'pages: all 6 done'
    assert 'pages: 2 of 6' in lines and not any('\r' in line for line in lines)


def test_on_a_terminal_it_is_a_bar_that_goes_away():
    here, there = pty.openpty()
    fcntl.ioctl(there, termios.TIOCSWINSZ, struct.pack('4H', 24, 80, 0, 0))
    with subprocess.Popen([sys.executable, '-c', WORK, '6'], stdout=there, stderr=there) as work:
        assert work.wait(30) == 0
    os.close(there)
    printed = b''
    try:
        while True:
            printed += os.read(here, 4096)
    except OSError:  # all is read
        pass
    os.close(here)
    printed = printed.decode()
    assert 'pages:   0%|' in printed and 'a line\r\n' in printed and ' of 6' not in printed
