"""Topics that are subscribed to only while a browser needs them."""
import asyncio
import math
import time
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import cv2
import rospy
from aruco_node.health.faults import fault_barrier
from aruco_node.messages.images import JPEG_QUALITY, TRANSPORTS, check_compressed, jpeg_from_frame
from aruco_node.messages.topics import IMAGE_TYPES, SUFFIX
from aruco_node.ros_internals.master import no_answer, published_topics
from aruco_node.ros_internals.subscribers import subscribe_newest, tolerant
from rosgraph.names import is_legal_name
from unit5.msg import TagArray

LISTING_S = 1.0   # the master's list of topics is reused for this time
MASTER_S = 5.0    # time limit for the master's answer
RATE_S = 2.0      # frame rates are measured over this time
MAX_SIDE_PX = 4096
JPEG_START = b'\xff\xd8'


class SharedTopic:
    """The newest message of a topic, for several coroutines."""

    def __init__(self, name, kind, registrar):
        """``registrar``: an executor with one thread, which talks to the ROS master."""
        self.name, self.message, self.number = name, None, 0
        self._kind, self._registrar, self._loop = kind, registrar, asyncio.get_event_loop()
        self._users, self._subscriber, self._is_update_pending = 0, None, False
        self._arrival = self._loop.create_future()
        self._times: deque[float] = deque(maxlen=256)

    @contextmanager
    def subscribed(self):
        """A context manager: the topic is subscribed to within the block."""
        self._users += 1
        self._request_update()
        try:
            yield
        finally:
            self._users -= 1
            if not self._users:
                self.message = None  # it will be outdated when the next user comes
            self._request_update()

    async def newer(self, number, seconds):
        """Wait for a message newer than that with this ``number``. Returns whether one arrived in time."""
        if self.number == number:
            await asyncio.wait([self._arrival], timeout=seconds)
        return self.number != number

    @property
    def age(self):
        """Seconds since the newest message arrived; inf if there is none."""
        return time.monotonic() - self._times[-1] if self.message is not None and self._times else float('inf')

    @property
    def rate(self):
        """Messages per second during the last RATE_S."""
        now = time.monotonic()
        while len(self._times) > 1 and now - self._times[0] > RATE_S:
            self._times.popleft()
        span = self._times[-1] - self._times[0] if self._times else 0
        return (len(self._times) - 1) / span if span > 0 else 0.0

    def _request_update(self):
        """Have the registrar subscribe or unsubscribe, unless such a request is pending."""
        if not self._is_update_pending:
            self._is_update_pending = True
            self._registrar.submit(self._update_subscription)

    def _update_subscription(self):
        self._is_update_pending = False  # set first, so that no later change of the users is missed
        try:
            if self._users and self._subscriber is None:
                self._subscriber = subscribe_newest(self.name, self._kind, self._on_message)
            elif not self._users and self._subscriber is not None:
                self._subscriber.unregister()
                self._subscriber = None
        except Exception as error:  # rospy raises many kinds if the master does not answer
            rospy.logwarn('The subscription to %s cannot be changed: %s', self.name, error)

    @fault_barrier
    def _on_message(self, message):
        self._loop.call_soon_threadsafe(self._store, message)

    def _store(self, message):
        message.header.stamp.canon()
        self.message, self.number = message, self.number + 1
        self._times.append(time.monotonic())
        self._arrival.set_result(None)
        self._arrival = self._loop.create_future()


