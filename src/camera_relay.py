#!/usr/bin/env python3
"""Hands the frames of a camera on, with its calibration.

On a robot as JPEG, so that they go through its network; on a base station
decoded, once for all nodes there.
"""
import aruco_program  # noqa: F401  before all else
import rospy
from aruco_node.nodes.calibration import info_topic
from aruco_node.nodes.frame_node import CAMERA, FrameNode
from aruco_node.nodes.manual import CAMERA_TOPICS, FRAME_SERVICES, Manual, image_topics
from aruco_node.nodes.node import run_node
from aruco_node.parameters.settings import RelaySettings
from aruco_node.process.memory import keep_memory
from aruco_node.ros_internals.tolerant import tolerant
from sensor_msgs.msg import CameraInfo

IMAGE, INFO = 'image_raw', 'camera_info'
EARLY = 0.25  # of a period, which a frame may come before its time


class CameraRelay(FrameNode):
    """Publishes what it gets, as often as it is told."""

    advice = 'start base_station.launch, and open its page'

    def __init__(self):
        super().__init__([IMAGE], RelaySettings)
        self._outputs[IMAGE].quality = int(self.settings.quality)
        self._calibrations = self.advertise('~' + INFO, CameraInfo)
        self._calibration = self._listening = None
        self._due = 0.0

    def look(self, frame, header, stamp):
        return [frame]

    def is_due(self, stamp):
        if not self.settings.rate:
            return True
        period = 1 / self.settings.rate
        if abs(stamp - self._due) > 2 * period:  # it is the first, or time has jumped
            self._due = stamp
        if stamp < self._due - EARLY * period:
            return False
        self._due += period
        return True

    def follow(self, wanted):
        if wanted and self._listening is None:
            self._listening = rospy.Subscriber(info_topic(self.camera), tolerant(CameraInfo),
                                               self._on_calibration, queue_size=1)
        elif not wanted and self._listening is not None:
            self._listening.unregister()
            self._listening = None

    def publish(self, messages, header):
        if self._calibration is not None and self._calibrations.get_num_connections():
            self._calibration.header = header
            self._calibrations.publish(self._calibration)
        super().publish(messages, header)

    def prepare(self, settings):
        def change():
            self._outputs[IMAGE].quality = int(settings.quality)
        return [change]

    def _on_calibration(self, message):
        self._calibration = message


if __name__ == '__main__':
    keep_memory()
    run_node('camera_relay', lambda: CameraRelay().spin(), Manual(
        [*CAMERA_TOPICS, (CAMERA.replace(IMAGE, INFO), 'sensor_msgs/CameraInfo', 'beside the images')],
        [*image_topics([IMAGE]), ('~' + INFO, 'sensor_msgs/CameraInfo', 'that of each frame')],
        FRAME_SERVICES, RelaySettings, 'robot'))
