"""All nodes at once on this machine, with cameras that are faster, larger, or slower than most."""
import numpy as np
from rig.nodes.master import Master

from .ages import ALL, camera, measure_ages, nodes, wait_for_all

SECONDS = 40.0
CASES = 4  # which share the time that is given
MAX_PERIODS = 2
MAX_GROWTH = 0.1  # seconds of latency per minute; more is not noise


def run(seconds, seed):
    """Print frame rates and ages for all cases. Returns sentences about what was found."""
    seconds = SECONDS if seconds is None else seconds / CASES
    found = []
    print('The age is from the stamp of a frame to the receipt of its ~tags, which a node publishes last.\n'
          'Frames older than two periods of the camera are old. ms/min is the growth of the age.\n')
    print('%-34s %-12s %8s %9s %9s %9s %6s %10s' % (
        'camera', 'node', 'frames/s', 'median ms', '99 % ms', 'max ms', 'old', 'ms/min'))
    with Master():
        for case in (dict(), dict(rate=120), dict(rate=1)):
            with nodes(ALL) as (_, viewer):
                found += measure(case, ALL, seconds)
                if viewer.fault or not viewer.shown:
                    found.append('The page has shown %d frames; %s' % (viewer.shown, viewer.fault))
        with nodes(['exercise5_6'], page=False):
            found += measure(dict(width=3840, height=2160), ['exercise5_6'], seconds)
    return found


def measure(case, names, seconds):
    """Print how nodes answer a camera for ``seconds``. Returns sentences about what was found."""
    settings = dict(dict(width=640, height=480, rate=30), **case)
    title = '%(width)d x %(height)d at %(rate)d Hz' % settings
    topics = {'/%s/tags' % name: name for name in names}
    with camera(**settings):
        wait_for_all(topics)
        measure_ages(topics, 3.0)  # until all have learned the wall, and the page shows it
        received = measure_ages(topics, seconds)
    found = []
    for topic, each in received.items():
        when, age = each.T
        if len(age) < 0.5 * seconds * min(settings['rate'], 1):
            found.append('%s, %s: only %d frames were answered within %d s'
                         % (title, topics[topic], len(age), seconds))
            continue
        old = np.count_nonzero(age > MAX_PERIODS / settings['rate'])
        growth = 60 * np.polyfit(when - when[0], age, 1)[0]
        print('%-34s %-12s %8.1f %9.1f %9.1f %9.1f %6d %+10.2f' % (
            title, topics[topic], len(age) / seconds, *(1000 * np.percentile(age, (50, 99, 100))), old,
            1000 * growth), flush=True)
        if old and settings == dict(width=640, height=480, rate=30):
            found.append('%s, %s: %d frames older than two periods were published'
                         % (title, topics[topic], old))
        if growth > MAX_GROWTH:
            found.append('%s, %s: the latency grows by %.0f ms per minute'
                         % (title, topics[topic], 1000 * growth))
    return found
