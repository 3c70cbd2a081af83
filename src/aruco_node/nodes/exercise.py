"""Runs an exercise as a node."""
from aruco_ar.exercise import AREA, LENS, PICTURE
from aruco_ar.runner import Runner

from aruco_node.parameters.settings import TOPIC, AreaSettings, LensSettings, PictureSettings, TagSettings
from aruco_node.process.memory import keep_memory

from .camera_node import CameraAnswer, CameraNode
from .manual import camera_manual
from .node import run_node
from .pictures import TopicPicture, open_picture


def run(exercise):
    """Run an Exercise of aruco_ar as a node until ROS shuts down.

    Its step is called only while somebody listens, and only with the newest frame. The images that it returns
    are published on the exercise's topics, by default ~image.
    """
    keep_memory()
    needs = exercise.needs
    kinds = {PICTURE: PictureSettings, AREA: AreaSettings, LENS: LensSettings}
    kind = next((kinds[need] for need in kinds if need in needs), TagSettings)
    screen = [('TOPIC', 'sensor_msgs/Image', 'with ~picture %sTOPIC' % TOPIC)] if PICTURE in needs else []
    run_node(exercise.name, lambda: ExerciseNode(exercise, kind).spin(),
             camera_manual(exercise.topics, kind, AREA in needs, screen))


class ExerciseNode(CameraNode):
    """Runs an Exercise on each frame, and publishes its images."""

    def __init__(self, exercise, kind_of_settings):
        super().__init__(exercise.topics, kind_of_settings, AREA in exercise.needs,
                         lambda settings: Runner(exercise, settings, open_picture, in_thread=True))
        self._subscribed = set()  # the TopicPictures that may be subscribed

    def look(self, frame, stamp, is_searched):
        return self.runner.run(frame, stamp, self.lens, is_searched)

    def answer_to(self, sight, images, header):
        return CameraAnswer(images)

    def update_subscriptions(self, wanted):
        super().update_subscriptions(wanted)
        # Only this thread subscribes and unsubscribes.
        pictures = [source for source in self.runner.sources if isinstance(source, TopicPicture)]
        for picture in self._subscribed - set(pictures):
            picture.update_subscription(False)
        for picture in pictures:
            picture.update_subscription(wanted)
        self._subscribed = set(pictures)
