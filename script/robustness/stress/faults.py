"""Disks that fill up, and programs that are ended at random moments."""
import os
import random
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import islice

import cv2
import numpy as np
from aruco_ar.base.progress import tell
from benchmark.ros.master import Master
from hostile import kills

COUNT, AT_A_TIME = 100, 3
DISK_BYTES, RECORDED_S = 16 << 20, '20'


def run(seconds, seed):
    """Fill disks, and kill; what was wrong then."""
    found = fill()
    with Master(), kills.camera():
        return found + kill(seconds, seed)


def fill():
    """Record with script/demo onto a disk that is too small."""
    with tempfile.TemporaryDirectory() as folder:
        if subprocess.call(['mount', '-t', 'tmpfs', '-o', 'size=%d' % DISK_BYTES, 'unit5', folder]):
            print('A small disk cannot be mounted here, so none is filled.')
            return []
        try:
            demo = os.path.join(kills.FOLDER, kills.DEMO)
            done = subprocess.run([demo, '--record', '--seconds', RECORDED_S, '--folder', folder],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            found = ['the demo leaves half a file: ' + path for path in kills.halves(folder)]
            video, frames = cv2.VideoCapture(folder + '/exercise5_6.avi'), 0
            while video.grab():
                frames += 1
            if not 0 < frames == video.get(cv2.CAP_PROP_FRAME_COUNT):
                found.append('of the video %d frames can be read' % frames)
            sentence = 'demo: the disk of %s is full: recording has ended. Make room there' % folder
            if done.returncode != 1 or sentence not in done.stdout or 'Traceback' in done.stdout:
                found.append('the demo ends with %d, saying:\n%s' % (done.returncode, done.stdout))
        finally:
            subprocess.check_call(['umount', '--lazy', folder])
    print('script/demo --record on a disk of %d MB: %d frames of video, whole: %d findings (target: 0)' % (
        DISK_BYTES >> 20, frames, len(found)))
    return found


def kill(seconds, seed):
    """End programs at random moments, COUNT or for so long."""
    others = *kills.NODES, *kills.TOOLS, *kills.LAUNCHES
    end = None if seconds is None else time.monotonic() + seconds
    taken, found = [], []

    def strike(each):
        took, sentences = kills.strike(each)
        taken.append(took)
        for sentence in sentences:
            tell(sentence)
        found.extend(sentences)

    def strike_all(ways, count):
        for each in islice(ways, count):
            if end is not None and time.monotonic() > end:
                break
            strike(each)
    while not taken or (end is not None and time.monotonic() < end):
        with ThreadPoolExecutor(AT_A_TIME) as pool:
            demos = kills.kills(random.Random(seed), [kills.DEMO])  # they share build/: one at a time
            jobs = [pool.submit(strike_all, demos, COUNT // 10)]
            for number in range(1, AT_A_TIME):
                ways = kills.kills(random.Random(AT_A_TIME * seed + number), others)
                jobs.append(pool.submit(strike_all, ways, COUNT * 9 // 10 // (AT_A_TIME - 1)))
        for job in jobs:
            job.result()
        seed += 1
    print('%d programs ended by SIGINT, SIGTERM or SIGKILL at a random moment: %d findings (target: 0);\n'
          'they took %.2f s to end, the slowest %.1f s (target: below %d s)'
          % (len(taken), len(found), np.median(taken), max(taken), kills.ENDS_S))
    return found
