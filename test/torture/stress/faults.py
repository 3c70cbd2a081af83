"""Disks that fill up, and programs that are terminated at random moments."""
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
from hostile import kills
from rig.nodes.master import Master

COUNT, AT_A_TIME = 100, 3
DISK_BYTES, RECORDED_S = 16 << 20, '20'


def run(seconds, seed):
    """Fill a disk, and terminate programs. Returns sentences about what was found."""
    found = fill_disk()
    with Master(), kills.camera():
        return found + kill_programs(seconds, seed)


def fill_disk():
    """Record with script/demo to a disk that is too small. Returns sentences about what was found."""
    with tempfile.TemporaryDirectory() as folder:
        if subprocess.call(['mount', '-t', 'tmpfs', '-o', 'size=%d' % DISK_BYTES, 'unit5', folder]):
            print('A small disk cannot be mounted here, so none is filled.')
            return []
        try:
            demo = os.path.join(kills.FOLDER, kills.DEMO)
            done = subprocess.run([demo, '--record', '--seconds', RECORDED_S, '--folder', folder],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            found = ['the demo leaves an incomplete file: ' + path for path in kills.halves(folder)]
            video, frames = cv2.VideoCapture(folder + '/exercise5_6.avi'), 0
            while video.grab():
                frames += 1
            if not 0 < frames == video.get(cv2.CAP_PROP_FRAME_COUNT):
                found.append('%d frames of the video can be read' % frames)
            sentence = 'demo: the disk of %s is full: recording has ended. Make room there' % folder
            if done.returncode != 1 or sentence not in done.stdout or 'Traceback' in done.stdout:
                found.append('the demo ends with exit code %d and prints:\n%s' % (done.returncode, done.stdout))
        finally:
            subprocess.check_call(['umount', '--lazy', folder])
    print('script/demo --record on a disk of %d MB: %d frames of complete video, %d faults (target: 0)' % (
        DISK_BYTES >> 20, frames, len(found)))
    return found


def kill_programs(seconds, seed):
    """Terminate programs at random moments: COUNT of them, or for ``seconds`` if given."""
    others = *kills.NODES, *kills.TOOLS, *kills.LAUNCHES
    end = None if seconds is None else time.monotonic() + seconds
    durations, found = [], []

    def strike(each):
        took, sentences = kills.strike(each)
        durations.append(took)
        for sentence in sentences:
            tell(sentence)
        found.extend(sentences)

    def strike_all(ways, count):
        for each in islice(ways, count):
            if end is not None and time.monotonic() > end:
                break
            strike(each)
    while not durations or (end is not None and time.monotonic() < end):
        with ThreadPoolExecutor(AT_A_TIME) as pool:
            demos = kills.kills(random.Random(seed), [kills.DEMO])  # one at a time, since they share build/
            jobs = [pool.submit(strike_all, demos, COUNT // 10)]
            for number in range(1, AT_A_TIME):
                ways = kills.kills(random.Random(AT_A_TIME * seed + number), others)
                jobs.append(pool.submit(strike_all, ways, COUNT * 9 // 10 // (AT_A_TIME - 1)))
        for job in jobs:
            job.result()
        seed += 1
    print('%d programs terminated by SIGINT, SIGTERM, or SIGKILL at a random moment: %d faults (target: 0).\n'
          'They took %.2f s to end (median), the slowest %.1f s (target: below %d s).'
          % (len(durations), len(found), np.median(durations), max(durations), kills.ENDS_S))
    return found
