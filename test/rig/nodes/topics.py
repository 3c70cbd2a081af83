"""Subscribers that wait for messages, and publishers that know their subscribers."""
import queue
import re
import threading
import time
from contextlib import suppress

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from rig.processes.started import WAIT_S

# Of a node, or of the simulated camera, on a machine that is slow.
ONLY_SOME = re.compile(r'\d+ of \d+ frames (were dropped|did not arrive)|Slow: (?!0\.0)[\d.]+ frames a second')


class Inbox(queue.Queue):
    """A queue of a topic's messages. ``newest``: how many of them it holds at most, 0: all."""

    def __init__(self, topic, kind, newest=0):
        super().__init__(newest)
        self.subscriber = rospy.Subscriber(topic, kind, self._take, queue_size=10, buff_size=1 << 25)

    def _take(self, message):
        with suppress(queue.Empty):
            while self.full():
                self.get_nowait()
        self.put(message)

    def next(self):
        """Wait for the next message."""
        return self.get(timeout=WAIT_S)


def moments(topics, count, keep=bool):
    """Wait for moments: messages of all topics with the same stamp, which ``keep`` accepts.

    ``topics``: {topic: type}. Returns a list of at least ``count`` moments, {topic: message}, in the order in
    which they became complete. Those of a bag that is played again come again.
    """
    parts, whole, changed = {}, [], threading.Condition()

    def listen(topic, kind):
        def take(message):
            stamp = message.header.stamp
            with changed:
                moment = parts.setdefault(stamp, {})
                moment[topic] = message
                if len(moment) == len(topics):
                    del parts[stamp]
                    if keep(moment):
                        whole.append(moment)
                        changed.notify_all()
        return rospy.Subscriber(topic, kind, take, queue_size=10, buff_size=1 << 26)
    subscribers = [listen(topic, kind) for topic, kind in topics.items()]
    with changed:
        done = changed.wait_for(lambda: len(whole) >= count, WAIT_S)
        found = list(whole)
    for subscriber in subscribers:
        subscriber.unregister()
    if not done:
        raise AssertionError('only %d of %d moments were complete' % (len(found), count))
    return found


class Connections(rospy.SubscribeListener):
    """Counts the subscribers of a topic."""

    def __init__(self):
        super().__init__()
        self.count, self._changed = 0, threading.Condition()

    def peer_subscribe(self, *_):
        self._change(1)

    def peer_unsubscribe(self, *_):
        self._change(-1)

    def _change(self, by):
        with self._changed:
            self.count += by
            self._changed.notify_all()

    def wait(self, count):
        with self._changed:
            if not self._changed.wait_for(lambda: self.count == count, WAIT_S):
                raise AssertionError('%d subscribers, not %d' % (self.count, count))


class Diagnostics:
    """What /diagnostics reports about nodes."""

    def __init__(self):
        self._statuses, self._changed = {}, threading.Condition()
        self.subscriber = rospy.Subscriber('/diagnostics', DiagnosticArray, self._take, queue_size=100)

    def _take(self, message):
        with self._changed:
            for status in message.status:
                self._statuses.setdefault(status.name, []).append(status)
            self._changed.notify_all()

    def wait(self, node, *words, level=DiagnosticStatus.OK):
        """Wait for a new status of a node with this level and these words; returns its {name: value}."""
        def is_wanted(status):
            return status.level == level and all(word in status.message for word in words)
        return self._wait(node, is_wanted, '%s at level %d' % (words, level))

    def wait_for_any(self, node):
        """Wait for any new status of a node."""
        self._wait(node, lambda status: True, 'reported at all')

    def wait_for_frames(self, node):
        """Wait for a new status that says that a node gets frames, perhaps only some of them."""
        def gets_frames(status):
            return (status.level == DiagnosticStatus.OK and 'frames a second' in status.message) or \
                (status.level == DiagnosticStatus.WARN and ONLY_SOME.search(status.message))
        return self._wait(node, gets_frames, 'one that says that it gets frames')

    def _wait(self, node, is_wanted, words):
        name = node + ': frames'
        with self._changed:
            self._statuses.pop(name, None)

            def found():
                return next(filter(is_wanted, self._statuses.get(name, [])), None)
            if not self._changed.wait_for(found, WAIT_S):
                raise AssertionError('the status of %s is not %s, but %s' % (
                    node, words, self._statuses.get(name, [None])[-1]))
            return {item.key: item.value for item in found().values}


def until(is_so):
    """Call a function repeatedly until its result is true; returns the result."""
    end = time.monotonic() + WAIT_S
    while time.monotonic() < end:
        answer = is_so()
        if answer:
            return answer
        time.sleep(0.05)  # not more often, since the function may ask the ROS master, which serves everybody
    raise AssertionError('the condition never became true')
