"""Names and types of image topics."""

IMAGE_TYPES = {'raw': 'sensor_msgs/Image', 'compressed': 'sensor_msgs/CompressedImage'}
SUFFIX = '/compressed'


def raw_topic(topic):
    """The name of a camera's raw image topic, given that or the name of its compressed one."""
    return topic[:-len(SUFFIX)] if topic.endswith(SUFFIX) else topic
