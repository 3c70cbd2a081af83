"""The choices on the page: which picture is painted and how, which tags count, and how the simulation looks."""
import asyncio
import gc
import os
import re
import threading
from concurrent.futures import ThreadPoolExecutor

import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import package_folder
from aruco_ar.painting.picture_file import decode_picture, open_header, resize
from aruco_ar.painting.sources import open_source
from aruco_ar.settings.settings import FOREGROUNDS, GRAINS, LEARN, LIGHTS, TAGS
from aruco_ar.simulation.figures import NOBODY
from aruco_node.health.faults import fault_barrier
from aruco_node.messages.images import image_from_frame, jpeg_from_frame
from aruco_node.parameters.parameters import read, ros_values
from aruco_node.parameters.settings import TOPIC, PictureSettings
from aruco_node.ros_internals.subscribers import tolerant
from dynamic_reconfigure.msg import Config, DoubleParameter, StrParameter
from dynamic_reconfigure.srv import Reconfigure
from PIL.Image import DecompressionBombError
from sensor_msgs.msg import Image
from std_msgs.msg import Header
from std_srvs.srv import Trigger

EXERCISES = 'exercise5_2', 'exercise5_3', 'exercise5_4', 'exercise5_5', 'exercise5_6'
PAINTER, SIMULATION = EXERCISES[-1:], ('wall_camera',)
# The nodes that have each parameter. Sliders set numbers, and fields set texts.
SLIDERS = {'opacity': PAINTER, 'noise': SIMULATION, 'falloff': SIMULATION}
FIELDS = {'fit': PAINTER, 'dictionary': EXERCISES, 'ids': EXERCISES}
# The nodes that have each switch's parameter, and its values for off and on.
SWITCHES = {'foreground': (PAINTER, FOREGROUNDS), 'light': (PAINTER, LIGHTS), 'grain': (PAINTER, GRAINS),
            'tags': (PAINTER, TAGS), 'visitor': (SIMULATION, (NOBODY, 'person'))}
# The switch that has a wall remembered: the nodes that then know it. Their parameter names its file.
WALL, KNOWING = 'wall', EXERCISES[:-3:-1]
SAVED = re.compile(r'Wrote (.+?)\. With wall:=\1,')  # in the answer of the service ~save_wall: see save_walls
FOLDER = 'images'
FORMATS = 'JPEG', 'PNG', 'WEBP', 'BMP'
MAX_BYTES = 16 * 1024 * 1024
MAX_PIXELS = 32 * 1000 * 1000
THUMBNAIL_PX = 160
ANSWER_S = 5.0


class RemoteParameters:
    """The parameters of another node, by dynamic_reconfigure. The node may be absent."""

    def __init__(self, name, on_change):
        self.name = rospy.resolve_name(name)
        self._values, self._on_change = {}, on_change
        self._updates = rospy.Subscriber(self.name + '/parameter_updates', tolerant(Config), self._on_update)
        self._service = rospy.ServiceProxy(self.name + '/set_parameters', Reconfigure)
        self._worker = ThreadPoolExecutor(1, name)  # each node has its own thread, so that none delays another
        self._lock, self._wanted, self._job = threading.Lock(), {}, None

    @property
    def values(self):
        """{parameter: value}; empty while the node is not running."""
        return dict(self._values) if self._updates.get_num_connections() else {}

    async def set(self, **values):
        """Set parameters, texts or numbers. Raises InputError if the node refuses them or does not answer.

        While the node works on one request, all further values are collected for the next one.
        """
        with self._lock:
            job = self._job if self._wanted else None
            self._wanted.update(values)
        if job is None:
            self._job = job = asyncio.get_event_loop().run_in_executor(self._worker, self._set_wanted)
        try:
            refused = await asyncio.wait_for(asyncio.shield(job), ANSWER_S)
        except asyncio.TimeoutError:
            raise InputError('%s does not answer. Start it, or look at its log.' % self.name) from None
        for name, value in values.items():
            if refused.get(name) == value:  # otherwise it is another request's value that is refused
                raise InputError('%s refuses "%s". Its log says why.' % (self.name, value))

    def _set_wanted(self):
        """Set all wanted values. Returns {name: text} of the texts that the node refuses."""
        with self._lock:
            values, self._wanted = self._wanted, {}
        config = Config()
        for name, value in values.items():
            if isinstance(value, str):
                config.strs.append(StrParameter(name, value))
            else:
                config.doubles.append(DoubleParameter(name, float(value)))
        try:
            taken = values_of(self._service(config).config)
        except rospy.ServiceException as error:
            why = error if self._updates.get_num_connections() else 'it is not running'
            raise InputError('%s does not answer: %s. Start it, or look at its log.'
                             % (self.name, why)) from None
        return {name: value for name, value in values.items()
                if isinstance(value, str) and taken.get(name) != value}

    @fault_barrier
    def _on_update(self, config):
        self._values = values_of(config)
        self._on_change()


