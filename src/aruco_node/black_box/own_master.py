"""A ROS master of one's own, so that a learner needs no roscore, and nothing that runs is disturbed."""
import os
from contextlib import contextmanager

from rosmaster.master import Master


@contextmanager
def own_master():
    """During the block, this process is a ROS master on a free port, and its environment names it.

    Only this machine can reach it.
    """
    os.environ['ROS_HOSTNAME'] = 'localhost'
    os.environ.pop('ROS_IP', None)
    master = Master(0)
    master.start()
    os.environ['ROS_MASTER_URI'] = master.uri
    try:
        yield
    finally:
        master.stop()
