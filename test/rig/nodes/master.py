"""A private roscore, and the processor time of processes."""
import os
import subprocess
import time

import psutil
import rosgraph
import rospy

from rig.page.server import free_port


def processor_seconds(pid):
    """The seconds of processor time that a process has used so far."""
    times = psutil.Process(pid).cpu_times()
    return times.user + times.system


class Master:
    """A private roscore while the block runs. This process is a node of it, as camera and as subscriber."""

    def __enter__(self):
        port = free_port()
        os.environ['ROS_MASTER_URI'] = 'http://localhost:%d' % port
        self._core = subprocess.Popen(['roscore', '-p', str(port)], stdout=subprocess.DEVNULL)
        while not rosgraph.is_master_online():
            time.sleep(0.1)
        rospy.init_node('bench', disable_signals=True)
        return self

    def __exit__(self, *_):
        rospy.signal_shutdown('done')
        self._core.terminate()
        self._core.wait()
