"""Listening to topics, and knowing who listens."""
import queue
import threading

import rospy
from started import WAIT_S


class Inbox(queue.Queue):
    """The messages of a topic; ``get`` waits for the next."""

    def __init__(self, topic, kind):
        super().__init__()
        self.subscriber = rospy.Subscriber(topic, kind, self.put, queue_size=10, buff_size=1 << 25)

    def next(self):
        return self.get(timeout=WAIT_S)


class Connections(rospy.SubscribeListener):
    """Tells when somebody subscribes to a topic, and when they leave."""

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
