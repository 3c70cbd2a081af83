"""Runs an exercise as a node."""
from aruco_ar.exercise import LENS, PICTURE, TRACKER

from aruco_node.parameters.settings import TOPIC, AreaSettings, LensSettings, PictureSettings, TagSettings
from aruco_node.process.memory import keep_memory

from .camera_node import CameraNode
from .manual import camera_manual
from .node import run_node


def run(exercise):
    """Run an Exercise of aruco_ar as a node until ROS shuts down.

    Its step is called only while somebody listens, and only with the newest frame. The images that it returns
    are published on the exercise's topics, by default ~image.
    """
    keep_memory()
    needs = exercise.needs
    kinds = {PICTURE: PictureSettings, TRACKER: AreaSettings, LENS: LensSettings}
    kind = next((kinds[need] for need in kinds if need in needs), TagSettings)
    screen = [('TOPIC', 'sensor_msgs/Image', 'with ~picture %sTOPIC' % TOPIC)] if PICTURE in needs else []
    run_node(exercise.name, lambda: CameraNode(exercise, kind).spin(),
             camera_manual(exercise.topics, kind, TRACKER in needs, screen))
