"""The node's status on /diagnostics."""
import threading
import time
from collections import deque

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import Updater

from .faults import fault_barrier, last_fault

PERIOD_S = 1.0
WINDOW_S = 5.0       # rates and times are computed from the frames of the last WINDOW_S
NO_TAGS_S = 10.0     # after this time without a tag in sight, there is a warning
MAX_DROPPED = 0.1    # if a larger share of the frames is dropped, there is a warning
BUSY = 0.5           # a node that works for a smaller share of the time is not called slow
MAX_MISSING = 1000   # a larger gap between two header.seq is not lost frames, but another camera
NO_TAG = 'No tag has been in sight for '  # the sentence begins so
NONE_SEEN, YES, NO = 'none seen', 'yes', 'no'
AREA_SEEN = 'area last seen (s ago)'
MAX_LATENCY_S = 60.0  # a frame that seems older than this was stamped by another clock, or comes from a bag

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


class Diagnostics:
    """Publishes the node's status about once a second."""

    def __init__(self, report):
        """``report`` returns the status: level, sentence, {name: value}.

        A recent fault of the node replaces it.
        """
        self._updater = Updater()
        self._updater.setHardwareID('none')
        self._updater.add('frames', self._fill)
        self._report = fault_barrier(report)
        self._due = 0.0

    @fault_barrier
    def update(self):
        """Publish if PERIOD_S has passed on the monotonic clock: simulated time may stand still."""
        if time.monotonic() >= self._due:
            self._due = time.monotonic() + PERIOD_S
            self._updater.force_update()

    def _fill(self, status):
        level, sentence, values = self._report() or (ERROR, 'The status of the node is unknown.', {})
        fault = last_fault()
        status.summary(*(ERROR, fault) if fault else (level, sentence))
        for name, value in values.items():
            status.add(name, value)
        return status


class FrameCount:
    """Counts the frames that arrive, are answered and are dropped, and measures how long they take."""

    def __init__(self, looks_for_tags=True):
        """``looks_for_tags``: whether to report tags and the area, too."""
        self._lock = threading.Lock()  # frames arrive in one thread, reports are made in another
        self._arrived = self._answered = self._dropped = self._unusable = 0
        self._dropped_since_answer = 0
        self._sequence = None
        # For each answer: when, processing time in s, latency in s or nan, frames dropped before it.
        self._recent: deque[tuple[float, float, float, int]] = deque()
        self._problems: deque[tuple[float, str]] = deque()  # when a frame was not usable, and why
        self._tags = 0 if looks_for_tags else None
        self._tag_seen, self._area_seen = time.monotonic(), None
        self._has_area = None  # whether the last frame has one; None before the first frame, and after a pause
        self.misses_tags = False  # whether at the last report no tag was in sight for NO_TAGS_S, nor an area

    def forget_last_frames(self):
        """Forget what is true only of the last frames. Frames of a pause do not count as dropped."""
        with self._lock:
            self._sequence, self._tag_seen, self._has_area = None, time.monotonic(), None
            self._recent.clear()
            self._problems.clear()
            self._dropped_since_answer = 0

    def on_arrival(self, sequence):
        """A frame with this header.seq has arrived. Returns how many were lost since the one before."""
        with self._lock:
            missing = 0 if self._sequence is None else sequence - self._sequence - 1
            missing = missing if 0 < missing < MAX_MISSING else 0
            self._sequence = sequence
            self._arrived += 1
            self._dropped += missing
        return missing

    def on_drop(self):
        """The node drops the frame that arrived last."""
        with self._lock:
            self._dropped += 1
            self._dropped_since_answer += 1

    def on_unusable(self, why):
        """The frame that arrived last cannot be used. ``why``: a sentence."""
        with self._lock:
            self._unusable += 1
            self._problems.append((time.monotonic(), why))

    def on_answer(self, arrival, stamp, missing, tags, has_area):
        """The frame that arrived last has been answered.

        ``arrival``: when it arrived, monotonic seconds. ``stamp``: its rospy.Time. ``missing``: what on_arrival
        returned. ``tags``: how many are in sight. ``has_area``: whether the area is known.
        """
        now = time.monotonic()
        latency = (rospy.Time.now() - stamp).to_sec() if stamp else np.nan
        latency = latency if 0 <= latency < MAX_LATENCY_S else np.nan
        with self._lock:
            self._answered += 1
            self._recent.append((now, now - arrival, latency, missing + self._dropped_since_answer))
            self._dropped_since_answer = 0
            self._tags = tags
            if tags:
                self._tag_seen = now
            self._has_area = has_area
            if has_area:
                self._area_seen = now

    def report(self):
        """(level, sentence, {name: value}) for Diagnostics, while the node listens to the camera."""
        now = time.monotonic()
        with self._lock:
            for events in self._recent, self._problems:
                while events and now - events[0][0] > WINDOW_S:
                    events.popleft()
            recent = np.array(self._recent).reshape(-1, 4)
            problems = [why for _, why in self._problems]
            unseen, area_seen = now - self._tag_seen, self._area_seen
            values: dict[str, object] = {
                'frames in': self._arrived, 'frames out': self._answered, 'frames dropped': self._dropped}
            if self._unusable:
                values['frames not usable'] = self._unusable
            tags, has_area = self._tags, self._has_area
        rate = (len(recent) - 1) / max(np.ptp(recent[:, 0]), 1e-3) if len(recent) > 1 else 0.0
        values['frame rate (Hz)'] = '%.1f' % rate
        for name, column in ('pipeline', recent[:, 1]), ('latency', recent[:, 2]):
            known = column[np.isfinite(column)] * 1000
            for label, percent in ('median', 50), ('99 %', 99):
                values['%s, %s (ms)' % (name, label)] = \
                    '%.1f' % np.percentile(known, percent) if len(known) else 'unknown'
        if tags is not None:
            values['tags in sight'] = tags if len(recent) else 0
            values[AREA_SEEN] = NONE_SEEN if area_seen is None else '%.1f' % (now - area_seen)
            if has_area is not None:
                values['area in the last frame'] = YES if has_area else NO
        self.misses_tags = tags is not None and not has_area and unseen > NO_TAGS_S
        if len(problems) > 1:  # a single one is told by the log
            return WARN, '%d of %d frames within %d s could not be used. %s' % (
                len(problems), len(problems) + len(recent), WINDOW_S, problems[-1]), values
        dropped = recent[:, 3].sum()
        if len(recent) > 1 and dropped > MAX_DROPPED * (dropped + len(recent)):
            # A node that is idle most of the time does not drop them itself.
            busy = recent[:, 1].sum() > BUSY * np.ptp(recent[:, 0])
            remedy = 'Lower ~rate.' if tags is None else 'Lower ~scale, or set ~search to fast.'
            why = 'Slow: %s were dropped within %d s. ' + remedy if busy else \
                '%s did not arrive within %d s: the gaps in header.seq show that they were lost on the way.'
            return WARN, why % ('%d of %d frames' % (dropped, dropped + len(recent)), WINDOW_S), values
        if self.misses_tags:
            return WARN, NO_TAG + '%d s.' % unseen, values
        return OK, '%.1f frames a second' % rate, values
