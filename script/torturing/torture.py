#!/usr/bin/env python3
"""Do to the package what a real robot does to it, and worse; print what it made of it."""
import argparse
import importlib
import os
import sys

import aruco_ar  # noqa: F401  before numpy is, which it gives one thread

HERE = os.path.dirname(os.path.abspath(__file__))
PARTS = {
    'messages': 'hostile Image and CompressedImage messages to every image node',
    'scenes': 'hostile pictures to what finds tags, areas and poses',
    'fuzzing': 'coverage-guided fuzzing of what reads messages, pictures and YAML',
    'parameters': 'wrong and extreme values of every parameter of every node',
    'faults': 'cameras, masters, listeners, disks and nodes that die, stall or fill up',
    'load': 'all nodes at once, cameras that are fast, large or slow',
    'endurance': 'memory, threads, file descriptors and latency over time',
    'door': 'the page against hostile clients, and what listens to the network',
}


def parse():
    parser = argparse.ArgumentParser(
        prog='script/torture', description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog='Parts:\n' + '\n'.join('  %-12s %s' % part for part in PARTS.items()))
    parser.add_argument('--only', choices=PARTS, metavar='PART', help='this part alone')
    parser.add_argument('--hours', type=float, metavar='N', help='go on for so long, evenly over the parts')
    parser.add_argument('--seed', type=int, default=1, help='of what is made at random (default: 1)')
    args = parser.parse_args()
    if args.hours is not None and not args.hours > 0:
        parser.error('--hours takes a number above 0, not %g' % args.hours)
    return args


def main():
    args = parse()
    tests = os.path.join(HERE, '..', '..', 'test')
    sys.path += [tests, os.path.join(tests, 'ros'), os.path.join(HERE, '..', 'benchmark')]
    parts = [args.only] if args.only else list(PARTS)
    seconds = args.hours and 3600 * args.hours / len(parts)
    found = []
    for part in parts:
        print('\n%s: %s\n' % (part, PARTS[part]), flush=True)
        found += ['%s: %s' % (part, fault) for fault in importlib.import_module(part).run(seconds, args.seed)]
    print('\n' + ('Found:\n' + '\n'.join(found) if found else 'Nothing was found.'))
    sys.exit(len(found) > 0)


if __name__ == '__main__':
    main()
