"""A roscore of its own, and what processes take."""
import os
import subprocess
import time

import psutil
import rosgraph
import rospy
from rig.page.server import free_port


def processor_seconds(pid):
    """The processor time that a process has taken up so far."""
    times = psutil.Process(pid).cpu_times()
    return times.user + times.system


class Master:
    """A roscore of its own, in which this process is the camera and the listener."""

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
