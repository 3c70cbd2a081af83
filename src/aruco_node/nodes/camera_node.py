"""A node that looks for tags, and for the areas between them, in a camera's frames."""
import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.exercise import TRACKER, Stage
from aruco_ar.painting.picture import resize
from std_srvs.srv import Trigger, TriggerResponse
from unit5.msg import TagArray

from aruco_node.health.faults import note_fault
from aruco_node.messages.images import check_size, tags_from_pixels
from aruco_node.parameters.parameters import read, ros_values
from aruco_node.parameters.settings import load_areas

from .frame_node import FrameNode
from .pictures import TopicPicture, open_picture


class CameraNode(FrameNode):
    """Answers the newest frame of the camera with what it shows, while somebody listens.

    A subclass says by ``step`` what it makes of that. ``needs``: see Exercise in aruco_ar.
    ``topics``, ``kind_of_settings``: see FrameNode.
    """

    scale = 1.0  # by which the frame was resized
    tags_in_sight, has_area = 0, False

    def __init__(self, needs, topics, kind_of_settings):
        super().__init__(topics, kind_of_settings)
        self._tracks = TRACKER in needs
        self._areas: list[dict[str, object]] = [{}]  # of each area, the parameters that are its own
        if getattr(self.settings, 'areas', 'none') != 'none':
            self._areas = load_areas(self.settings.areas)
        self._stages = [Stage(needs, of_area, open_picture) for of_area in self._of_areas(self.settings)]
        self._seen = []  # the tags in sight
        self._tags = self.advertise('~tags', TagArray)

    def step(self, scene, header):
        """The Result of a Scene, both of aruco_ar.exercise. ``header``: the frame's."""
        raise NotImplementedError

    def look(self, frame, header, stamp):
        # Each area is looked for in the frame as it came, whatever was painted into others.
        image = frame if len(self._stages) == 1 else frame.copy()
        results = []
        for stage in self._stages:
            results.append(self.step(stage.scene(frame, image, stamp), header))
            image = results[-1].images[-1]
        self._seen = [tag for result in results for tag in result.tags]
        self.tags_in_sight = len(self._seen)
        self.has_area = any(result.area is not None for result in results)
        return results[-1].images

    def report(self):
        level, sentence, values = super().report()
        if self._tracks:
            values['area'] = ' '.join(stage.tracker.explanation for stage in self._stages if stage.tracker)
        return level, sentence, values

    def to_frame(self, message):
        frame = super().to_frame(message)
        self.scale = self.settings.scale  # which another thread may change meanwhile
        if self.scale == 1.0:
            return frame
        check_size(*(self.scale * side for side in frame.shape[1::-1]))
        return resize(frame, self.scale)

    def publish(self, messages, header):
        super().publish(messages, header)
        if self._tags.get_num_connections():
            self._tags.publish(tags_from_pixels([(tag.id, tag.corners) for tag in self._seen], header))

    def is_wanted(self):
        return super().is_wanted() or self._tags.get_num_connections() > 0

    def follow(self, wanted):
        for picture in self._topic_pictures():
            picture.follow(wanted)

    def prepare(self, settings):
        if all('picture' in own for own in self._areas) and settings.picture != self.settings.picture:
            raise InputError('Each area has a picture of its own, in the file that ~areas names.')
        stages = [stage.changed(of_area) for stage, of_area in zip(self._stages, self._of_areas(settings))]

        def change():
            before, self._stages = self._topic_pictures(), stages
            for picture in set(before) - set(self._topic_pictures()):
                picture.follow(False)
        return [change]

    def reset(self):
        """Forget what was learned from frames."""
        for stage in self._stages:
            stage.reset()

    def serve(self):
        super().serve()
        if self._tracks:
            rospy.Service('~reset', Trigger, self._on_reset, error_handler=note_fault)

    def _topic_pictures(self):
        return [stage.source for stage in self._stages if isinstance(stage.source, TopicPicture)]

    def _of_areas(self, settings):
        """The Settings of each area: its own before the node's."""
        values = ros_values(settings)
        return [read(type(settings), {**values, **own}.get) for own in self._areas]

    def _on_reset(self, request):
        self.reset()
        return TriggerResponse(True, 'What was learned about the wall is forgotten.')
