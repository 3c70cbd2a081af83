"""The page's websocket.

The browser sends JSON objects:
  {"look": [topics], "width": w, "h264": true}  the topics whose frames it wants, and no others, at most w
                               pixels wide, and as H.264 if it says so and the server can
  {"lost": topic}              it cannot decode the H.264 of this topic, which is to begin anew
  {"shown": topic}             it shows the last frame of this topic, so it can take the next one
  {"drive": [forward, left]}   each from -1 to 1
  {"picture": name}            the picture to paint
  {"slide": [name, value]}     a slider
  {"write": [name, text]}      a field: how the picture fills the area, the dictionary, or the ids
  {"switch": [name, on]}       a switch for the look of the picture

The server sends JSON objects:
  {"state": ...}                           what can be chosen, and what is chosen
  {"problem": sentence}                    why a choice has failed
  {"without": topic, "why": sentence}      why this topic has no frames
It sends frames as binary messages: the length of a JSON object in four bytes, the object, and a JPEG. If the
object has "key", it is H.264 in Annex B instead; "key" says whether a stream begins with it.
"""
import asyncio
import json
import struct
from collections import deque
from contextlib import nullcontext

from aruco_ar.base.errors import InputError
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from .handlers import STALLED_S, BaseHandler
from .video import VideoStream, can_encode

SHOWN_S = 5.0       # a browser that shows no frame for this time is sent the next one anyway
SILENT_S = 3.0      # after this time without a frame, the page says so
STALE_S = 1.0       # ids of tags are not sent if they are older than this
MAX_LATENCY_S = 60  # a frame that seems older than this was stamped by another clock
MAX_VIEWS = 16      # number of topics that one browser shows
MAX_WIDTH = 10000   # largest width of a frame, in pixels
MAX_BROWSERS = 64
MAX_UNSENT = 64     # a browser with more unsent JSON objects receives nothing, so it is disconnected
# Number of choices of one browser that are being made. A slider sends seven a second. A node may take 5 s each.
MAX_CHOICES = 64


