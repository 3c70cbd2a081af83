"""Measure the course's code and this package side by side, in one run."""
import argparse
import os
import sys
from contextlib import nullcontext

import aruco_program  # noqa: F401  before NumPy and OpenCV
from aruco_ar import InputError
from rig.nodes.master import Master
from rig.processes.record import recorded

from . import screen
from .false_tags import false_tags
from .looks import cost, looks, real_hidden
from .peers import compare
from .real_clips import clips, covered, other_walls, remembered, searches, video
from .report import chart
from .ros import bags, network, nodes, page
from .simulated import accuracy, painting, poses, search, speed

PARTS = {'sticking': accuracy.run, 'speed': speed.run, 'search': search.run, 'poses': poses.run,
         'painting': painting.run, 'looks': looks.run, 'nodes': nodes.run_load,
         'memory': nodes.run_memory, 'page': page.run, 'network': network.run, 'bags': bags.run,
         'screen': screen.run, 'false_tags': false_tags.run}
WITH_MASTER = 'nodes', 'memory', 'page'
OF_CLIPS = 'walls',  # the parts that need real clips


def parse():
    parser = argparse.ArgumentParser(
        prog='script/bench', description=__doc__ + ' Without arguments it takes about half an hour.')
    parser.add_argument('--only', choices=(*PARTS, *OF_CLIPS), help='run only this part')
    parser.add_argument('--real', metavar='FOLDER', nargs='?', const=clips.CLIPS,
                        help='compare both methods with the truth on real clips instead: the videos in a '
                        'folder. A NAME.yaml beside each of them gives its dictionary and ids (default: '
                        'the clips shared beside the package). With --only nodes, both run as nodes; '
                        'with --only looks, it is what foreground:=keep leaves free, how well tags are hidden, '
                        'and what the looks cost; with --only search, what '
                        'a search of one frame costs and finds; with --only walls, how often a wall that '
                        'is remembered is taken for another one.')
    parser.add_argument('--peers', metavar='FOLDER', nargs='*',
                        help='compare our detector with those of OpenCV and AprilTag instead, on the photos '
                        'and clips of these folders. A NAME.yaml beside each gives its dictionary and '
                        'all_ids, and a NAME.txt beside a photo its tags, one a line: id, then four '
                        'corners (default: what is '
                        'shared beside the package, and the simulation)')
    parser.add_argument('--video', metavar='FILE', help='compare both methods on a video instead')
    parser.add_argument('--ids', metavar='1,2,3,4', default=(),
                        type=lambda text: tuple(int(number) for number in text.split(',')),
                        help='the four tags of the video that span the area; with them, the video is also '
                        'compared with the truth where that is known')
    parser.add_argument('--dictionary', default='DICT_6X6_250',
                        help='the dictionary of the tags of the video, and of what has no NAME.yaml '
                        '(default: DICT_6X6_250)')
    parser.add_argument('--record', action='store_true',
                        help='also write the output to docs/results/, for the documentation')
    parser.add_argument('--chart', metavar='FILE.png', default='unit5-bench.png',
                        help='the file for the chart of error and jitter (default: unit5-bench.png)')
    return parser.parse_args()


def main():
    args = parse()
    if args.real and args.only == 'nodes':
        with Master(), recorded('real_nodes', args.record):
            nodes.run_clips(clips.clips_of(args.real))
        return
    if args.real and args.only == 'looks':
        with recorded('real_looks', args.record):
            looks.run_clips(clips.clips_of(args.real))
            looks.run_arm(clips.clips_of(args.real))
            real_hidden.run(args.real)
            cost.run_clips(clips.clips_of(args.real))
        return
    if args.real and args.only == 'search':
        with recorded('real_search', args.record):
            searches.run(clips.clips_of(args.real))
        return
    if args.real and args.only == 'walls':
        with recorded('real_walls', args.record):
            other_walls.run(clips.clips_of(args.real))
        return
    if args.peers is not None:
        with recorded('peers', args.record):
            compare.run(args.peers, args.dictionary)
        return
    if args.only in OF_CLIPS:
        raise InputError('The part "%s" needs --real.' % args.only)
    if args.real:
        with recorded('real', args.record):
            charts = clips.run(args.real, args.chart)
            remembered.run(clips.clips_of(args.real))
            covered.run(clips.clips_of(args.real))
        print('\nWrote %s' % ', '.join(charts))
        return
    if args.video:
        video.run(args.video, args.dictionary, args.ids, args.chart)
        return
    for part, run_part in PARTS.items():
        if args.only in (None, part):
            with Master() if part in WITH_MASTER else nullcontext(), recorded(part, args.record):
                print('%d processor cores' % os.cpu_count())
                series = run_part()
            if part == 'sticking':
                stamps, truth, course, ours = series
                chart.draw(args.chart, accuracy.CHART_CASE, stamps, course, ours, truth)
                print('\nWrote %s' % args.chart)


if __name__ == '__main__':
    try:
        main()
    except InputError as error:
        sys.exit('bench: %s' % error)
