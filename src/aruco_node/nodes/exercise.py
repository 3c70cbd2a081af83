"""An exercise as a node."""
from aruco_ar.exercise import PICTURE, TRACKER

from aruco_node.parameters.settings import TOPIC, AreaSettings, PictureSettings, Settings
from aruco_node.process.memory import keep_memory

from .camera_node import CameraNode
from .manual import camera_manual
from .node import run_node


def run(exercise):
    """Run an Exercise of aruco_ar as a node until ROS shuts down.

    Its step is called only while somebody listens, and only with the newest frame. The image that it makes is
    published as ~image, or whatever its topics are called.
    """
    keep_memory()
    needs, topics = exercise.needs, exercise.topics
    kind = PictureSettings if PICTURE in needs else AreaSettings if TRACKER in needs else Settings
    screen = [('TOPIC', 'sensor_msgs/Image', 'with ~picture %sTOPIC' % TOPIC)] if PICTURE in needs else []
    run_node(exercise.name, lambda: _ExerciseNode(exercise, kind).spin(),
             camera_manual(topics, kind, TRACKER in needs, screen))


class _ExerciseNode(CameraNode):
    """Calls an exercise's step with each frame, and publishes what it returns."""

    def __init__(self, exercise, kind_of_settings):
        self._exercise = exercise
        super().__init__(exercise.needs, exercise.topics, kind_of_settings)

    def step(self, scene, header):
        return self._exercise.step(scene)
