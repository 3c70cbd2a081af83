"""A node that runs an exercise on a camera's frames."""
from concurrent.futures import ThreadPoolExecutor

import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.calibration.lens_check import LensCheck
from aruco_ar.exercise import TRACKER, TRACKER_PARAMETERS, Stage, detection
from aruco_ar.hints.hints import Hints
from aruco_ar.painting.picture import resize
from std_srvs.srv import Trigger, TriggerResponse
from unit5.msg import TagArray

from aruco_node.health.diagnostics import ERROR, NO_TAG, NO_TAGS_S, WARN
from aruco_node.health.faults import fault_barrier, log_once, note_fault
from aruco_node.messages.camera_info import NO_CALIBRATION
from aruco_node.messages.images import check_size, tags_from_pixels
from aruco_node.parameters.parameters import read, ros_values
from aruco_node.parameters.settings import LensSettings, load_areas

from .camera_lens import NO_CAMERA_INFO, CameraLens
from .frame_node import Answer, FrameNode
from .pictures import TopicPicture, open_picture


class CameraNode(FrameNode):
    """Runs an Exercise of aruco_ar on each frame, once for each area, and publishes the Results.

    What the exercise keeps from frame to frame is in a Stage of aruco_ar, one for each area.
    """

    needs_calibration = False  # whether there is no result without it

    def __init__(self, exercise, kind_of_settings):
        """``kind_of_settings``: the class of the parameters. Raises InputError if one is not valid."""
        super().__init__(exercise.topics, kind_of_settings, looks_for_tags=True)
        self._exercise = exercise
        self.frame_scale = 1.0  # factor by which the last frame was resized
        self._areas: list[dict[str, object]] = [{}]  # for each area, the parameters that only it has
        if getattr(self.settings, 'areas', 'none') != 'none':
            self._areas = load_areas(self.settings.areas)
        self._stages = [Stage(exercise.needs, of_area, open_picture)
                        for of_area in self._settings_of_areas(self.settings)]
        self._subscribed = set()  # the TopicPictures that may be subscribed
        self._hints = self._new_hints(self.settings)
        self._lens_check, self._worker = LensCheck(), ThreadPoolExecutor(1, 'hints')
        self._tags = self.advertise('~tags', TagArray)
        self._missed_tags = False  # whether it was logged that no tag is in sight
        self._calibration = None
        if isinstance(self.settings, LensSettings):
            self._calibration = CameraLens(self.settings, self.camera)
        self.lens = None  # the Lens of the last frame, or None if the camera's calibration is not known
        self.lens_fault = None  # an InputError that says why not

    def process(self, frame, header, stamp):
        self._update_lens(frame)
        # Each area, and what hints are about, is searched for in the frame as the camera sent it.
        image = frame.copy() if len(self._stages) > 1 or self._hints.may_search(stamp) else frame
        results = []
        for stage in self._stages:
            results.append(self._exercise.step(stage.scene(frame, image, stamp, self.lens)))
            image = results[-1].images[-1]
        self._hint(frame, stamp, results)
        return self.answer(results, header)

    def answer(self, results, header):
        """The Answer made of the Results, one for each area. The last one has the images with all areas."""
        tags = [tag for result in results for tag in result.tags]

        def publish():
            if self._tags.get_num_connections():
                self._tags.publish(tags_from_pixels([(tag.id, tag.corners) for tag in tags], header))
        return Answer(results[-1].images, publish, tags_in_sight=len(tags),
                      has_area=any(result.area is not None for result in results))

    def report(self):
        level, sentence, values = super().report()
        if TRACKER in self._exercise.needs:
            values['area'] = ' '.join(stage.tracker.explanation for stage in self._stages if stage.tracker)
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
        return level, sentence, values

    def decode(self, message):
        frame = super().decode(message)
        self.frame_scale = self.settings.scale  # read once: another thread may change the settings
        if self.frame_scale == 1.0:
            return frame
        check_size(*(self.frame_scale * side for side in frame.shape[1::-1]))
        return resize(frame, self.frame_scale)

    def is_wanted(self):
        return super().is_wanted() or self._tags.get_num_connections() > 0

    def update_subscriptions(self, wanted):
        # Only this thread subscribes and unsubscribes.
        pictures = self._topic_pictures()
        for picture in self._subscribed - set(pictures):
            picture.update_subscription(False)
        for picture in pictures:
            picture.update_subscription(wanted)
        self._subscribed = set(pictures)
        if self._calibration is not None:
            self._calibration.update_subscription(wanted)

    def forget_last_frames(self):
        self._hints.reset()
        self.lens = self.lens_fault = None

    def explain(self, fault):
        """A sentence about an InputError that says why the lens is not known."""
        return 'The lens is taken to be free of distortion: %s.' % fault

    def prepare(self, settings):
        if all('picture' in own for own in self._areas) and settings.picture != self.settings.picture:
            raise InputError('The parameter ~picture has no effect: the file that ~areas names gives each area '
                             'a picture of its own. Change the picture in that file, and start the node again.')
        stages = [stage.changed(of_area)
                  for stage, of_area in zip(self._stages, self._settings_of_areas(settings))]
        same = all(getattr(settings, name, None) == getattr(self.settings, name, None)
                   for name in TRACKER_PARAMETERS)
        hints = self._hints if same else self._new_hints(settings)

        def apply():
            self._hints, self._stages = hints, stages
        return apply

    def reset(self):
        """Forget what was learned from frames. Called between two frames."""
        for stage in self._stages:
            stage.reset()

    def offer_services(self):
        super().offer_services()
        if TRACKER in self._exercise.needs:
            rospy.Service('~reset', Trigger, self._on_reset, error_handler=note_fault)

    def _update_lens(self, frame):
        if self._calibration is None:
            return
        self.lens = self.lens_fault = None
        try:
            self.lens = self._calibration.lens(frame.shape[1::-1], self.frame_scale)
        except InputError as error:
            self.lens_fault = InputError('%s: %s' % (self._calibration.topic, error), kind=error.kind)
            if error.kind != NO_CAMERA_INFO:  # many cameras are not calibrated, which is no reason to warn
                is_usual = error.kind == NO_CALIBRATION and not self.needs_calibration
                log_once(error.kind, self.explain(self.lens_fault),
                         rospy.loginfo if is_usual else rospy.logwarn)

    def _new_hints(self, settings):
        of_areas = self._settings_of_areas(settings)
        ids = [tag_id for of_area in of_areas for tag_id in of_area.ids] \
            if all(of_area.ids for of_area in of_areas) else []
        return Hints({**detection(of_areas[0]), 'ids': ids}, getattr(settings, 'upright', None))

    def _hint(self, frame, stamp, results):
        """Log what a user may have overlooked, if there is anything, once."""
        tags = [tag for result in results for tag in result.tags]
        tags += [tag for stage in self._stages if stage.tracker for tag in stage.tracker.repeated]
        work = self._hints.update(frame, stamp, tags, [result.area for result in results], self._shortfall())
        if self.needs_calibration:
            work += self._lens_checks(stamp, tags)
        for each in work:  # it takes so long that frames would be late
            self._worker.submit(fault_barrier(each))
        warning = self._warning
        if warning:  # once for each remedy, which is the last word, since the tags may change with each frame
            log_once(warning.rpartition(' ')[2], warning, rospy.logwarn)
        for kind, hint in self._hints.notes.items():
            log_once(kind, hint, rospy.loginfo)

    def _shortfall(self):
        """Why the tags in sight span no area, if there is to be one only; None if poses are wanted."""
        trackers = [stage.tracker for stage in self._stages if stage.tracker]
        return trackers[0].shortfall if len(trackers) == 1 and not self.needs_calibration else None

    def _log_missing_tags(self, warning):
        """Log that no tag has been in sight for long, once each time, unless a warning says why."""
        before, self._missed_tags = self._missed_tags, self._count.misses_tags and not warning
        if self._missed_tags and not before:
            rospy.logwarn('%s%d s.', NO_TAG, NO_TAGS_S)

    @property
    def _warning(self):
        return self._hints.warning or self._lens_check.hint

    def _lens_checks(self, stamp, tags):
        """What finds out whether the calibration fits the tags of the usual size."""
        others = {tag_id for tag_id, _ in self.settings.tag_sizes}
        check = self._lens_check.update(stamp, [tag for tag in tags if tag.id not in others], self.lens)
        return [] if check is None else [check]

    def _topic_pictures(self):
        return [stage.source for stage in self._stages if isinstance(stage.source, TopicPicture)]

    def _settings_of_areas(self, settings):
        """The settings of each area: its own parameters, and the node's for all others."""
        values = ros_values(settings)
        return [read(type(settings), {**values, **own}.get) for own in self._areas]

    def _on_reset(self, request):
        self.between_frames(self.reset)
        return TriggerResponse(True, 'What was learned about the wall is forgotten.')
