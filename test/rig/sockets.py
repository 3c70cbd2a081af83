"""The sockets on which processes wait for others."""
import os
from contextlib import suppress

import psutil


def name_of(process):
    """The node's name, or its program's; None for what is no part of ROS."""
    words = process.cmdline()
    for word in words:
        if word.startswith('__name:='):
            return word[len('__name:='):]
    programs = {os.path.basename(word) for word in words[:2]} & {'rosmaster', 'roscore', 'roslaunch', 'page.py'}
    return programs.pop() if programs else None


def sockets_of(process):
    """[(whether it is of TCP, address)] of what comes in, from wherever."""
    # Its name, and that before psutil 6.
    ask = process.net_connections if hasattr(process, 'net_connections') else process.connections
    return [(each.status == psutil.CONN_LISTEN, each.laddr.ip) for each in ask('inet')
            if each.status == psutil.CONN_LISTEN or (each.status == psutil.CONN_NONE and each.laddr)]


def sockets_below(pid):
    """{name: [(whether it is of TCP, address)]} of all that a process has started."""
    found = {}
    for process in psutil.Process(pid).children(recursive=True):
        with suppress(psutil.NoSuchProcess):  # one of the script's own little commands, which has ended
            found.setdefault(name_of(process), []).extend(sockets_of(process))
    return found
