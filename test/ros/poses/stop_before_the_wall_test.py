#!/usr/bin/env python3
"""The example in docs/howto/poses.md drives the simulated robot up to the wall."""
import os
import re
import tempfile
import unittest

import rospy
import rostest
from aruco_ar.base.files import package_folder
from aruco_ar.simulation.robot import CAMERA_FORWARD_M
from nav_msgs.msg import Odometry
from rig.nodes.topics import Inbox
from rig.processes.started import Started


class StopBeforeTheWall(unittest.TestCase):
    def test_the_camera_stops_one_meter_in_front_of_the_wall(self):
        with open(os.path.join(package_folder(), 'docs', 'howto', 'poses.md'), encoding='utf-8') as page:
            code = next(block for block in re.findall(r'```python\n(.*?)```', page.read(), re.DOTALL)
                        if 'stop_before_the_wall' in block)
        self.assertLessEqual(len([line for line in code.splitlines() if line.strip()]), 20)
        with tempfile.NamedTemporaryFile('w', suffix='.py') as script:
            script.write(code)
            script.flush()
            odometry = Inbox('/odom', Odometry)
            while -odometry.next().pose.pose.position.x <= 2:
                pass  # until it is told where to drive, the simulated robot drives to the wall and back
            driver = Started('python3', script.name)
            try:
                distances, speed = [], None
                # The simulated camera looks along x, and the wall is in the plane x = 0.
                # On a busy machine it may stand still on its way, until the next command comes.
                while speed is None or speed > 0.005 or distances[-1] > 1.02:
                    message = odometry.next()
                    distances.append(-message.pose.pose.position.x - CAMERA_FORWARD_M)
                    speed = abs(message.twist.twist.linear.x)
            finally:
                driver.stop()
        self.assertGreater(min(distances), 0.98)


if __name__ == '__main__':
    rospy.init_node('stop_before_the_wall_test')
    rostest.rosrun('unit5', 'stop_before_the_wall_test', StopBeforeTheWall)
