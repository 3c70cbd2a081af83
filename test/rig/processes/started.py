"""Processes under test."""
import os
import shutil
import signal
import subprocess
import threading

from rig import PACKAGE

# The deadline of all waits, seconds. A wait ends by an event; the deadline is only for what hangs. It is long,
# since a machine may be slow, or busy with other things.
WAIT_S = 180


class Started:
    """A running command whose output is read as it is printed."""

    def __init__(self, *command):
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                        start_new_session=True)
        self.lines, self._arrived = [], threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        with self.process.stdout as lines:
            for line in lines:
                with self._arrived:
                    self.lines.append(line)
                    self._arrived.notify_all()

    def wait_for(self, *words, after=0):
        """Wait for a line that contains all these words; returns it. The first ``after`` lines are skipped."""
        def found():
            return [line for line in self.lines[after:] if all(word in line for word in words)]
        with self._arrived:
            if not self._arrived.wait_for(found, WAIT_S):
                raise AssertionError('%s did not print %s, but: %s' % (self.process.args, words,
                                                                   ''.join(self.lines)))
            return found()[0]

    def ends(self):
        """Wait until the process ends; returns its exit code. All its output is in ``lines`` then."""
        code = self.process.wait(WAIT_S)
        self._reader.join(WAIT_S)
        return code

    def stop(self):
        stop_all([self])


def stop_all(commands):
    """Stop running commands, all at the same time."""
    running = [each.process for each in commands if each.process.poll() is None]
    for process in running:
        os.killpg(process.pid, signal.SIGINT)
    for process in running:
        process.wait(WAIT_S)


def program(name):
    """The path of a program of the package: the exercises are in src/, all others in nodes/."""
    return shutil.which(name, path='%s/src:%s/nodes' % (PACKAGE, PACKAGE))


def node(name, *arguments):
    """Start a node of the package; returns it as Started."""
    return Started('rosrun', 'unit5', name, *arguments)
