"""How many tags of each dictionary are found where there are none, and how many of those found are true."""
import os
from collections import Counter
from multiprocessing import Pool

import cv2
from aruco_ar.base.progress import progress, tell
from aruco_ar.tags.detector import MIN_CONFIDENCE
from aruco_ar.tags.tag import DICTIONARY_NAMES

from benchmark.real_clips.clips import CLIPS, clips_of
from benchmark.real_clips.truth import tags_of

from . import frames
from .findings import finder_of, tagged

SIMULATED = {'walls': (frames.wall_frame, 10000), 'things': (frames.thing_frame, 5000)}
TAG_FRAMES = 60           # with tags, of each dictionary
EACH = 20                 # OpenCV's detector looks at only one frame of so many
LEAST = MIN_CONFIDENCE, 0.5, 0.9
EDGES = MIN_CONFIDENCE, 0.5, 0.8, 0.95, 1.0
PER_TAGGED = 7            # frames without tags for each with some; see aruco_ar/tags/confidence.py
PER = 10000               # frames: what the numbers are for

_job = None  # what a process of the pool does with a number


def _take(job):
    global _job  # noqa: PLW0603  it holds a whole clip, which is not sent to each process
    _job = job


def _do(number):
    return _job(number)


def results(job, count, label):
    """What a function returns for the numbers 0 to count - 1, on all cores."""
    with Pool(initializer=_take, initargs=(job,)) as pool:
        return list(progress(pool.imap_unordered(_do, range(count), frames.VIEWS), label, count))


class Tagless:
    """Looks for tags of all dictionaries in frames without any: ours, and now and then OpenCV's detector.

    ``kind``: of the frames. ``frame_of``: makes one from its number. ``clip``: the Clip in which tags were
    painted over, or None. Of one that is not quite covered, the same tag may be found.
    """

    def __init__(self, kind, frame_of, clip=None):
        self._kind, self._frame_of, self._clip = kind, frame_of, clip

    def __call__(self, number):
        """The Findings in a frame, and {dictionary: what OpenCV's detector finds}."""
        finder, frame = finder_of(MIN_CONFIDENCE), self._frame_of(number)
        ours = [found for name in DICTIONARY_NAMES for found in finder.ours(self._kind, frame, name, {})
                if not self._is_rest(found.dictionary, found.id)]
        opencv = {} if number % EACH else {
            name: sum(not self._is_rest(name, tag_id) for tag_id in finder.opencv(frame, name))
            for name in DICTIONARY_NAMES}
        return ours, opencv

    def _is_rest(self, dictionary, tag_id):
        return self._clip is not None and tag_id in self._clip.all_ids \
            and dictionary.split('_')[1] == self._clip.dictionary.split('_')[1]


def _tagged(number):
    return tagged(finder_of(MIN_CONFIDENCE), DICTIONARY_NAMES[number % len(DICTIONARY_NAMES)], number)


class Filmed:
    """Looks for the tags of a Clip in each of its frames."""

    def __init__(self, clip):
        self._clip, (self._frames, _) = clip, clip.frames()
        self._tags = tags_of(self._frames, clip.dictionary, clip.all_ids)

    def __len__(self):
        return len(self._frames)

    def __call__(self, number):
        """The Findings in a frame. Where it is not known where all tags are, those with a right id are true."""
        clip, truth = self._clip, self._tags[number]
        found = finder_of(MIN_CONFIDENCE).ours(os.path.basename(clip.path), self._frames[number],
                                               clip.dictionary, truth)
        return found if truth else [each._replace(is_true=each.id in clip.all_ids) for each in found]


def _per_dictionary(tagless, opencv, count):
    print('\nFalse tags in %d frames without tags: simulated walls, things with corners and cells, and real\n'
          'clips with their tags painted over. For %d frames: ours, by the least confidence, and those of\n'
          "OpenCV's detector as it comes, which has looked at each %dth frame.\n" % (count, PER, EACH))
    print('%-24s' % '' + ''.join('%10s' % ('at %g' % least) for least in LEAST) + '%14s' % "OpenCV's")
    seen = -(-count // EACH)
    for name in DICTIONARY_NAMES:
        mine = [found.confidence for found in tagless if found.dictionary == name]
        ours = [sum(confidence > least for confidence in mine) for least in LEAST]
        tell('%-24s' % name + ''.join('%10.1f' % (PER * each / count) for each in ours)
             + '%14.1f' % (PER * opencv[name] / seen))


def _per_kind(tagless, counts):
    print('\nThe same by the kind of frame, all dictionaries together:\n')
    for kind, count in counts.items():
        mine = [found.confidence for found in tagless if found.kind == kind]
        ours = [sum(confidence > least for confidence in mine) for least in LEAST]
        tell('%-14s%10d' % (kind, count) + ''.join('%10.1f' % (PER * each / count) for each in ours))


def _trust(title, findings, tagless=(), weight=0.0):
    """Print how many of the tags are true, by their confidence.

    ``findings``: in frames with tags. ``tagless``: in frames without; each of them counts ``weight``.
    """
    cells = []
    for low, high in zip(EDGES, EDGES[1:]):
        in_range = [found for found in findings if low < found.confidence <= high]
        total = len(in_range) + weight * sum(low < found.confidence <= high for found in tagless)
        share = '%.3f' % (sum(found.is_true for found in in_range) / total) if total else '-'
        cells.append('%8.0f %6s' % (total, share))
    tell('%-24s' % title + '  '.join(cells))


def _tagless_jobs(clips):
    """Yield (kind of frame, how many there are, the function for their numbers)."""
    for kind, (frame_of, count) in SIMULATED.items():
        yield kind, count, Tagless(kind, frame_of)
    for clip in clips:
        kind, painted = os.path.basename(clip.path), frames.PaintedOver(clip)
        yield kind, len(painted), Tagless(kind, painted.frame, clip)


def run():
    """Print the tables. This takes some 40 minutes."""
    cv2.setNumThreads(1)  # in the processes of a pool it would wait for threads that are not there
    tagless, opencv, counts = [], Counter(), {}
    clips = clips_of(CLIPS) if os.path.isdir(CLIPS) else []
    for kind, count, job in _tagless_jobs(clips):
        counts[kind] = count
        for ours, theirs in results(job, count, kind):
            tagless += ours
            opencv.update(theirs)
    total = sum(counts.values())
    _per_dictionary(tagless, opencv, total)
    _per_kind(tagless, counts)

    findings = [found for some in results(_tagged, TAG_FRAMES * len(DICTIONARY_NAMES), 'frames with tags')
                for found in some]
    weight = PER_TAGGED * TAG_FRAMES / total
    print('\nTags by their confidence: how many were found, and which share of them is true. Simulated: %d\n'
          'frames with tags of each dictionary, and for each of these, %d of those without. Then the real\n'
          'clips as they are.\n' % (TAG_FRAMES, PER_TAGGED))
    print('%-24s' % '' + '  '.join('%15s' % ('%g to %g' % pair) for pair in zip(EDGES, EDGES[1:])))
    for name in DICTIONARY_NAMES:
        _trust(name, *([found for found in some if found.dictionary == name] for some in (findings, tagless)),
               weight)
    _trust('all of them', findings, tagless, weight)
    for clip in clips:
        film = Filmed(clip)
        _trust(os.path.basename(clip.path),
               [found for some in results(film, len(film), 'tags of the clip') for found in some])
