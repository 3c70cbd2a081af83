"""Publishing images, and knowing who listens."""
import rospy
from sensor_msgs.msg import CompressedImage, Image

from .images import JPEG_QUALITY, compressed_from_frame, image_from_frame


class ImagePublisher:
    """An image topic, raw and JPEG, each made only while somebody listens to it."""

    def __init__(self, topic, on_listeners=None, encoding='bgr8'):
        """``on_listeners`` is called, from any thread, when somebody comes or goes."""
        self._encoding = encoding
        self.quality = JPEG_QUALITY  # 1 to 100
        listener = Listener(on_listeners) if on_listeners else None
        self.name = rospy.resolve_name(topic)
        self._raw = rospy.Publisher(topic, Image, listener, queue_size=1)
        # By the resolved name, so that it goes along where the raw topic is remapped.
        self._compressed = rospy.Publisher(self.name + '/compressed', CompressedImage, listener, queue_size=1)

    def has_listeners(self):
        """Whether anybody listens to one of the two."""
        return self._raw.get_num_connections() + self._compressed.get_num_connections() > 0

    def publish(self, frame, header):
        """Publish a frame, (h, w, 3) BGR uint8, to whom listens."""
        for publisher, message in self.messages(frame, header):
            publisher.publish(message)

    def messages(self, frame, header):
        """(rospy.Publisher, message) of a frame, (h, w, 3) BGR uint8, for each to whom somebody listens."""
        found = []
        if self._raw.get_num_connections():
            found.append((self._raw, image_from_frame(frame, header, self._encoding)))
        if self._compressed.get_num_connections():
            found.append((self._compressed, compressed_from_frame(frame, header, self.quality)))
        return found


class Listener(rospy.SubscribeListener):
    """Calls a function, from any thread, when somebody comes to listen or goes."""

    def __init__(self, on_change):
        super().__init__()
        self._on_change = on_change

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        self._on_change()

    def peer_unsubscribe(self, topic_name, num_peers):
        self._on_change()
