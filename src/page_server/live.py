"""The page's websocket: frames, figures and choices to the browser; what is looked at, driving, choices back.

From the browser come JSON objects: {"look": [topics]}, {"shown": topic},
{"drive": [forward, left]}, {"picture": name}, {"slide": [name, value]}. To it
go {"state": ...}, {"problem": sentence}, {"without": topic, "why": sentence},
and frames: four bytes with the length of a JSON object, that object, a JPEG.
"""
import asyncio
import json
import struct
from collections import deque
from contextlib import nullcontext

import rospy
from aruco_ar.base.errors import InputError
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from .handlers import STALLED_S, Guarded

SHOWN_S = 5.0       # for so long the browser may take to show a frame before it is sent another
SILENT_S = 3.0      # without a frame for so long, the page says so
STALE_S = 1.0       # which tags were in sight longer ago, nobody wants to know
MAX_LATENCY_S = 60  # more than that: the stamps are of another clock
MAX_LOOKS = 16
MAX_BROWSERS = 64
MAX_UNTOLD = 64     # more than that a browser cannot have waiting: it takes nothing, and asks for ever more
MAX_CHOICES = 64    # at a time, of one browser: a slider makes seven a second, a node may take five to answer


class View:
    """What one browser sees of one topic."""

    def __init__(self, name, tags):
        self.name, self.tags = name, tags
        self.shown = asyncio.Event()
        self.stamp = None
        self.latencies: deque[float] = deque(maxlen=15)
        self.task = None

    def figures(self, topic):
        """The JSON object that goes with the topic's newest frame."""
        known = self.tags is not None and self.tags.age < STALE_S
        ids = sorted(tag.id for tag in self.tags.message.tags) if known else None
        latency = sorted(self.latencies)[len(self.latencies) // 2] if self.latencies else None
        return {'topic': self.name, 'stamp': topic.message.header.stamp.to_sec(),
                'rate': round(topic.rate, 1), 'tags': ids,
                'latency': None if latency is None else round(1000 * latency)}

    def on_shown(self):
        """The browser shows the frame sent last."""
        if self.stamp is not None:
            latency = (rospy.Time.now() - self.stamp).to_sec()
            if 0 <= latency < MAX_LATENCY_S:
                self.latencies.append(latency)
        self.stamp = None
        self.shown.set()


class Live(Guarded, WebSocketHandler):
    """One browser's connection."""

    def initialize(self, parts):
        self.parts = parts
        self._views = {}
        self._tasks = set()  # asyncio itself forgets those that nobody else keeps
        self._untold = self._choices = 0

    def prepare(self):
        super().prepare()
        if not self._finished and len(self.parts.browsers) >= MAX_BROWSERS:
            self.refuse(503, 'There are %d pages open already, and no more at a time.' % MAX_BROWSERS)

    def check_origin(self, origin):
        return True  # prepare has refused what is not of this site

    def open(self):
        self.set_nodelay(True)
        self.parts.browsers.add(self)
        self.tell({'state': self.parts.state()})

    def on_close(self):
        self.parts.browsers.discard(self)
        self._look([])
        if self.parts.driver:
            self.parts.driver.leave(self)

    async def on_message(self, message):
        await asyncio.sleep(0)  # others have their turn between any two
        if self not in self.parts.browsers:
            return  # it has gone meanwhile
        try:
            said = json.loads(message)
            if 'look' in said:
                self._look([str(name) for name in said['look']][:MAX_LOOKS])
            elif 'shown' in said and said['shown'] in self._views:
                self._views[said['shown']].on_shown()
            elif 'drive' in said and self.parts.driver:
                self.parts.driver.command(self, *said['drive'])
            elif 'picture' in said:
                self._begin(self._choose(self.parts.choices.choose, said['picture']))
            elif 'slide' in said:
                name, value = said['slide']
                self._begin(self._choose(self.parts.choices.slide, name, value))
        except (ValueError, TypeError, OverflowError, RecursionError):
            self.close(1003, 'not the language of this page')

    def _begin(self, work):
        """Have a coroutine run, and wait for nothing; its task."""
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def _choose(self, choose, *arguments):
        """Await a choice, which may take a while: driving does not wait for it."""
        if self._choices >= MAX_CHOICES:
            self.tell({'problem': 'That is too much at once; try again.'})
            return
        self._choices += 1
        try:
            await choose(*arguments)
        except InputError as error:
            self.tell({'problem': str(error)})
        finally:
            self._choices -= 1

    def _look(self, names):
        """Send frames of these topics and no others."""
        for name in set(self._views) - set(names):
            self._views.pop(name).task.cancel()
        for name in set(names) - set(self._views):
            self._views[name] = view = View(name, self.parts.tags_beside(name))
            view.task = asyncio.ensure_future(self._show(view))

    async def _show(self, view):
        """Send frames of a topic, the next when the browser shows the one before, as long as it looks."""
        with view.tags.watched() if view.tags else nullcontext():
            await self._show_frames(view)

    async def _show_frames(self, view):
        # Until it is cancelled; but before Python 3.12 asyncio.wait_for may keep that to itself.
        def looks():
            return self._views.get(view.name) is view
        while looks():
            try:
                topic = await self.parts.topics.image(view.name)
            except (LookupError, InputError) as error:
                self.tell({'without': view.name, 'why': error.args[0]})
                await asyncio.sleep(SILENT_S)
                continue
            with topic.watched():
                number = topic.number
                while looks() and await topic.newer(number, SILENT_S):
                    number = topic.number
                    await self._show_frame(view, topic)
            if looks():
                self.tell({'without': view.name, 'why': 'Nothing arrives on %s.' % view.name})

    async def _show_frame(self, view, topic):
        stamp, figures = topic.message.header.stamp, view.figures(topic)
        try:
            jpeg = await topic.jpeg()
        except InputError as error:
            self.tell({'without': view.name, 'why': str(error)})
            return
        head = json.dumps(figures).encode()
        view.shown.clear()
        view.stamp = stamp
        await self._send(struct.pack('>I', len(head)) + head + jpeg)
        try:
            await asyncio.wait_for(view.shown.wait(), SHOWN_S)
        except asyncio.TimeoutError:
            pass

    def tell(self, message):
        """Send the page a JSON object."""
        if self._untold >= MAX_UNTOLD:
            self._give_up()
            return
        self._untold += 1
        self._begin(self._send(json.dumps(message))).add_done_callback(self._on_told)

    def _on_told(self, _):
        self._untold -= 1

    async def _send(self, message):
        """Send text or bytes; a browser that does not take them for long is given up."""
        try:
            await asyncio.wait_for(self.write_message(message, binary=isinstance(message, bytes)), STALLED_S)
        except WebSocketClosedError:
            pass
        except asyncio.TimeoutError:
            self._give_up()

    def _give_up(self):
        if self.ws_connection is not None and self.ws_connection.stream is not None:  # not closed meanwhile
            self.ws_connection.stream.close()
