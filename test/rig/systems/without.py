"""What a system other than Linux lacks is taken away from Python, when this is its sitecustomize."""
import builtins
import faulthandler
import importlib
import os
import shutil
import signal
import subprocess
import sys

HERE = os.path.abspath(__file__)
LACKING = {os: ['O_TMPFILE', 'O_NONBLOCK', 'O_CLOEXEC', 'killpg', 'waitid', 'getuid', 'fork'],
           signal: ['pthread_sigmask', 'SIGKILL', 'SIGUSR1', 'SIGHUP'], faulthandler: ['register']}
KILL = signal.SIGKILL if hasattr(signal, 'SIGKILL') else None


def without_proc(function):
    """The function, for which there is nothing in /proc."""
    def wrapped(path, *arguments, **named):
        if str(path).startswith('/proc'):
            raise FileNotFoundError(path)
        return function(path, *arguments, **named)
    return wrapped


def install(folder):
    """Make the environment's PYTHONPATH of a Python without these, in a folder."""
    shutil.copyfile(HERE, os.path.join(folder, 'sitecustomize.py'))
    return folder


if __name__ == 'sitecustomize':
    # Python's own rmtree looks at this when it is imported, and needs O_NONBLOCK if files can be opened so.
    os.supports_dir_fd.discard(os.open)
    importlib.reload(shutil)
    for module, names in LACKING.items():
        for name in names:
            delattr(module, name)
    for name in 'fcntl', 'resource', 'pwd', 'grp', 'termios':
        sys.modules[name] = None  # importing it fails
    # Python's own kill needs SIGKILL by its name; on Windows, it has another one.
    subprocess.Popen.kill = lambda process: process.send_signal(KILL)
    builtins.open = without_proc(open)
    os.stat = without_proc(os.stat)
