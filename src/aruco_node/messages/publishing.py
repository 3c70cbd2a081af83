"""Publishing images, and noticing who listens."""
import rospy
from sensor_msgs.msg import CompressedImage, Image

from .images import JPEG_QUALITY, compressed_from_frame, image_from_frame


class ImagePublisher:
    """An image topic, raw and as JPEG. Each message is made only while somebody listens to it."""

    def __init__(self, topic, on_listeners=None, encoding='bgr8'):
        """``on_listeners`` is called, from any thread, when somebody starts or stops listening.

        ``encoding`` of the raw images: bgr8 or rgb8.
        """
        self._encoding = encoding
        self.quality = JPEG_QUALITY  # 1 to 100
        events = ListenerEvents(on_listeners) if on_listeners else None
        self.name = rospy.resolve_name(topic)
        self._raw = rospy.Publisher(topic, Image, events, queue_size=1)
        # Named after the resolved name, so that it follows a remapping of the raw topic.
        self._compressed = rospy.Publisher(self.name + '/compressed', CompressedImage, events, queue_size=1)

    def has_listeners(self):
        """Whether anybody listens to the raw or the compressed topic."""
        return self._raw.get_num_connections() + self._compressed.get_num_connections() > 0

    def publish(self, frame, header):
        """Publish a frame, (h, w, 3) BGR uint8, on those of the two topics that somebody listens to."""
        for publisher, message in self.messages(frame, header):
            publisher.publish(message)

    def messages(self, frame, header):
        """[(rospy.Publisher, message)] of a frame, (h, w, 3) BGR uint8, one for each topic with listeners."""
        found = []
        if self._raw.get_num_connections():
            found.append((self._raw, image_from_frame(frame, header, self._encoding)))
        if self._compressed.get_num_connections():
            found.append((self._compressed, compressed_from_frame(frame, header, self.quality)))
        return found


class ListenerEvents(rospy.SubscribeListener):
    """Calls a function, from any thread, when somebody starts or stops listening to a topic."""

    def __init__(self, on_change):
        super().__init__()
        self._on_change = on_change

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        self._on_change()

    def peer_unsubscribe(self, topic_name, num_peers):
        self._on_change()
