"""All nodes at 30 Hz for a long time: their use of the machine, and their latency."""
import time

import numpy as np
from aruco_ar.base.progress import progress
from rig.nodes.master import Master

from .ages import ALL, Ages, camera, nodes, wait_for_all

SECONDS = 180.0
SAMPLE_S = 2.0
BEGIN = 0.5      # share of the time before the measurement: caches fill, walls are learned, buffers grow
MAX_GROWTH = 0.02  # of the memory, from the first half of the measurement to the second
MAX_DRIFT_S = 0.005  # of the median latency, likewise


def run(seconds, seed):
    """Print memory, threads, file descriptors, and latency of every node, and how they change.

    Returns sentences about what was found.
    """
    seconds = seconds or SECONDS
    with Master(), nodes(ALL) as (running, viewer), camera():
        topics = {name: '/%s/tags' % name for name in ALL}
        wait_for_all(topics.values())
        subscribed = {name: Ages(topic) for name, topic in topics.items()}
        samples = {name: [] for name in running}
        began = time.time()
        for number in progress(range(int(seconds / SAMPLE_S)), 'endurance'):
            time.sleep(max(0, began + (number + 1) * SAMPLE_S - time.time()))
            for name, process in running.items():
                with process.oneshot():
                    samples[name].append((time.time(), process.memory_info().rss / 1e6, process.num_threads(),
                                          process.num_fds()))
        received = {name: each.stop() for name, each in subscribed.items()}
        found = [] if viewer.shown and not viewer.fault else ['The page has shown %d frames; %s' % (
            viewer.shown, viewer.fault)]
    print('%.1f minutes at 30 Hz; the first %d %% do not count. Slopes are per hour, of a straight line.\n'
          % (seconds / 60, 100 * BEGIN))
    print('%-12s %8s %10s %10s %12s %10s %9s %9s %10s' % (
        'node', 'MB', 'MB/h', '2nd half', 'threads', 'files', 'median', '99 % ms', 'ms/h'))
    for name in running:
        found += report(name, np.array(samples[name]), received.get(name), began + BEGIN * seconds,
                        began + seconds)
    return found


def report(name, samples, received, begin, end):
    """Print how a node changed between two times. Returns sentences about what was found."""
    found = []
    counts = samples[samples[:, 0] >= begin]
    halves = np.array_split(counts, 2)
    growth = np.median(halves[1][:, 1]) / np.median(halves[0][:, 1]) - 1
    if growth > MAX_GROWTH:
        found.append('the memory of %s has grown by %.1f %%' % (name, 100 * growth))
    for column, what in (2, 'threads'), (3, 'files'):
        if halves[1][:, column].min() > halves[0][:, column].max():
            found.append('%s has more and more %s' % (name, what))
    line = '%-12s %8.1f %+10.2f %+8.2f %% %5d to %-4d %4d to %-4d' % (
        name, counts[-1, 1], slope(counts[:, :2]), 100 * growth, counts[:, 2].min(), counts[:, 2].max(),
        counts[:, 3].min(), counts[:, 3].max())
    if received is not None:
        latencies = received[received[:, 0] >= begin] * (1, 1000)
        first, second = (np.median(half[:, 1]) for half in np.array_split(latencies, 2))
        if second - first > 1000 * MAX_DRIFT_S:
            found.append('the latency of %s has grown by %.1f ms' % (name, second - first))
        line += ' %9.1f %9.1f %+10.2f' % (*np.percentile(latencies[:, 1], (50, 99)), slope(latencies))
    print(line)
    return found


def slope(samples):
    """The slope per hour of a straight line through rows of (seconds, value)."""
    return 3600 * np.polyfit(samples[:, 0] - samples[0, 0], samples[:, 1], 1)[0]
