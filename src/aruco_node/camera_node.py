"""A node that looks at a camera's frames: topics, parameters, services, and everything that can go wrong."""
import threading
import time
from typing import Sequence

import rospy
from aruco_ar.errors import InputError
from aruco_ar.files import package_folder
from aruco_ar.picture import resize
from std_srvs.srv import Trigger, TriggerResponse
from unit5.msg import TagArray

from .connections import more_comes
from .faults import guarded, note_fault, say_once
from .health import ERROR, OK, Diagnostics, FrameCount
from .inputs import Inputs
from .lateness import Lateness
from .master import is_there, published_topics
from .messages import BUFFER_BYTES, TRANSPORTS, check_size, tags_from_pixels
from .node import parameter
from .parameters import plain, read
from .publishing import ImagePublisher, Listener
from .reconfigure import Reconfigurer
from .settings import load_areas
from .snapshot import Snapshot
from .stamps import is_time
from .waiting import SILENCE_S, explain_silence

CAMERA = 'camera/rgb/image_raw'


class CameraNode:
    """Answers the newest frame of the camera, while somebody listens.

    A subclass says by ``answer`` what it makes of a frame. ``takes``: see
    Inputs. ``topics``: of the images that it makes. ``kind_of_settings``: the
    class of its parameters.
    """

    results: Sequence[str] = ()  # names of the topics of more than images, for who asks why nothing comes
    scale = 1.0  # by which the frame was resized
    ready = True  # whether what is made of frames is all that there will be: a snapshot waits for that

    def __init__(self, takes, topics, kind_of_settings):
        self.settings = read(kind_of_settings, parameter)
        self._areas: list[dict[str, object]] = [{}]  # of each area, the parameters that are its own
        if getattr(self.settings, 'areas', 'none') != 'none':
            self._areas = load_areas(self.settings.areas)
        self._inputs = [Inputs(takes, of_area, package_folder()) for of_area in self._of_areas(self.settings)]

        self.camera = rospy.resolve_name(CAMERA)
        suffix, self._kind, self._to_frame = TRANSPORTS[self.settings.transport]
        self._topic = self.camera + suffix
        self._subscriber = None
        self._last_sign = time.monotonic()  # of life from the camera
        self._waiting = None  # why nothing arrives, and whether that is all right
        self._unusable = None  # what is wrong with the last frame
        self.wake = threading.Event()
        self._outputs = {topic: ImagePublisher('~' + topic, self.wake.set) for topic in topics}
        self._tags = self.advertise('~tags', TagArray)
        self._count, self._lateness = FrameCount(), Lateness()
        self._diagnostics = Diagnostics(self.report)
        self._snapshot = Snapshot(self.wake.set)
        self._learns = 'area' in takes

    def answer(self, frame, given, header, stamp):
        """The images to publish, one for each topic; they are not where the frame turns out to be too old.

        ``frame``: (h, w, 3) BGR uint8, to write into. ``given``: for each
        area, a list of what the node takes. ``header``: the frame's.
        ``stamp``: its time, seconds.
        """
        raise NotImplementedError

    def publish(self, messages, header):
        """Publish what was made of a frame: (publisher, message) of the images, and the tags."""
        for publisher, message in messages:
            publisher.publish(message)
        if self._tags.get_num_connections():
            self._tags.publish(tags_from_pixels([(tag.id, tag.corners) for inputs in self._inputs
                                                 for tag in inputs.tags], header))

    def is_wanted(self):
        """Whether anybody listens to anything that comes of a frame."""
        return self._snapshot.wanted or self._tags.get_num_connections() > 0 or \
            any(output.has_listeners() for output in self._outputs.values())

    def is_seen(self, topic):
        """Whether anybody looks at the images of that topic."""
        return self._snapshot.wanted or self._outputs[topic].has_listeners()

    def follow(self, wanted):
        """Listen to what is needed besides the camera, or leave it; called about once a second."""
        for inputs in self._inputs:
            inputs.follow(wanted)

    def prepare(self, settings):
        """Functions that change over to other settings. Raises InputError if they cannot be."""
        return [inputs.prepare(of_area) for inputs, of_area in zip(self._inputs, self._of_areas(settings))]

    def reset(self):
        """Forget what was learned from frames."""
        for inputs in self._inputs:
            inputs.reset()

    def advertise(self, topic, kind):
        """A Publisher of messages of that kind; the node takes note of who comes to listen, and goes."""
        return rospy.Publisher(topic, kind, Listener(self.wake.set), queue_size=1)

    def spin(self):
        """Subscribe while somebody listens, and say so when nothing arrives, until shutdown."""
        self._snapshot.serve(lambda: self.settings.folder, lambda: self._why_nothing_arrives()[0])
        if self._learns:
            rospy.Service('~reset', Trigger, self._on_reset, error_handler=note_fault)
        Reconfigurer(self.settings, self._reconfigure)
        rospy.on_shutdown(self.wake.set)
        rospy.loginfo('Ready: %s -> %s', self._topic,
                      ', '.join(output.name for output in self._outputs.values()))
        while not rospy.is_shutdown():
            self._follow_listeners()
            if time.monotonic() - self._last_sign > SILENCE_S:
                self._explain_silence()
            self._diagnostics.update()
            self.wake.wait(1.0)
            self.wake.clear()

    def _of_areas(self, settings):
        """The Settings of each area: its own before the node's."""
        values = plain(settings)
        return [read(type(settings), {**values, **own}.get) for own in self._areas]

    def _reconfigure(self, settings):
        if all('picture' in own for own in self._areas) and settings.picture != self.settings.picture:
            raise InputError('Each area has a picture of its own, in the file that ~areas names.')
        for change in self.prepare(settings):
            change()
        self.settings = settings
        self.wake.set()

    def _on_reset(self, request):
        self.reset()
        return TriggerResponse(True, 'What was learned about the wall is forgotten.')

    @guarded
    def _follow_listeners(self):
        wanted = self.is_wanted()
        if wanted != (self._subscriber is not None) and not is_there():
            return  # rospy would wait for the master, and with it all that is done here
        self.follow(wanted)
        if wanted and self._subscriber is None:
            self._last_sign = time.monotonic()
            self._count.begin()
            self._subscriber = rospy.Subscriber(self._topic, self._kind, self._on_message,
                                                queue_size=1, buff_size=BUFFER_BYTES)
        elif not wanted and self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = self._unusable = None
            self._count.begin()

    def _why_nothing_arrives(self):
        """A sentence, and whether that is all right."""
        if self._unusable:
            return self._unusable, False
        try:
            published = published_topics()
        except InputError as error:
            return str(error), False
        own = [output.name for output in self._outputs.values()]
        if self._subscriber is None and published.get(self._topic) == self._kind._type:
            return 'Nobody listens to %s, so nothing is computed. To see it: open the page, or rosrun ' \
                   'image_view image_view image:=%s' % (', '.join([*self.results, *own]), own[-1]), True
        return explain_silence(self.camera, self.settings.transport, published,
                               own + [name + '/compressed' for name in own]), False

    @guarded
    def _explain_silence(self):
        """Say why nothing arrives, again only when the reason has become another."""
        self._last_sign = time.monotonic()  # look again after another SILENCE_S
        self._unusable = None  # that was before the silence
        waiting = self._why_nothing_arrives()
        if waiting != self._waiting:
            self._waiting = waiting
            sentence, is_right = waiting
            (rospy.loginfo if is_right else rospy.logwarn)('%s', sentence)

    def report(self):
        """How the node is doing: see Diagnostics."""
        level, sentence, values = self._count.report()
        if self._waiting:
            sentence, is_right = self._waiting
            level = OK if is_right else ERROR
        elif self._subscriber is None:
            level, sentence = OK, 'Nobody listens, so nothing is computed.'
        elif self._unusable:
            level, sentence = ERROR, self._unusable
        return level, sentence, values

    def _on_message(self, message):
        self._last_sign = began = time.monotonic()
        if self._waiting:
            self._waiting = None
            rospy.loginfo('Frames arrive on %s.', self._topic)
        try:
            self._look(message, began)
            self._unusable = None
        except InputError as error:
            self._unusable = str(error)
            say_once(error.kind, self._unusable)
        except Exception as error:  # a fault of ours: one frame is lost, not the node
            self._unusable = note_fault(error)

    def _look(self, message, began):
        """Publish what is made of a message that came at that time, monotonic; raises InputError."""
        missing = self._count.came(message.header.seq)
        header = message.header
        if not is_time(header.stamp):
            raise InputError('A frame has the stamp %d s, %d ns, which is no time; check the clock of the '
                             'camera driver.' % (header.stamp.secs, header.stamp.nsecs), kind='stamp')
        stamp = (header.stamp or rospy.Time.now()).to_sec()
        wait = self._lateness.begins(stamp, rospy.Time.now().to_sec(), missing)
        if wait and more_comes(self._subscriber, wait):
            self._count.left_out()  # the next frame will show the same, sooner
            return
        frame = self._to_frame(message)
        self.scale = self.settings.scale  # which another thread may change meanwhile
        if self.scale != 1.0:
            check_size(*(self.scale * side for side in frame.shape[1::-1]))
            frame = resize(frame, self.scale)
        given = [inputs.at(frame, stamp) for inputs in self._inputs]
        self._snapshot.before(frame)
        images = dict(zip(self._outputs, self.answer(frame, given, header, stamp)))
        if self.ready:
            self._snapshot.after(images)
        messages = [each for topic, image in images.items()
                    for each in self._outputs[topic].messages(image, header)]
        if self._lateness.is_late(rospy.Time.now().to_sec()) and more_comes(self._subscriber):
            self._count.left_out()
            return
        self.publish(messages, header)
        self._count.answered(began, header.stamp, missing, sum(len(inputs.tags) for inputs in self._inputs),
                             any(inputs.has_area for inputs in self._inputs))
