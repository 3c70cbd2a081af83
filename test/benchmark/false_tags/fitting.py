"""Find the numbers of aruco_ar/tags/confidence.py, by what is found in simulated frames."""
from multiprocessing import Pool

import cv2
import numpy as np
from aruco_ar.base.progress import progress
from aruco_ar.tags.confidence import count_changes, evidence
from aruco_ar.tags.tag import DICTIONARY_NAMES, get_dictionary, tag_cells

from . import frames
from .findings import TAGGED, finder_of, tagged

FIRST = 10**6    # the number of the first frame: the benchmark looks at others
FRAMES = {'walls': (frames.wall_frame, 600), 'things': (frames.thing_frame, 2500)}
TAG_FRAMES = 60  # of each dictionary
WEIGHT = 0.1     # of a frame without tags: there are then seven of them for each with some
ROUNDS = 30
ANY = 1e-12      # confidence; with 0, also those would be found that are hardly like their tag


def _findings(job):
    kind, number = job
    finder = finder_of(ANY)
    if kind in FRAMES:
        frame = FRAMES[kind][0](number)
        return [found for name in DICTIONARY_NAMES for found in finder.ours(kind, frame, name, {})]
    return tagged(finder, kind, number)


def evidence_of(found):
    """What speaks for a Finding."""
    return evidence(found.likeness, count_changes(tag_cells(found.dictionary, found.id)),
                    get_dictionary(found.dictionary).markerSize**2)


def regression(given, wanted, weights):
    """The coefficients, (m,), of a logistic regression, by Newton's method.

    ``given``: (n, m). ``wanted``: (n,) 0 or 1. ``weights``: (n,).
    """
    coefficients = np.zeros(given.shape[1])
    for _ in range(ROUNDS):
        shares = 1 / (1 + np.exp(-given @ coefficients))
        slope = given.T @ (weights * (wanted - shares))
        bend = (given * (weights * shares * (1 - shares))[:, None]).T @ given
        coefficients += np.linalg.solve(bend + 1e-6 * np.eye(len(bend)), slope)
    return coefficients


def run():
    """Print the coefficients."""
    cv2.setNumThreads(1)
    jobs = [(kind, FIRST + number) for kind, (_, count) in FRAMES.items() for number in range(count)]
    jobs += [(name, FIRST + number) for name in DICTIONARY_NAMES for number in range(TAG_FRAMES)]
    with Pool() as pool:
        each = progress(pool.imap_unordered(_findings, jobs, 8), 'frames', len(jobs))
        findings = [found for some in each for found in some]
    weights = np.array([1 if found.kind == TAGGED else WEIGHT for found in findings])
    is_true = np.array([found.is_true for found in findings], float)
    coefficients = regression(np.array([evidence_of(found) for found in findings]), is_true, weights)
    print('%d true and %d false tags\nCOEFFICIENTS = %s'
          % (is_true.sum(), (1 - is_true).sum(), ', '.join('%.3f' % number for number in coefficients)))


if __name__ == '__main__':
    run()
