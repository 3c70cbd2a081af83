"""How a node is doing, for /diagnostics."""
import threading
import time
from collections import deque

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import Updater

from .faults import guarded, last_fault

PERIOD_S = 1.0
WINDOW_S = 5.0       # what is said about rates and times is about the frames of so long
NO_TAGS_S = 10.0     # without a tag in sight for so long something may be wrong
MAX_DROPPED = 0.1    # of the frames: a node that drops more is too slow
BUSY = 0.5           # of the time: a node that is at it less is not slow
MAX_MISSING = 1000   # more frames than that are not missing between two: another camera counts otherwise
MAX_LATENCY_S = 60.0  # frames older than that are stamped by another clock, or come from a bag

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


class Diagnostics:
    """Publishes, about once a second, what a function says of the node.

    ``report`` returns a level, a sentence and {name: value}. A fault of the
    node itself goes before.
    """

    def __init__(self, report):
        self._updater = Updater()
        self._updater.setHardwareID('none')
        self._updater.add('frames', self._fill)
        self._report = guarded(report)
        self._due = 0.0

    @guarded
    def update(self):
        """Publish if it is time to, by a clock that does not stop: simulated time may."""
        if time.monotonic() >= self._due:
            self._due = time.monotonic() + PERIOD_S
            self._updater.force_update()

    def _fill(self, status):
        level, sentence, values = self._report() or (ERROR, 'It cannot be said how the node is doing.', {})
        fault = last_fault()
        status.summary(*(ERROR, fault) if fault else (level, sentence))
        for name, value in values.items():
            status.add(name, value)
        return status


class FrameCount:
    """Counts the frames that come in, go out and are dropped, and how long they take.

    ``tags``: how many are in sight so far; None where none are looked for.
    """

    def __init__(self, tags=0):
        self._lock = threading.Lock()  # frames come in one thread, the report is made in another
        self._came = self._answered = self._dropped = self._left_out = 0
        self._number = None
        # When, pipeline s, latency s or nan, dropped before it.
        self._recent: deque[tuple[float, float, float, int]] = deque()
        self._tags, self._sighted, self._area_seen = tags, time.monotonic(), None

    def begin(self):
        """Frames are awaited from now on, or not any more: what was published before is not dropped."""
        with self._lock:
            self._number, self._sighted = None, time.monotonic()
            self._recent.clear()
            self._left_out = 0

    def came(self, number):
        """A frame has come with that number, which its publisher counts up; returns how many are missing."""
        with self._lock:
            missing = 0 if self._number is None else number - self._number - 1
            missing = missing if 0 < missing < MAX_MISSING else 0
            self._number = number
            self._came += 1
            self._dropped += missing
        return missing

    def left_out(self):
        """It is not answered."""
        with self._lock:
            self._dropped += 1
            self._left_out += 1

    def answered(self, began, stamp, missing, tags, area):
        """It has been answered. ``began``: when it came, monotonic.

        ``tags``, ``area``: how many are in sight, and whether one is; None where none are looked for.
        """
        now = time.monotonic()
        latency = (rospy.Time.now() - stamp).to_sec() if stamp else np.nan
        latency = latency if 0 <= latency < MAX_LATENCY_S else np.nan
        with self._lock:
            self._answered += 1
            self._recent.append((now, now - began, latency, missing + self._left_out))
            self._left_out = 0
            self._tags = tags
            if tags:
                self._sighted = now
            if area:
                self._area_seen = now

    def report(self):
        """(level, sentence, {name: value}) while frames are wanted."""
        now = time.monotonic()
        with self._lock:
            while self._recent and now - self._recent[0][0] > WINDOW_S:
                self._recent.popleft()
            recent = np.array(self._recent).reshape(-1, 4)
            unseen, area_seen = now - self._sighted, self._area_seen
            values: dict[str, object] = {
                'frames in': self._came, 'frames out': self._answered, 'frames dropped': self._dropped}
            tags = self._tags
        rate = (len(recent) - 1) / max(np.ptp(recent[:, 0]), 1e-3) if len(recent) > 1 else 0.0
        values['frame rate (Hz)'] = '%.1f' % rate
        for name, column in ('pipeline', recent[:, 1]), ('latency', recent[:, 2]):
            known = column[np.isfinite(column)] * 1000
            for label, percent in ('median', 50), ('99 %', 99):
                values['%s, %s (ms)' % (name, label)] = \
                    '%.1f' % np.percentile(known, percent) if len(known) else 'unknown'
        if tags is not None:
            values['tags in sight'] = tags if len(recent) else 0
            values['area last seen (s ago)'] = 'none seen' if area_seen is None else '%.1f' % (now - area_seen)
        dropped = recent[:, 3].sum()
        if len(recent) > 1 and dropped > MAX_DROPPED * (dropped + len(recent)):
            # Where most of the time is left, it is not the node that drops them.
            busy = recent[:, 1].sum() > BUSY * np.ptp(recent[:, 0])
            remedy = 'A lower ~rate helps.' if tags is None else 'A smaller ~scale helps, or ~search fast.'
            why = 'Slow: %s were dropped within %d s. ' + remedy if busy else \
                '%s did not arrive within %d s: lost or left out on their way, by their header.seq.'
            return WARN, why % ('%d of %d frames' % (dropped, dropped + len(recent)), WINDOW_S), values
        if tags is not None and unseen > NO_TAGS_S:
            return WARN, 'No tag has been in sight for %d s.' % unseen, values
        return OK, '%.1f frames a second' % rate, values
