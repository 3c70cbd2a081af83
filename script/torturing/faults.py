"""Programs that are ended at random moments."""
import random
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import islice

import numpy as np
from aruco_ar.progress import tell
from hostile import kills
from master import Master

COUNT, AT_A_TIME = 100, 3


def run(seconds, seed):
    """Kill; what was left."""
    with Master(), kills.camera():
        return kill(seconds, seed)


def kill(seconds, seed):
    others = [name for name in (*kills.NODES, *kills.TOOLS, *kills.LAUNCHES)]
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
    while not taken or end is not None and time.monotonic() < end:
        with ThreadPoolExecutor(AT_A_TIME) as pool:
            demos = kills.kills(random.Random(seed), [kills.DEMO])  # they share build/: one at a time
            jobs = [pool.submit(strike_all, demos, COUNT // 10)]
            for number in range(1, AT_A_TIME):
                ways = kills.kills(random.Random(AT_A_TIME * seed + number), others)
                jobs.append(pool.submit(strike_all, ways, COUNT * 9 // 10 // (AT_A_TIME - 1)))
        for job in jobs:
            job.result()
        seed += 1
    print('%d programs ended by SIGINT, SIGTERM or SIGKILL at a random moment: %d findings (target: 0); they took '
          '%.2f s to end, the slowest %.1f s (target: below %d s)' % (
              len(taken), len(found), np.median(taken), max(taken), kills.ENDS_S))
    return found
