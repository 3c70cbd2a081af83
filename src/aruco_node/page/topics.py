"""Topics that are subscribed to only while a browser needs them."""
import asyncio
import math
import time
from concurrent.futures import ThreadPoolExecutor

import rospy
from page_server.server import Images
from page_server.shared import Shared, SharedImage
from rosgraph.names import is_legal_name
from unit5.msg import TagArray

from aruco_node.health.faults import fault_barrier
from aruco_node.messages.images import TRANSPORTS, check_compressed
from aruco_node.messages.topics import IMAGE_TYPES, SUFFIX
from aruco_node.ros_internals.master import no_answer, published_topics
from aruco_node.ros_internals.subscribers import subscribe_newest, tolerant

LISTING_S = 1.0   # the master's list of topics is reused for this time
MASTER_S = 5.0    # time limit for the master's answer
JPEG_START = b'\xff\xd8'


class _Topic(Shared):
    """What is Shared comes on a topic."""

    def __init__(self, kind, registrar, *arguments):
        """``kind``: the class of the messages. ``registrar``: an executor with one thread, for the ROS master.

        The other arguments are those of Shared or SharedImage.
        """
        super().__init__(*arguments)
        self._kind, self._registrar = kind, registrar
        self._subscriber, self._is_update_pending = None, False

    def on_users_changed(self):
        """Have the registrar subscribe or unsubscribe, unless such a request is pending."""
        if not self._is_update_pending:
            self._is_update_pending = True
            self._registrar.submit(self._update_subscription)

    def _update_subscription(self):
        self._is_update_pending = False  # set first, so that no later change of the users is missed
        try:
            if self.users and self._subscriber is None:
                self._subscriber = subscribe_newest(self.name, self._kind, self._on_message)
            elif not self.users and self._subscriber is not None:
                self._subscriber.unregister()
                self._subscriber = None
        except Exception as error:  # rospy raises many kinds if the master does not answer
            rospy.logwarn('The subscription to %s cannot be changed: %s', self.name, error)

    @fault_barrier
    def _on_message(self, message):
        message.header.stamp.canon()
        self._loop.call_soon_threadsafe(self.store, self.item_of(message), message.header.stamp.to_nsec())

    def item_of(self, message):
        """What is kept of a message."""
        return message


class TagsTopic(_Topic):
    """The sorted ids of the newest TagArray."""

    def item_of(self, message):
        return sorted(tag.id for tag in message.tags)


class ImageTopic(_Topic, SharedImage):
    """The newest message of an image topic."""

    def __init__(self, name, transport, registrar, encoder):
        """``transport``: a key of TRANSPORTS. ``encoder``: an executor that encodes JPEGs."""
        suffix, kind, decoder = TRANSPORTS[transport]
        super().__init__(kind, registrar, name + suffix, encoder)
        self._transport, self._decode = transport, decoder()

    def frame_of(self, item):
        return self._decode(item)

    def jpeg_of(self, item, most_width):
        if self._transport == 'compressed' and bytes(item.data[:2]) == JPEG_START \
                and check_compressed(item)[0] <= (most_width or math.inf):
            return bytes(item.data)
        return None


def transports_of(name, published):
    """The TRANSPORTS with which an image topic is published. ``published``: {name: type} of all topics."""
    return [transport for transport, (suffix, _, _) in TRANSPORTS.items()
            if published.get(name + suffix) == IMAGE_TYPES[transport]]


class Topics(Images):
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
        return self._get((name, transport), ImageTopic, name, transport, self._registrar, self._encoder)

    def tags(self, name):
        """The TagsTopic of that name, whether it is published or not."""
        return self._get(name, TagsTopic, tolerant(TagArray), self._registrar, name)

    def _get(self, key, make, *arguments):
        if key not in self._known:
            self._known[key] = make(*arguments)
        return self._known[key]
