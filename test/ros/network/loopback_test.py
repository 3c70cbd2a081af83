#!/usr/bin/env python3
"""All that script/demo starts can only be reached from this machine, even nodes in C++."""
import ipaddress
import os
import shutil
import tempfile
import unittest

import rostest
from aruco_ar.base.files import package_folder
from rig.nodes.topics import until
from rig.processes.sockets import sockets_below
from rig.processes.started import Started

LISTENING = {  # the number of TCP sockets: a node has one for XML-RPC and one for its topics
    **{'exercise5_%d' % number: 2 for number in range(2, 7)}, 'wall_camera': 2, 'page': 3, 'rosout': 2,
    **{'save_exercise5_%d' % number: 2 for number in range(2, 7)}, 'video_recorder': 2,
    'rosmaster': 1, 'roslaunch': 1}
SHELL = 'ROS_HOSTNAME', 'ROS_IP', 'ROS_MASTER_URI', 'LD_PRELOAD'  # the variables that script/env looks at


class Loopback(unittest.TestCase):
    def test_all_that_the_demo_starts_can_only_be_reached_from_this_machine(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        script = os.path.join(package_folder(), 'script', 'demo')
        demo = Started('env', *(word for name in SHELL for word in ('-u', name)),
                       script, '--record', '--forever', '--folder', folder)
        self.addCleanup(demo.stop)

        def complete():
            found = sockets_below(demo.process.pid)
            return all(sum(tcp for tcp, _ in found.get(name, [])) >= count
                       for name, count in LISTENING.items()) and found
        found = until(complete)
        for name, addresses in found.items():
            for _, address in addresses:
                self.assertTrue(ipaddress.ip_address(address).is_loopback, '%s listens on %s' % (name, address))
        self.assertTrue(any(not tcp for tcp, _ in found['rosout']))  # sockets of UDP are checked, too


if __name__ == '__main__':
    rostest.rosrun('unit5', 'loopback_test', Loopback)
