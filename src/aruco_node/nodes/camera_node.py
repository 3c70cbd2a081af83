"""A node that looks at each frame of a camera once, and publishes what it makes of it."""
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any, Callable, Dict, Optional, Sequence

import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.hints.hints import Hints
from aruco_ar.painting.picture_file import resize
from aruco_ar.tracking.no_area import NEVER_SEEN
from sensor_msgs.msg import CameraInfo
from std_srvs.srv import Trigger, TriggerResponse
from unit5.msg import TagArray

from aruco_node.health.diagnostics import ERROR, NO_TAG, NO_TAGS_S, WARN
from aruco_node.health.faults import fault_barrier, log_once, note_fault
from aruco_node.messages.annotations import annotations, kinds
from aruco_node.messages.camera_info import NO_CALIBRATION
from aruco_node.messages.images import check_size, tags_from_pixels
from aruco_node.parameters.parameters import read, ros_values
from aruco_node.parameters.settings import LensSettings, load_areas

from .camera_lens import NO_CAMERA_INFO, CameraLens
from .frame_node import Answer, FrameNode
from .wall_saving import save_walls


@dataclass(frozen=True)
class CameraAnswer(Answer):
    """An Answer of a CameraNode.

    ``problems``: sentences about what is wrong, by kind; ``publish`` may still add some. ``hint``: a sentence
    about what the user may have overlooked, or None. ``work``: functions that look for more of that, in
    another thread.
    """

    problems: Dict[str, str] = field(default_factory=dict)
    hint: Optional[str] = None
    work: Sequence[Callable[[], None]] = ()


