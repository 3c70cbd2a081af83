"""What the searches of the detector cost on real clips, and which tags they find."""
import os

import cv2
import numpy as np
from aruco_ar.base.progress import progress, tell

from benchmark.simulated.search import DEFAULT, METHODS, finder
from benchmark.simulated.speed import timed


def measure(clip):
    """{method: (mean milliseconds a frame, tags found, wrong ids)} for a clip. The methods take turns.

    Of a clip of which not all ids are known, only the area's tags count, and the wrong ids are None.
    """
    frames, _ = clip.frames()
    finders = {method: finder(method, clip.dictionary) for method in METHODS}
    right, took = set(clip.all_ids or clip.ids), {method: [] for method in METHODS}
    found, wrong = dict.fromkeys(METHODS, 0), dict.fromkeys(METHODS, 0)
    for frame in frames:
        for method, find in finders.items():
            milliseconds, tags = timed(find, frame)
            took[method].append(milliseconds)
            ids = {tag_id for tag_id, _ in tags}
            found[method] += len(ids & right)
            wrong[method] += len(tags) - len(ids & right)
    return {method: (np.mean(took[method]), found[method], wrong[method] if clip.all_ids else None)
            for method in METHODS}


def run(clips):
    """Print a table of all Clips."""
    cv2.setNumThreads(1)
    print("\nSearches of each frame of real clips, each as if it were the first one, on one thread. The cost\n"
          "is the mean, relative to OpenCV's default. wrong: ids that are not on the wall, and tags found\n"
          'twice.\n\n%-28s%-18s%20s%8s%8s' % ('', '', 'cost', 'tags', 'wrong'))
    for clip in progress(clips, 'clips'):
        rows = measure(clip)
        for method, (took, found, wrong) in rows.items():
            tell('%-28s%-18s%20s%8d%8s' % (
                os.path.basename(clip.path) if method == DEFAULT else '', method,
                '%.2f ms = %.2fx' % (took, took / rows[DEFAULT][0]), found, '-' if wrong is None else wrong))
