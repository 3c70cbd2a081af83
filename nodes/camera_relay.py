#!/usr/bin/env python3
"""Republishes the frames of a camera, with its calibration.

On a robot it compresses them to JPEG, so that they fit through the network.
On a base station it decodes them, once for all nodes there.
"""
import aruco_program  # noqa: F401  before all else
from aruco_node.messages.camera_info import info_topics
from aruco_node.nodes.camera_lens import InfoSubscriber
from aruco_node.nodes.frame_node import CAMERA, Answer, FrameNode
from aruco_node.nodes.manual import CAMERA_TOPICS, FRAME_SERVICES, Manual, image_topics
from aruco_node.nodes.node import run_node
from aruco_node.parameters.settings import RelaySettings
from aruco_node.process.memory import keep_memory
from sensor_msgs.msg import CameraInfo

IMAGE, INFO = 'image_raw', 'camera_info'
EARLY_PERIODS = 0.25  # a frame may come this much before it is due, since stamps jitter


class CameraRelay(FrameNode):
    """Republishes frames, at the rate that the parameter ~rate allows."""

    viewing_hint = 'start base_station.launch, and open its page'

    def __init__(self):
        super().__init__([IMAGE], RelaySettings)
        self._set_quality(self.settings)
        self._info_publisher = self.advertise('~' + INFO, CameraInfo, is_enough=False)
        self._info, self._info_subscriber = None, InfoSubscriber(info_topics(self.camera), self._on_info)
        self._due = 0.0  # stamp at which the next frame is due, seconds

    def process(self, frame, header, stamp):
        info = self._info  # read once, since another thread replaces it

        def publish():
            if info is not None and self._info_publisher.get_num_connections():
                info.header = header
                self._info_publisher.publish(info)
        return Answer([frame], publish)

    def is_due(self, stamp):
        if not self.settings.rate:
            return True
        period = 1 / self.settings.rate
        if abs(stamp - self._due) > 2 * period:  # it is the first frame, or time has jumped
            self._due = stamp
        if stamp < self._due - EARLY_PERIODS * period:
            return False
        self._due += period
        return True

    def update_subscriptions(self, wanted):
        self._info_subscriber.update(wanted)

    def prepare(self, settings):
        return lambda: self._set_quality(settings)

    def _set_quality(self, settings):
        self.outputs[IMAGE].quality = int(settings.quality)

    def _on_info(self, message):
        self._info = message


if __name__ == '__main__':
    keep_memory()
    run_node('camera_relay', lambda: CameraRelay().spin(), Manual(
        [*CAMERA_TOPICS, (CAMERA.replace(IMAGE, INFO), 'sensor_msgs/CameraInfo',
                          'the calibration of the camera')],
        [*image_topics([IMAGE]), ('~' + INFO, 'sensor_msgs/CameraInfo', 'the same, for each frame')],
        FRAME_SERVICES, RelaySettings, 'robot'))
