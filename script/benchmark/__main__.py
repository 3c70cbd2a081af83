"""Measure the course's code and ours, side by side, in one run."""
import argparse
import os
import sys
from contextlib import nullcontext

import aruco_program  # noqa: F401  before all else
from aruco_ar import InputError

from .real_clips import clips, video
from .report import chart
from .report.record import recorded
from .ros import bags, master, network, nodes, page
from .simulated import accuracy, poses, search, speed

PARTS = {'sticking': accuracy.run, 'speed': speed.run, 'search': search.run, 'poses': poses.run,
         'nodes': nodes.run_load, 'memory': nodes.run_memory, 'page': page.run, 'network': network.run,
         'bags': bags.run}
WITH_MASTER = 'nodes', 'memory', 'page'


def parse():
    parser = argparse.ArgumentParser(
        prog='script/bench', description=__doc__ + ' About half an hour without arguments.')
    parser.add_argument('--only', choices=PARTS, help='this part alone')
    parser.add_argument('--real', metavar='FOLDER', nargs='?', const=clips.CLIPS,
                        help='both methods on real clips instead, against the truth: the videos of a folder of '
                        'which NAME.yaml says dictionary and ids (default: those shared beside the package); '
                        'with --only nodes, from node to node')
    parser.add_argument('--video', metavar='FILE', help='both methods on a video instead')
    parser.add_argument('--ids', metavar='1,2,3,4', default=(),
                        type=lambda text: tuple(int(number) for number in text.split(',')),
                        help="the four of the video's tags that count; with them it is compared with the "
                        'truth, where it has one')
    parser.add_argument('--dictionary', default='DICT_6X6_250',
                        help="of the video's tags (default: DICT_6X6_250)")
    parser.add_argument('--record', action='store_true',
                        help='also write what is printed into docs/results/, for the documentation')
    parser.add_argument('--chart', metavar='FILE.png', default='unit5-bench.png',
                        help='where the chart of error and jitter goes (default: unit5-bench.png)')
    return parser.parse_args()


def main():
    args = parse()
    if args.real and args.only == 'nodes':
        with master.Master(), recorded('real_nodes', args.record):
            nodes.run_clips(clips.clips_of(args.real))
        return
    if args.real:
        with recorded('real', args.record):
            clips.run(args.real, args.chart)
        return
    if args.video:
        video.run(args.video, args.dictionary, args.ids, args.chart)
        return
    for part, work in PARTS.items():
        if args.only in (None, part):
            with master.Master() if part in WITH_MASTER else nullcontext(), recorded(part, args.record):
                print('%d processor cores' % os.cpu_count())
                found = work()
            if part == 'sticking':
                stamps, truth, course, ours = found
                chart.draw(args.chart, accuracy.CHART_CASE, stamps, course, ours, truth)
                print('\nWrote %s' % args.chart)


if __name__ == '__main__':
    try:
        main()
    except InputError as error:
        sys.exit('bench: %s' % error)
