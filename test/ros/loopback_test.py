#!/usr/bin/env python3
"""What script/demo starts listens to this machine alone, all of it, nodes in C++ as well."""
import ipaddress
import os
import shutil
import tempfile
import unittest

import psutil
import rostest
from aruco_ar.files import package_folder
from listening import until
from started import Started

NODES = ['exercise5_%d' % number for number in range(2, 7)] + ['wall_camera', 'page', 'rosout', 'video_recorder'] + [
    'save_exercise5_%d' % number for number in range(2, 7)]
LISTENING = {**{name: 2 for name in NODES},  # its XML-RPC server, and that of its topics
             'page': 3, 'master': 1, 'roslaunch': 1}
SHELL = 'ROS_HOSTNAME', 'ROS_IP', 'ROS_MASTER_URI', 'LD_PRELOAD'  # what script/env looks at, of a shell without it


def name_of(process):
    """The node's name, or what else it is; None for what is no part of ROS."""
    words = process.cmdline()
    named = [word[len('__name:='):] for word in words if word.startswith('__name:=')]
    program = [name for name in ('rosmaster', 'roslaunch') if any(word.endswith('/' + name) for word in words[:2])]
    return (named + [name.replace('rosm', 'm') for name in program] + [None])[0]


def sockets_of(process):
    """[(whether it is of TCP, address)] of what comes in, from wherever."""
    ask = process.net_connections if hasattr(process, 'net_connections') else process.connections  # before psutil 6
    return [(each.status == psutil.CONN_LISTEN, each.laddr.ip) for each in ask('inet')
            if each.status == psutil.CONN_LISTEN or each.status == psutil.CONN_NONE and each.laddr]


class Loopback(unittest.TestCase):
    def test_all_that_the_demo_starts_listens_to_this_machine_alone(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        demo = Started('env', *(word for name in SHELL for word in ('-u', name)),
                       os.path.join(package_folder(), 'script', 'demo'), '--record', '--forever', '--folder', folder)
        self.addCleanup(demo.stop)

        def sockets():
            found = {}
            for process in psutil.Process(demo.process.pid).children(recursive=True):
                try:
                    found.setdefault(name_of(process), []).extend(sockets_of(process))
                except psutil.NoSuchProcess:
                    continue  # it was one of the script's own little commands
            return found

        def complete():
            found = sockets()
            return all(sum(tcp for tcp, _ in found.get(name, [])) >= count for name, count in LISTENING.items()) and found
        found = until(complete, 60)
        for name, addresses in found.items():
            for _, address in addresses:
                self.assertTrue(ipaddress.ip_address(address).is_loopback, '%s listens on %s' % (name, address))
        self.assertTrue(any(not tcp for tcp, _ in found['rosout']))  # UDP has been looked at as well


if __name__ == '__main__':
    rostest.rosrun('unit5', 'loopback_test', Loopback)