class CameraNode(FrameNode):
    """Has a runner of aruco_ar look at each frame, and publishes what goes with the image, and hints.

    What goes with it are the tags, marks for a viewer, and the camera's calibration.

    ``runner``: a Runner or a PoseRunner. ``lens``: the Lens of the last frame, or None if the camera's
    calibration is not known; ``lens_fault`` is an InputError that says why. A subclass implements ``look``
    and ``answer_to``.
    """

    needs_calibration = False  # whether there is no result without it
    without_lens = 'The lens is taken to be free of distortion: %s.'  # while the calibration is not known

    def __init__(self, topics, kind_of_settings, tracks, new_runner):
        """``topics``: private names of the images. ``kind_of_settings``: the class of the parameters.

        ``tracks``: whether areas are tracked. ``new_runner``: a function of the settings of each area that
        makes the runner. Raises InputError if a parameter is not valid.
        """
        super().__init__(topics, kind_of_settings, looks_for_tags=True)
        self._areas: list[dict[str, object]] = [{}]  # for each area, the parameters that only it has
        if getattr(self.settings, 'areas', 'none') != 'none':
            self._areas = load_areas(self.settings.areas)
        self.runner = new_runner(self._settings_of_areas(self.settings))
        self._tracks, self._sight = tracks, None  # the Sight of the last frame
        self._hints, self._worker = self._new_hints(self.settings), ThreadPoolExecutor(1, 'hints')
        self._tags = self.advertise('~tags', TagArray)
        self._infos = self.advertise('~camera_info', CameraInfo)
        self._annotations: Any = None  # a rospy.Publisher
        try:
            self._annotations = self.advertise('~annotations', kinds().ImageAnnotations)
        except InputError as error:
            rospy.logwarn('There is no ~annotations. %s', error)
        self._missed_tags = False  # whether it was logged that no tag is in sight
        self._warning, self._problems = None, {}  # what the user may have overlooked; what is wrong, by kind
        self._uses_lens = isinstance(self.settings, LensSettings)
        self._calibration = CameraLens(self.settings if self._uses_lens else LensSettings(), self.camera)
        self.lens = self.lens_fault = None

    def look(self, frame, stamp, is_searched):
        """(the Sight of a frame, what the runner makes of it).

        ``is_searched``: whether the frame must stay as it is, since it may be searched in another thread.
        """
        raise NotImplementedError

    def answer_to(self, sight, made, header):
        """The CameraAnswer with what the runner made of a frame. What goes with the image is added."""
        raise NotImplementedError

    def process(self, frame, header, stamp):
        self._update_lens(frame)
        self._sight, made = sight, _ = self.look(frame, stamp, self._hints.may_search(stamp))
        answer = self.answer_to(sight, made, header)
        self._hint([*self._hints.update(sight), *answer.work], answer.hint)

        def publish():
            answer.publish()
            for kind, problem in answer.problems.items():
                log_once(kind, problem, rospy.logwarn)
            self._problems = answer.problems
            self._publish_beside_images(sight, header)
        return replace(answer, publish=publish, tags_in_sight=len(sight.tags),
                       has_area=any(seen.area is not None for seen in sight.areas))

    def _publish_beside_images(self, sight, header):
        if self._infos.get_num_connections():
            info = self._calibration.info(sight.frame.shape[1::-1], header, self.settings.scale)
            if info is not None:
                self._infos.publish(info)
        if self._annotations is not None and self._annotations.get_num_connections():
            areas = [seen.area for seen in sight.areas if seen.area is not None]
            self._annotations.publish(annotations(sight.tags, areas, header.stamp))
        if self._tags.get_num_connections():
            self._tags.publish(tags_from_pixels(sight.tags, header))

    def update_subscriptions(self, wanted):
        super().update_subscriptions(wanted)
        self._calibration.update_subscription(
            wanted and (self._uses_lens or self._infos.get_num_connections() > 0))

    def report(self):
        level, sentence, values = super().report()
        if self._tracks:
            areas = self._sight.areas if self._sight else []
            values['area'] = ' '.join(seen.explanation for seen in areas) or NEVER_SEEN
        if not self.is_receiving:  # what follows is true of the frames that arrive
            self._missed_tags = False
            return level, sentence, values
        fault = self.lens_fault  # read once: another thread may change it
        if fault is not None:
            values['lens'] = self.explain(fault)
        warning = self._warning
        self._log_missing_tags(warning)
        if warning:
            values['hint'] = warning
            if level < ERROR:
                level, sentence = WARN, warning
        for kind, hint in self._hints.notes.items():
            values[kind] = hint
        problem = next(iter(self._problems.values()), None)
        # It matters more than dropped frames, but less than an error.
        return (WARN, problem, values) if problem and level < ERROR else (level, sentence, values)

    def decode(self, message):
        frame, scale = super().decode(message), self.settings.scale
        if scale == 1.0:
            return frame
        check_size(*(scale * side for side in frame.shape[1::-1]))
        return resize(frame, scale)

    def forget_last_frames(self):
        self._hints.reset()
        self.lens = self.lens_fault = self._warning = None
        self._problems = {}

    def explain(self, fault):
        """A sentence about an InputError that says why the lens is not known."""
        return self.without_lens % fault

    def prepare(self, settings):
        if all('picture' in own for own in self._areas) and settings.picture != self.settings.picture:
            raise InputError('The parameter ~picture has no effect: the file that ~areas names gives each area '
                             'a picture of its own. Change the picture in that file, and start the node again.')
        runner = self.runner.changed(self._settings_of_areas(settings))
        same = settings.of_detector() == self.settings.of_detector() and \
            getattr(settings, 'upright', None) == getattr(self.settings, 'upright', None)
        hints = self._hints if same else self._new_hints(settings)

        def apply():
            self._hints, self.runner = hints, runner
        return apply

    def reset(self):
        """Forget what was learned from frames. Called between two frames."""
        self.runner.reset()

    def offer_services(self):
        super().offer_services()
        if self._tracks:
            rospy.Service('~reset', Trigger, self._on_reset, error_handler=note_fault)
            rospy.Service('~save_wall', Trigger, self._on_save_wall, error_handler=note_fault)

    def _update_lens(self, frame):
        if not self._uses_lens:
            return
        self.lens = self.lens_fault = None
        try:
            self.lens = self._calibration.lens(frame.shape[1::-1], self.settings.scale)
        except InputError as error:
            self.lens_fault = InputError('%s: %s' % (self._calibration.topic, error), kind=error.kind)
            if error.kind != NO_CAMERA_INFO:  # many cameras are not calibrated, which is no reason to warn
                is_usual = error.kind == NO_CALIBRATION and not self.needs_calibration
                log_once(error.kind, self.explain(self.lens_fault),
                         rospy.loginfo if is_usual else rospy.logwarn)

    def _new_hints(self, settings):
        of_areas = self._settings_of_areas(settings)
        ids = [tag_id for own in of_areas for tag_id in own.ids] if all(own.ids for own in of_areas) else []
        return Hints({**of_areas[0].of_detector(), 'ids': ids}, getattr(settings, 'upright', None),
                     needs_area=not self.needs_calibration)

    def _hint(self, searches, hint):
        """Have hints looked for, and log what a user may have overlooked, if there is anything, once."""
        for work in searches:  # in another thread, since it takes so long that frames would be late
            self._worker.submit(fault_barrier(work))
        warning = self._warning = self._hints.warning or hint
        if warning:  # once for each remedy, which is the last word, since the tags may change with each frame
            log_once(warning.rpartition(' ')[2], warning, rospy.logwarn)
        for kind, hint in self._hints.notes.items():
            log_once(kind, hint, rospy.loginfo)

    def _log_missing_tags(self, warning):
        """Log that no tag has been in sight for long, once each time, unless a warning says why."""
        before, self._missed_tags = self._missed_tags, self._count.misses_tags and not warning
        if self._missed_tags and not before:
            rospy.logwarn('%s%d s.', NO_TAG, NO_TAGS_S)

    def _settings_of_areas(self, settings):
        """The settings of each area: its own parameters, and the node's for all others."""
        values = ros_values(settings)
        return [read(type(settings), {**values, **own}.get) for own in self._areas]

    def _on_reset(self, request):
        self.between_frames(self.reset)
        return TriggerResponse(True, 'What was learned about the wall is forgotten.')

    def _on_save_wall(self, request):
        learned: list[Any] = []
        try:
            self.between_frames(lambda: learned.extend(zip(self.runner.learned_walls(),
                                                           self._settings_of_areas(self.settings))))
            walls = [wall.remembered(own.dictionary, own.border) for wall, own in learned]
            return TriggerResponse(True, save_walls(walls, self.settings.folder))
        except InputError as error:
            return TriggerResponse(False, str(error))