class ShownTopic:
    """A topic that a browser shows."""

    def __init__(self, name, tags):
        self.name, self.tags = name, tags
        self.shown = asyncio.Event()
        self.stamp = None
        self.latencies: deque[float] = deque(maxlen=15)
        self.video = VideoStream()
        self.task = None

    def figures(self, topic):
        """The JSON object that is sent with the topic's newest frame."""
        has_tags = self.tags is not None and self.tags.age < STALE_S
        ids = self.tags.item if has_tags else None
        latency = sorted(self.latencies)[len(self.latencies) // 2] if self.latencies else None
        return {'topic': self.name, 'stamp': topic.stamp_ns / 1e9,
                'rate': round(topic.rate, 1), 'tags': ids,
                'latency': None if latency is None else round(1000 * latency)}

    def on_shown(self, now):
        """The browser shows the last frame that was sent. ``now``: the time, seconds."""
        if self.stamp is not None:
            latency = now - self.stamp
            if 0 <= latency < MAX_LATENCY_S:
                self.latencies.append(latency)
        self.stamp = None
        self.shown.set()


class Live(BaseHandler, WebSocketHandler):
    """The websocket of one browser."""

    def initialize(self, site):
        self.site = site
        self._views = {}
        self._tasks = set()  # asyncio itself keeps no reference to running tasks
        self._unsent = self._choices = 0
        self._as_video = False  # whether frames are sent as H.264, else as JPEG
        self._width = None  # pixels, the largest that the browser can show; None for any

    def prepare(self):
        super().prepare()
        if not self._finished and len(self.site.browsers) >= MAX_BROWSERS:
            self.refuse(503, 'There are %d pages open already, and there cannot be more.' % MAX_BROWSERS)

    def check_origin(self, origin):
        return True  # prepare has refused other sites

    def open(self):
        self.set_nodelay(True)
        self.site.browsers.add(self)
        self.tell({'state': self.site.state()})

    def on_close(self):
        self.site.browsers.discard(self)
        self._set_views([])
        if self.site.drive_control:
            self.site.drive_control.release(self)

    async def on_message(self, message):
        await asyncio.sleep(0)  # let other tasks run between two messages
        if self not in self.site.browsers:
            return  # it has been closed meanwhile
        try:
            request = json.loads(message)
            if 'look' in request:
                self._set_views([str(name) for name in request['look']][:MAX_VIEWS])
                width = request.get('width')
                self._width = int(min(max(width, 1), MAX_WIDTH)) if isinstance(width, (int, float)) else None
                self._as_video = request.get('h264') is True and can_encode()
            elif 'lost' in request and request['lost'] in self._views:
                self._views[request['lost']].video.restart()
            elif 'shown' in request and request['shown'] in self._views:
                self._views[request['shown']].on_shown(self.site.now())
            elif 'drive' in request and self.site.drive_control:
                self.site.drive_control.command(self, *request['drive'])
            elif 'picture' in request:
                self._start(self._choose(self.site.choices.choose, request['picture']))
            elif 'slide' in request:
                name, value = request['slide']
                self._start(self._choose(self.site.choices.slide, name, value))
            elif 'write' in request:
                name, value = request['write']
                self._start(self._choose(self.site.choices.write, name, value))
            elif 'switch' in request:
                name, on = request['switch']
                self._start(self._choose(self.site.choices.switch, name, on))
        except (ValueError, TypeError, OverflowError, RecursionError):
            self.close(1003, 'not a message of this page')

    def _start(self, coroutine):
        """Run a coroutine in the background. Returns its task."""
        task = asyncio.ensure_future(coroutine)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def _choose(self, choose, *arguments):
        """Make a choice, and report its failure. It runs in the background, since it may take seconds."""
        if self._choices >= MAX_CHOICES:
            self.tell({'problem': 'There are too many changes at once. Try again.'})
            return
        self._choices += 1
        try:
            await choose(*arguments)
        except InputError as error:
            self.tell({'problem': str(error)})
        finally:
            self._choices -= 1

    def _set_views(self, names):
        """Send frames of these topics, and of no others."""
        for name in set(self._views) - set(names):
            self._views.pop(name).task.cancel()
        for name in set(names) - set(self._views):
            self._views[name] = view = ShownTopic(name, self.site.tags_beside(name))
            view.task = asyncio.ensure_future(self._show(view))

    async def _show(self, view):
        """Send frames of a topic until the view is closed.

        The browser shows each one before the next is sent.
        """
        with view.tags.subscribed() if view.tags else nullcontext():
            await self._show_frames(view)

    async def _show_frames(self, view):
        # The task is cancelled to end it, but before Python 3.12 asyncio.wait_for may swallow the cancellation.
        def is_open():
            return self._views.get(view.name) is view
        while is_open():
            try:
                topic = await self.site.topics.image(view.name)
            except (LookupError, InputError) as error:
                self.tell({'without': view.name, 'why': error.args[0]})
                await asyncio.sleep(SILENT_S)
                continue
            with topic.subscribed():
                number = topic.number
                while is_open() and await topic.newer(number, SILENT_S):
                    number = topic.number
                    await self._show_frame(view, topic)
            if is_open():
                self.tell({'without': view.name, 'why': 'Nothing arrives on %s.' % view.name})

    async def _show_frame(self, view, topic):
        stamp, figures = topic.stamp_ns / 1e9, view.figures(topic)
        try:
            if self._as_video:
                frame = await topic.frame(most_width=self._width)
                data, figures['key'] = await topic.in_encoder(view.video.encode, frame, stamp)
            else:
                data = await topic.jpeg(most_width=self._width)
        except InputError as error:
            self.tell({'without': view.name, 'why': str(error)})
            return
        head = json.dumps(figures).encode()
        view.shown.clear()
        view.stamp = stamp
        await self._send(struct.pack('>I', len(head)) + head + data)
        try:
            await asyncio.wait_for(view.shown.wait(), SHOWN_S)
        except asyncio.TimeoutError:
            pass

    def tell(self, message):
        """Send the page a JSON object."""
        if self._unsent >= MAX_UNSENT:
            self._disconnect()
            return
        self._unsent += 1
        self._start(self._send(json.dumps(message))).add_done_callback(self._on_sent)

    def _on_sent(self, _):
        self._unsent -= 1

    async def _send(self, message):
        """Send text or bytes. A browser that does not receive them within STALLED_S is disconnected."""
        try:
            await asyncio.wait_for(self.write_message(message, binary=isinstance(message, bytes)), STALLED_S)
        except WebSocketClosedError:
            pass
        except asyncio.TimeoutError:
            self._disconnect()

    def _disconnect(self):
        if self.ws_connection is not None and self.ws_connection.stream is not None:  # not closed meanwhile
            self.ws_connection.stream.close()
