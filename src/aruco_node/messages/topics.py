"""Names and types of image topics."""

IMAGE_TYPES = {'raw': 'sensor_msgs/Image', 'compressed': 'sensor_msgs/CompressedImage'}
SUFFIX = '/compressed'


def raw_topic(topic):
    """The name of a camera's raw images, of those or of its compressed ones."""
    return topic[:-len(SUFFIX)] if topic.endswith(SUFFIX) else topic
