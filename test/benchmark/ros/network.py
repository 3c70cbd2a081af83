"""Robots and a base station with a poor network in between: frame rate, data rate, and latency."""
import numpy as np
from rig.network.fleet import frames_seen, observe, running_fleet
from rig.network.hosts import DELAY_S, LOSS, RATE
from rig.nodes.topics import until

SECONDS = 15.0
CASES = [  # robots, name, arguments of robot.launch, arguments of base_station.launch
    (1, 'raw', [], ['camera:=camera/rgb/image_raw', 'transport:=raw']),
    (1, 'JPEG 95', ['quality:=95'], []), (1, 'JPEG 80', ['quality:=80'], []),
    (1, 'JPEG 50', ['quality:=50'], []), (1, 'JPEG 80, 10 Hz', ['quality:=80', 'rate:=10'], []),
    (3, 'JPEG 80', ['quality:=80'], []), (3, 'JPEG 50', ['quality:=50'], []),
    (3, 'JPEG 80, 10 Hz', ['quality:=80', 'rate:=10'], [])]


def run():
    """Measure all CASES, and print the table."""
    print('\nA base station and robots, with %s and %d ms each way for each robot, 640 x 480 at 30 Hz' % (
        RATE, 1000 * DELAY_S))
    print('%-8s %-16s %6s %10s %10s %10s %12s %10s' % (
        'robots', 'frames', 'lost', 'frames/s', 'Mbit/s', 'kB/frame', 'median ms', '99 % ms'))
    for loss in 0, LOSS:
        for robots, name, robot_args, base_args in CASES:
            measure(robots, name, robot_args, base_args, loss)


def measure(robots, name, robot_args, base_args, loss):
    """Print a line of the table: the mean per robot."""
    with running_fleet(robots, robot_args, base_args, loss) as network:
        viewer = network.view('exercise5_6')
        until(lambda: len({topic for topic, *_ in frames_seen(viewer)}) == robots)
        observe(network, viewer, 5)  # for everything to settle
        seen, sent = observe(network, viewer, SECONDS)
    ages = 1000 * np.array([age for _, _, age, _ in seen])
    print('%-8d %-16s %4.0f %% %10.1f %10.2f %10.1f %12.0f %10.0f' % (
        robots, name, 100 * loss, len(seen) / SECONDS / robots, sent * 8e-6 / SECONDS / robots,
        sent / 1000 / len(seen), *np.percentile(ages, (50, 99))), flush=True)
