"""Test whether the package withstands what a real robot does to it, and worse."""
import argparse
import importlib
import subprocess
import sys
from collections import namedtuple

import aruco_program  # noqa: F401  before NumPy and OpenCV
from rig.processes.record import recorded

Part = namedtuple('Part', 'module description')
PARTS = {
    'messages': Part('hostile_input.messages',
                     'hostile Image and CompressedImage messages for every image node'),
    'scenes': Part('hostile_input.scenes', 'hostile frames for what finds tags, areas, and poses'),
    'fuzzing': Part('hostile_input.fuzzing',
                    'coverage-guided fuzzing of what reads messages, pictures, and YAML'),
    'parameters': Part('hostile_input.parameters',
                       'wrong and extreme values of every parameter of every node'),
    'faults': Part('stress.faults',
                   'cameras, masters, listeners, disks, and nodes that die, stall, or fill up'),
    'load': Part('stress.load', 'all nodes at once, with cameras that are fast, large, or slow'),
    'endurance': Part('stress.endurance', 'memory, threads, file descriptors, and latency over time'),
    'page': Part('hostile_input.page_clients',
                 'the page with hostile clients, and the sockets that are open to the network'),
}


def parse():
    parser = argparse.ArgumentParser(
        prog='script/torture', description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog='Parts:\n' + '\n'.join(
            '  %-12s %s' % (name, part.description) for name, part in PARTS.items()))
    parser.add_argument('--only', choices=PARTS, metavar='PART', help='run only this part')
    parser.add_argument('--hours', type=float, metavar='N', help='run this long, shared evenly by the parts')
    parser.add_argument('--seed', type=int, default=1, help='the seed of the random choices (default: 1)')
    parser.add_argument('--record', action='store_true',
                        help='also write the output to docs/results/, for the documentation')
    args = parser.parse_args()
    if args.hours is not None and not args.hours > 0:
        parser.error('--hours must be above 0, not %g' % args.hours)
    return args


def main():
    args = parse()
    if args.only:
        sys.exit(run_part(args.only, args.hours and 3600 * args.hours, args.seed, args.record))
    # Each part runs in its own process, since a process can be a ROS node only once.
    options = ['--hours', str(args.hours / len(PARTS))] if args.hours else []
    options += ['--record'] * args.record
    found = [part for part in PARTS if subprocess.call(
        [sys.executable, '-m', 'torture', '--only', part, '--seed', str(args.seed), *options])]
    print('\n' + ('Something was found in: ' + ', '.join(found) if found else
                  'All parts are done. Nothing was found.'))
    sys.exit(len(found) > 0)


def run_part(part, seconds, seed, record):
    """Run one part, and print what it found. Returns whether it found anything."""
    print('\n%s: %s\n' % (part, PARTS[part].description), flush=True)
    with recorded('torture_' + part, record):
        found = importlib.import_module('torture.' + PARTS[part].module).run(seconds, seed)
        print('\n%s: %s' % (part, '\n'.join(['this was found:', *found]) if found else 'nothing was found.'),
              flush=True)
    return len(found) > 0


if __name__ == '__main__':
    main()
