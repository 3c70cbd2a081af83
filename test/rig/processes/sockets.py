"""The sockets at which processes wait for connections and packets."""
import os
from contextlib import suppress

import psutil


def name_of(process):
    """The node's or the program's name, or None for a process that does not belong to ROS."""
    words = process.cmdline()
    for word in words:
        if word.startswith('__name:='):
            return word[len('__name:='):]
    programs = {os.path.basename(word) for word in words[:2]} & {'rosmaster', 'roscore', 'roslaunch', 'page.py'}
    return programs.pop() if programs else None


def sockets_of(process):
    """[(is_tcp, address)] of the sockets that receive from anywhere."""
    # psutil 6 renamed this method.
    ask = process.net_connections if hasattr(process, 'net_connections') else process.connections
    return [(each.status == psutil.CONN_LISTEN, each.laddr.ip) for each in ask('inet')
            if each.status == psutil.CONN_LISTEN or (each.status == psutil.CONN_NONE and each.laddr)]


def sockets_below(pid):
    """{name: [(is_tcp, address)]} of all descendants of a process."""
    found = {}
    for process in psutil.Process(pid).children(recursive=True):
        with suppress(psutil.NoSuchProcess):  # a short command of the script, which has ended
            found.setdefault(name_of(process), []).extend(sockets_of(process))
    return found