class ImageTopic(SharedTopic):
    """An image topic, with its newest frame as JPEG."""

    def __init__(self, name, transport, registrar, encoder):
        """``transport``: a key of TRANSPORTS. ``encoder``: an executor that encodes JPEGs."""
        suffix, kind, decoder = TRANSPORTS[transport]
        self._to_frame = decoder()
        super().__init__(name + suffix, kind, registrar)
        self._transport, self._encoder = transport, encoder
        self._encoded = {}  # {options: future of a JPEG}, of the newest frame
        self._encoded_number = None

    async def jpeg(self, quality=None, width=None, height=None, most_width=None):
        """The newest frame as the bytes of a JPEG.

        ``quality``: 1 to 100. ``width``, ``height``: pixels. None leaves it as the topic has it.
        ``most_width``: a wider frame is shrunk to this width, pixels.
        Raises InputError if the frame cannot be used.
        """
        if self._encoded_number != self.number:
            self._encoded, self._encoded_number = {}, self.number
        options = quality, width, height, most_width
        if options not in self._encoded:  # requests with the same options share the work
            self._encoded[options] = self._loop.run_in_executor(
                self._encoder, self._encode, self.message, *options)
        return await asyncio.shield(self._encoded[options])

    def _encode(self, message, quality, width, height, most_width):
        if self._transport == 'compressed' and not (quality or width or height) \
                and bytes(message.data[:2]) == JPEG_START \
                and check_compressed(message)[0] <= (most_width or math.inf):
            return bytes(message.data)  # it is a JPEG already
        frame = self._to_frame(message)
        if most_width and frame.shape[1] > most_width:
            width = most_width
        if width or height:
            size = (width or round(frame.shape[1] * height / frame.shape[0]),
                    height or round(frame.shape[0] * width / frame.shape[1]))
            size = [min(max(side, 1), MAX_SIDE_PX) for side in size]
            frame = cv2.resize(frame, size, interpolation=cv2.INTER_AREA)
        return jpeg_from_frame(frame, quality or JPEG_QUALITY)


def transports_of(name, published):
    """The TRANSPORTS with which an image topic is published. ``published``: {name: type} of all topics."""
    return [transport for transport, (suffix, _, _) in TRANSPORTS.items()
            if published.get(name + suffix) == IMAGE_TYPES[transport]]


class Topics:
    """All image topics that are published."""

    def __init__(self):
        self._registrar = ThreadPoolExecutor(1, 'registrar')
        self._encoder = ThreadPoolExecutor(2, 'encoder')
        self._known = {}
        self._published, self._listed, self._listing = {}, -LISTING_S, None

    async def published(self):
        """{name: type} of all topics. Raises InputError if the ROS master does not answer."""
        if time.monotonic() - self._listed > LISTING_S:
            if self._listing is None or self._listing.done():  # concurrent requests share one query
                self._listing = asyncio.get_event_loop().run_in_executor(
                    self._registrar, published_topics)
            try:
                self._published = await asyncio.wait_for(asyncio.shield(self._listing), MASTER_S)
            except asyncio.TimeoutError:  # or the registrar is still busy with another request to it
                raise no_answer('within %g s' % MASTER_S) from None
            self._listed = time.monotonic()
        return self._published

    async def images(self):
        """The sorted raw names of all image topics, also of those that are published only as compressed."""
        published = await self.published()
        names = set(published) | {name[:-len(SUFFIX)] for name in published if name.endswith(SUFFIX)}
        return sorted(name for name in names if transports_of(name, published))

    async def image(self, name, exact=False):
        """The ImageTopic with this raw name, subscribed to as compressed if that is published.

        ``exact``: prefer the raw topic. Raises LookupError, with a sentence, if there is no such image topic,
        and InputError if the ROS master does not answer.
        """
        if not name or not is_legal_name(name):
            raise LookupError('Give the name of an image topic: ?topic=/camera/rgb/image_raw.')
        name, published = rospy.resolve_name(name), await self.published()
        transports = transports_of(name, published)
        if not transports:
            raise LookupError('There is no image topic %s%s.' % (
                name, ': its type is ' + published[name] if name in published else ''))
        transport = transports[0 if exact else -1]
        return self._get(name, ImageTopic, transport, self._registrar, self._encoder)

    def tags(self, name):
        """The SharedTopic of a TagArray, whether it is published or not."""
        return self._get(name, SharedTopic, tolerant(TagArray), self._registrar)

    def _get(self, name, make, *arguments):
        key = name, arguments[0]
        if key not in self._known:
            self._known[key] = make(name, *arguments)
        return self._known[key]
