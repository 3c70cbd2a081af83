"""All nodes at 30 Hz for long: what they take of the machine, and how late they are, over time."""
import time

import numpy as np
from aruco_ar.base.progress import progress
from benchmark.ros.master import Master

from .ages import ALL, Ages, camera, first_of, nodes

SECONDS = 180.0
EVERY_S = 2.0
BEGIN = 0.5      # of the time goes by before it counts: caches fill, walls are learned, buffers grow once
MAX_GROWTH = 0.02  # of the memory, from the first half of what counts to the second
MAX_DRIFT_S = 0.005  # of the median latency, likewise


def run(seconds, seed):
    """Print memory, threads, descriptors and latency of every node, and how they change."""
    seconds = seconds or SECONDS
    with Master(), nodes(ALL) as (running, viewer), camera():
        topics = {name: '/%s/tags' % name for name in ALL}
        first_of(topics.values())
        listening = {name: Ages(topic) for name, topic in topics.items()}
        samples = {name: [] for name in running}
        began = time.time()
        for number in progress(range(int(seconds / EVERY_S)), 'endurance'):
            time.sleep(max(0, began + (number + 1) * EVERY_S - time.time()))
            for name, process in running.items():
                with process.oneshot():
                    samples[name].append((time.time(), process.memory_info().rss / 1e6, process.num_threads(),
                                          process.num_fds()))
        taken = {name: each.stop() for name, each in listening.items()}
        found = [] if viewer.shown and not viewer.fault else ['The page has shown %d frames; %s' % (
            viewer.shown, viewer.fault)]
    print('%.1f minutes at 30 Hz; the first %d %% do not count. Slopes are those of straight lines, an hour.\n'
          % (seconds / 60, 100 * BEGIN))
    print('%-12s %8s %10s %10s %12s %10s %9s %9s %10s' % (
        'node', 'MB', 'MB/h', '2nd half', 'threads', 'files', 'median', '99 % ms', 'ms/h'))
    for name in running:
        found += tell(name, np.array(samples[name]), taken.get(name), began + BEGIN * seconds, began + seconds)
    return found


def tell(name, samples, taken, begin, end):
    """Print what became of a node between two times; a list of what was found."""
    found = []
    counts = samples[samples[:, 0] >= begin]
    halves = np.array_split(counts, 2)
    growth = np.median(halves[1][:, 1]) / np.median(halves[0][:, 1]) - 1
    if growth > MAX_GROWTH:
        found.append('%s has grown by %.1f %%' % (name, 100 * growth))
    for column, what in (2, 'threads'), (3, 'files'):
        if halves[1][:, column].min() > halves[0][:, column].max():
            found.append('%s has ever more %s' % (name, what))
    line = '%-12s %8.1f %+10.2f %+8.2f %% %5d to %-4d %4d to %-4d' % (
        name, counts[-1, 1], slope(counts[:, :2]), 100 * growth, counts[:, 2].min(), counts[:, 2].max(),
        counts[:, 3].min(), counts[:, 3].max())
    if taken is not None:
        late = taken[taken[:, 0] >= begin] * (1, 1000)
        first, second = (np.median(half[:, 1]) for half in np.array_split(late, 2))
        if second - first > 1000 * MAX_DRIFT_S:
            found.append('%s has become later by %.1f ms' % (name, second - first))
        line += ' %9.1f %9.1f %+10.2f' % (*np.percentile(late[:, 1], (50, 99)), slope(late))
    print(line)
    return found


def slope(samples):
    """Of a straight line through (seconds, value), an hour."""
    return 3600 * np.polyfit(samples[:, 0] - samples[0, 0], samples[:, 1], 1)[0]
