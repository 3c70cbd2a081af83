#!/usr/bin/env python3
"""A cluster of two hosts processes bags with exactly the same results as one process."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import rostest
from aruco_ar.base.files import package_folder
from rig.network.hosts import BASE_ADDRESS, enter_or_skip, hosts
from rig.processes.started import Started, program, stop_all

PACKAGE = package_folder()
BAGS = [os.path.join(PACKAGE, 'test', 'bags', name) for name in ('drive_compressed.bag', 'drive_raw.bag')]
SCHEDULER = 'tcp://%s:8786' % BASE_ADDRESS
LONG_S = 900


class Cluster(unittest.TestCase):
    def test_two_hosts_give_the_same_results_as_one_process(self):
        one, two = tempfile.mkdtemp(), tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, one)
        self.addCleanup(shutil.rmtree, two)
        (base, *others), _ = enter_or_skip(self, hosts(2))
        running = [Started(*base.command('dask', 'scheduler', '--host', BASE_ADDRESS, '--no-dashboard'))]
        self.addCleanup(stop_all, running)
        running[0].wait_for('Scheduler at')
        for host in others:
            running.append(Started(*host.command(
                'dask', 'worker', SCHEDULER, '--nthreads', '1', '--no-dashboard', '--host', host.address)))
            running[-1].wait_for('Registered to')
        self.assertIn('2 workers', annotated(base.command(), two, '--scheduler', SCHEDULER))
        self.assertIn('1 worker', annotated([], one, '--workers', '1'))
        for name in [os.path.basename(bag) for bag in BAGS] + ['tags.csv']:
            with open(os.path.join(one, name), 'rb') as alone, open(os.path.join(two, name), 'rb') as together:
                self.assertEqual(alone.read(), together.read(), name)


def annotated(start, folder, *arguments):
    """Run annotate_bags by a command that ``start`` begins; returns its output."""
    return subprocess.run(
        [*start, sys.executable, program('annotate_bags.py'), *BAGS, '--out', folder,
         '--piece', '2', *arguments], stdout=subprocess.PIPE, text=True, check=True, timeout=LONG_S).stdout


if __name__ == '__main__':
    rostest.rosrun('unit5', 'cluster', Cluster)
