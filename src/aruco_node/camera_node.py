"""A node that looks for tags, and for the areas between them, in a camera's frames."""
import rospy
from aruco_ar.errors import InputError
from aruco_ar.files import package_folder
from aruco_ar.picture import resize
from std_srvs.srv import Trigger, TriggerResponse
from unit5.msg import TagArray

from .faults import note_fault
from .frame_node import FrameNode
from .inputs import Inputs
from .messages import check_size, tags_from_pixels
from .parameters import plain, read
from .settings import load_areas


class CameraNode(FrameNode):
    """Answers the newest frame of the camera with what it shows, while somebody listens.

    A subclass says by ``answer`` what it makes of that. ``takes``: see Inputs.
    ``topics``, ``kind_of_settings``: see FrameNode.
    """

    scale = 1.0  # by which the frame was resized
    tags_in_sight, has_area = 0, False

    def __init__(self, takes, topics, kind_of_settings):
        super().__init__(topics, kind_of_settings)
        self._learns = 'area' in takes
        self._areas: list[dict[str, object]] = [{}]  # of each area, the parameters that are its own
        if getattr(self.settings, 'areas', 'none') != 'none':
            self._areas = load_areas(self.settings.areas)
        self._inputs = [Inputs(takes, of_area, package_folder()) for of_area in self._of_areas(self.settings)]
        self._tags = self.advertise('~tags', TagArray)

    def answer(self, frame, given, header, stamp):
        """The images to publish, one for each topic, as ``look`` gives them.

        ``given``: for each area, a list of what the node takes.
        """
        raise NotImplementedError

    def look(self, frame, header, stamp):
        given = [inputs.at(frame, stamp) for inputs in self._inputs]
        self.tags_in_sight = sum(len(inputs.tags) for inputs in self._inputs)
        self.has_area = any(inputs.has_area for inputs in self._inputs)
        return self.answer(frame, given, header, stamp)

    def report(self):
        level, sentence, values = super().report()
        if self._learns:
            values['area'] = ' '.join(inputs.why for inputs in self._inputs)
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
            self._tags.publish(tags_from_pixels([(tag.id, tag.corners) for inputs in self._inputs
                                                 for tag in inputs.tags], header))

    def is_wanted(self):
        return super().is_wanted() or self._tags.get_num_connections() > 0

    def follow(self, wanted):
        for inputs in self._inputs:
            inputs.follow(wanted)

    def prepare(self, settings):
        if all('picture' in own for own in self._areas) and settings.picture != self.settings.picture:
            raise InputError('Each area has a picture of its own, in the file that ~areas names.')
        return [inputs.prepare(of_area) for inputs, of_area in zip(self._inputs, self._of_areas(settings))]

    def reset(self):
        """Forget what was learned from frames."""
        for inputs in self._inputs:
            inputs.reset()

    def serve(self):
        super().serve()
        if self._learns:
            rospy.Service('~reset', Trigger, self._on_reset, error_handler=note_fault)

    def _of_areas(self, settings):
        """The Settings of each area: its own before the node's."""
        values = plain(settings)
        return [read(type(settings), {**values, **own}.get) for own in self._areas]

    def _on_reset(self, request):
        self.reset()
        return TriggerResponse(True, 'What was learned about the wall is forgotten.')
