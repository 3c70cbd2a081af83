"""Robots and a base station with a poor network between: what it carries, how late what is painted comes."""

import numpy as np
from rig.network.fleet import frames_seen as views
from rig.network.fleet import observe as seconds_of
from rig.network.fleet import running_fleet as far
from rig.network.hosts import DELAY_S, LOSS, RATE
from rig.nodes.topics import until

SECONDS, BEGIN_S = 15.0, 60.0
CASES = [  # robots, how frames go through the network, and arguments of robot.launch and base_station.launch
    (1, 'raw', [], ['camera:=camera/rgb/image_raw', 'transport:=raw']),
    (1, 'JPEG 95', ['quality:=95'], []), (1, 'JPEG 80', ['quality:=80'], []),
    (1, 'JPEG 50', ['quality:=50'], []), (1, 'JPEG 80, 10 Hz', ['quality:=80', 'rate:=10'], []),
    (3, 'JPEG 80', ['quality:=80'], []), (3, 'JPEG 50', ['quality:=50'], []),
    (3, 'JPEG 80, 10 Hz', ['quality:=80', 'rate:=10'], [])]


def run():
    """Print frames a second, Mbit/s and latency."""
    print('\nA base station and robots, %s and %d ms each way to each robot, 640 x 480 at 30 Hz' % (
        RATE, 1000 * DELAY_S))
    print('%-8s %-16s %6s %10s %10s %10s %12s %10s' % (
        'robots', 'frames', 'lost', 'frames/s', 'Mbit/s', 'kB/frame', 'median ms', '99 % ms'))
    for loss in 0, LOSS:
        for robots, name, of_robots, of_base in CASES:
            measure(robots, name, of_robots, of_base, loss)


def measure(robots, name, of_robots, of_base, loss):
    """Print a line of the table: of each robot, on average."""
    with far(robots, of_robots, of_base, loss) as network:
        viewer = network.view('exercise5_6')
        until(lambda: len({topic for topic, *_ in views(viewer)}) == robots, BEGIN_S)
        seconds_of(network, viewer, 5)  # until all has settled
        seen, sent = seconds_of(network, viewer, SECONDS)
    ages = 1000 * np.array([age for _, _, age, _ in seen])
    print('%-8d %-16s %4.0f %% %10.1f %10.2f %10.1f %12.0f %10.0f' % (
        robots, name, 100 * loss, len(seen) / SECONDS / robots, sent * 8e-6 / SECONDS / robots,
        sent / 1000 / len(seen), *np.percentile(ages, (50, 99))), flush=True)
