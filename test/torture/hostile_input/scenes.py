"""Hostile frames for the code that finds tags, areas, and poses. None of them may lead to a wrong result.

A sequence depends only on the seed and on its own number. To look at one again,
call ``watch(seed, number)`` of test/hostile/pictures/pipeline.py.
"""
import faulthandler
import os
import re
import time
from collections import defaultdict
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

import cv2
import numpy as np
from aruco_ar import Detector
from aruco_ar.tags.detector import SEARCHES
from hostile.pictures import scenes
from hostile.pictures.pipeline import PICTURES_EACH, watch

FRAMES = 100000
EXTRA = 1.01             # times as many sequences, since some are shorter
CHUNK = 10               # sequences in one job
MAX_S = 300              # for one sequence; after that, the process counts as stuck
SLOW_SIZE = 1280, 720


def run(seconds, seed):
    """Process FRAMES frames, or those of ``seconds`` if given, on all cores. Returns what was found."""
    rows, faults, first, began = defaultdict(list), defaultdict(list), 0, time.monotonic()
    last, end = (np.inf, began + seconds) if seconds else (EXTRA * FRAMES / PICTURES_EACH, np.inf)
    workers = os.cpu_count()
    with ProcessPoolExecutor(workers, initializer=cv2.setNumThreads, initargs=(1,)) as pool:
        waiting = {}
        try:
            while waiting or first == 0:
                while first < last and time.monotonic() < end and len(waiting) < workers + 1:
                    waiting[pool.submit(_watch_all, seed, range(first, first + CHUNK))] = first
                    first += CHUNK
                for done in wait(waiting, return_when=FIRST_COMPLETED)[0]:
                    del waiting[done]
                    for kind, number, found, cpu, sentences in done.result():
                        rows[kind].append((cpu, number, *found))
                        for sentence in sentences:
                            same = re.sub(r'[-+\d.]+(e[-+]\d+)?', '#', sentence)[:80]
                            faults[same].append((kind, number, sentence))
        except BrokenProcessPool:
            faults['end'].append(('any', min(waiting.values()), 'a process died, or took %d s, in one of '
                                  'the %d sequences from here on' % (MAX_S, CHUNK * (workers + 1))))
    _print_table(rows, faults, seed, time.monotonic() - began)
    _print_slow_kinds(seed)
    return ['%d frames, the first of kind %s in sequence %d of seed %d: %s' % (
        len(these), *these[0][:2], seed, these[0][2]) for these in faults.values()]


def _watch_all(seed, numbers):
    """What ``watch`` returns for each frame of these sequences, and the number of its sequence."""
    rows = []
    for number in numbers:
        faulthandler.dump_traceback_later(MAX_S, exit=True)
        rows += [(kind, number, found, cpu, faults) for kind, found, cpu, faults in watch(seed, number)]
    faulthandler.cancel_dump_traceback_later()
    return rows


def _print_table(rows, faults, seed, seconds):
    every = [row for these in rows.values() for row in these]
    print('Seed %d: %d frames in %.0f s.\n' % (seed, len(every), seconds))
    print('%-14s %8s %8s %8s %8s %8s %7s %10s' % (
        'kind', 'frames', 'tags', 'areas', 'poses', 'cameras', 'found', 'median, ms'))
    for kind, these in sorted(rows.items()):
        found = sum(fault[0] == kind for group in faults.values() for fault in group)
        print('%-14s %8d %8d %8d %8d %8d %7d %10.1f' % (
            kind, len(these), *np.sum([row[2:] for row in these], axis=0), found,
            1000 * np.median([row[0] for row in these])))
    found = sum(map(len, faults.values()))
    print('%-14s %8d %8d %8d %8d %8d %7d %10.1f' % (
        'all', len(every), *np.sum([row[2:] for row in every], axis=0), found,
        1000 * np.median([row[0] for row in every])))
    slowest, middle = max(every), np.median([row[0] for row in every])
    print('\nFound (target: 0): %d. The slowest frame took %.2f s, %.0f times the median, in sequence %d.'
          % (found, slowest[0], slowest[0] / middle, slowest[1]))


def _print_slow_kinds(seed):
    """Print how long each search takes for a large frame of each of the slowest kinds."""
    cv2.setNumThreads(1)
    print('\nSeconds to search %d x %d pixels, one thread: %s' % (*SLOW_SIZE, ', '.join(SEARCHES)))
    for kind in 'noise', 'false_tags', 'checkerboard', 'tiny', 'hundreds':
        canvas = np.full(SLOW_SIZE[::-1], 200, np.uint8)
        scenes.KINDS[kind](canvas, np.random.RandomState(seed), 'DICT_6X6_250')
        took = []
        for search in SEARCHES:
            began = time.process_time()
            Detector(search=search).detect(canvas)
            took.append('%.2f' % (time.process_time() - began))
        print('%-14s %s' % (kind, ', '.join(took)))