def values_of(config):
    """{name: value} of a dynamic_reconfigure/Config."""
    return {item.name: item.value for item in config.strs + config.doubles}


class Choices:
    """What can be chosen, and what is chosen. All browsers share it."""

    def __init__(self, on_change):
        """``on_change`` is called, from any thread, when a choice has changed, on the page or elsewhere."""
        self._on_change = on_change
        self._worker = ThreadPoolExecutor(1, 'pictures')  # decodes and shrinks what is in memory
        # These wait for the file system, which may hang. The event loop never does.
        self._folder, self._reader = ThreadPoolExecutor(1, 'folder'), ThreadPoolExecutor(1, 'reader')
        self._saver = ThreadPoolExecutor(1, 'saver')  # waits for a node
        self._package = package_folder()
        self._files, self._listing = [], None
        self._nodes = {name: RemoteParameters(name, on_change) for name in EXERCISES + SIMULATION}
        self._dropped = rospy.Publisher('~picture', Image, queue_size=1, latch=True)
        self._thumbnails = {}
        self._drops = 0  # number of pictures that were dropped; only the last one can be chosen again
        self._choice = 0  # number of the last choice of a picture

    def state(self):
        """The part of the page's state with what can be chosen, and what is chosen."""
        values = {name: node.values for name, node in self._nodes.items()}

        def value(parameter, nodes):
            """The parameter's value in the first of these nodes that is running, or None."""
            return next((values[name][parameter] for name in nodes if parameter in values[name]), None)
        picture = value('picture', PAINTER)
        switches = {name: (value(name, nodes), on) for name, (nodes, (_, on)) in SWITCHES.items()}
        wall = value(WALL, KNOWING)
        return {'pictures': self.pictures(), 'picture': None if picture is None else self._name_of(picture),
                'sliders': _known({name: value(name, nodes) for name, nodes in SLIDERS.items()}),
                'fields': _known({name: value(name, nodes) for name, nodes in FIELDS.items()}),
                'switches': {**{name: now == on for name, (now, on) in switches.items() if now is not None},
                             **({} if wall is None else {WALL: wall != LEARN})}}

    def pictures(self):
        """The sorted names of the files in images/, and of the picture that was dropped last.

        The files are those of a moment ago; they are looked for again, and ``on_change`` is called if there are
        others.
        """
        self._look_for_files()
        return self._files + [self._drop_name()] * (self._drops > 0)

    def _look_for_files(self):
        """Read the names of the files again, in a thread. Returns its Future, of None."""
        if self._listing is None or self._listing.done():
            self._listing = self._folder.submit(self._read_folder)
        return self._listing

    @fault_barrier
    def _read_folder(self):
        files = files_in(os.path.join(self._package, FOLDER))
        if files != self._files:
            self._files = files
            self._on_change()

    async def choose(self, name):
        """Have the picture of that name painted, unless another one is chosen meanwhile.

        Raises InputError if there is none.
        """
        self._choice += 1
        choice = self._choice
        await self._check(name)
        if choice != self._choice:
            return
        await self._set(PAINTER, picture=self._drop_topic() if self._is_dropped(name) else
                        '%s/%s' % (FOLDER, name))

    async def drop(self, parts):
        """Have a new picture painted. ``parts``: a list with the bytes of its file, which is emptied.

        Raises InputError if they are not a usable picture.
        """
        picture = await _in(self._worker, self._publish, parts)
        self._thumbnails.pop(self._drop_name(), None)
        self._drops += 1
        self._choice += 1
        self._thumbnails[self._drop_name()] = _in(self._worker, _shrink, picture)
        await self._set(PAINTER, picture=self._drop_topic())

    async def slide(self, name, value):
        """Set one of SLIDERS. Other names and values are ignored. Raises InputError if no node has it."""
        if isinstance(name, str) and name in SLIDERS and isinstance(value, (int, float)) and abs(value) < 1e6:
            await self._set(SLIDERS[name], **{name: value})

    async def write(self, name, value):
        """Set one of FIELDS, in all nodes that have it.

        Other names are ignored. Raises InputError if the value is not allowed, or if no node has it.
        """
        if isinstance(name, str) and name in FIELDS and isinstance(value, str):
            taken = ros_values(read(PictureSettings, {name: value}.get))[name]  # refused here, with the reason
            await self._set(FIELDS[name], **{name: taken})

    async def switch(self, name, on):
        """Turn a switch on or off. Other names are ignored.

        Raises InputError if its node is not running, or if there is no wall to remember yet.
        """
        if name == WALL and isinstance(on, bool):
            wall = await self._save_wall() if on else LEARN
            await self._set(PAINTER, wall=wall)
            others = [name for name in KNOWING if name not in PAINTER and self._nodes[name].values]
            await asyncio.gather(*[self._set([name], wall=wall) for name in others])
        elif isinstance(name, str) and name in SWITCHES and isinstance(on, bool):
            nodes, values = SWITCHES[name]
            await self._set(nodes, **{name: values[on]})

    async def _save_wall(self):
        """Have the painter write what it has learned of the wall. Returns the path. Raises InputError."""
        node = self._nodes[PAINTER[0]].name
        try:
            answer = await asyncio.wait_for(_in(self._saver, rospy.ServiceProxy(node + '/save_wall', Trigger)),
                                            ANSWER_S)
        except (rospy.ServiceException, asyncio.TimeoutError):
            raise InputError('%s does not answer. Start it, or look at its log.' % node) from None
        paths = SAVED.findall(answer.message)
        if not answer.success:
            raise InputError(answer.message)
        if len(paths) != 1:
            raise InputError('Each area has a wall of its own. Give each its file, as wall in the file of the '
                             'areas: %s.' % ', '.join(paths))
        return paths[0]

    async def thumbnail(self, name):
        """The picture of that name as a small JPEG. Raises InputError if there is none."""
        await self._check(name)
        if name not in self._thumbnails:
            path = os.path.join(self._package, FOLDER, name)
            self._thumbnails[name] = _in(self._reader, lambda: _shrink(open_source(path).at(0)))
        try:
            return await asyncio.shield(self._thumbnails[name])  # shield: other requests may wait for it, too
        except Exception:
            self._thumbnails.pop(name, None)  # the file may be repaired later
            raise

    async def _set(self, names, **values):
        """Set parameters of all these nodes that are running. If none is, the first one refuses."""
        nodes = [self._nodes[name] for name in names]
        await asyncio.gather(*[node.set(**values) for node in nodes if node.values] or [nodes[0].set(**values)])

    def _drop_name(self):
        return 'dropped %d' % self._drops

    def _drop_topic(self):
        return TOPIC + self._dropped.resolved_name

    def _is_dropped(self, name):
        return self._drops > 0 and name == self._drop_name()

    async def _check(self, name):
        """Raise InputError unless there is a picture of that name."""
        if self._is_dropped(name):
            return
        listing = asyncio.shield(asyncio.wrap_future(self._look_for_files()))
        try:
            await asyncio.wait_for(listing, ANSWER_S)
        except asyncio.TimeoutError:
            raise InputError('The folder %s/ cannot be read: its file system does not answer.'
                             % FOLDER) from None
        if name not in self._files:
            raise InputError('There is no picture "%s" in %s/.' % (name, FOLDER))

    def _name_of(self, picture):
        """The page's name for the picture that exercise 5.6 paints, or '' if it is not one of ``pictures``."""
        if picture == self._drop_topic():
            return self._drop_name()
        folder, name = os.path.split(os.path.join(self._package, picture))
        return name if folder == os.path.join(self._package, FOLDER) else ''

    def _publish(self, parts):
        picture = self._decode(parts)
        self._dropped.publish(image_from_frame(picture, Header(stamp=rospy.Time.now())))
        return picture

    def _decode(self, parts):
        gc.collect()  # the traceback of an earlier refusal may still hold that picture
        data = b''.join(parts)
        parts.clear()
        try:  # only the header, before memory is allocated for the pixels
            with open_header(data, FORMATS) as image:
                pixels = image.width * image.height
        except DecompressionBombError:
            pixels = MAX_PIXELS + 1
        except Exception:  # Pillow raises exceptions of many kinds
            raise InputError('This file is not a picture. Drop a JPEG or PNG. Put videos and GIFs into %s/.'
                             % FOLDER) from None
        if pixels > MAX_PIXELS:
            raise InputError('The picture is too large. Drop one of at most %d million pixels.'
                             % (MAX_PIXELS // 10**6))
        return decode_picture(data, 'dropped')


def files_in(folder):
    """The sorted names of the files of a folder that can be chosen: no hidden ones, and no links out of it."""
    try:
        return sorted(entry.name for entry in os.scandir(folder)
                      if entry.is_file() and entry.name.isprintable() and not entry.name.startswith('.')
                      and os.path.dirname(os.path.realpath(entry.path)) == os.path.realpath(folder))
    except OSError:  # the rest of the page still works
        return []


def _in(worker, work, *arguments):
    return asyncio.get_event_loop().run_in_executor(worker, work, *arguments)


def _known(values):
    return {name: value for name, value in values.items() if value is not None}


def _shrink(picture):
    return jpeg_from_frame(resize(picture[..., :3], min(1, THUMBNAIL_PX / max(picture.shape[:2]))))
