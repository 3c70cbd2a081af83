"""The server: connects its parts, and serves the page until ROS shuts down."""
import asyncio
import logging
import mimetypes
import os
import socket
from dataclasses import dataclass
from typing import Any, Dict, NamedTuple, Set

import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import package_folder
from aruco_ar.settings.declaration import Settings, number, text
from aruco_node.health.diagnostics import OK, Diagnostics
from aruco_node.health.faults import note_fault
from aruco_node.nodes.frame_node import CAMERA
from aruco_node.nodes.node import read_settings
from aruco_node.parameters.parameters import AUTO, switch
from aruco_node.parameters.reconfigure import Reconfigurer
from tornado.httpserver import HTTPServer
from tornado.ioloop import PeriodicCallback
from tornado.netutil import bind_sockets
from tornado.web import Application, StaticFileHandler

from .access import is_loopback
from .advice import Advice
from .choices import Choices
from .driving import DriveControl
from .handlers import STALLED_S, BaseHandler, Page, Picture, Snapshot, Stream, StreamViewer, Unknown
from .live import Live
from .topics import Topics

SEND_BUFFER_BYTES = 128 * 1024  # the buffer is small, since frames that wait in it become stale
IDLE_S = 20         # time limit from the end of one request to the end of the next one's header
BODY_S = 60         # time limit for the body of a request
MAX_CONNECTIONS = 256
PING_S = 5
STATE_MS = 2000
DIAGNOSTICS_MS = 250


@dataclass(frozen=True)
class PageSettings(Settings):
    """The parameters of the page. After a change of their defaults or words, run script/remake/launch_args."""

    address: str = text(
        '127.0.0.1', 'an IP address, or localhost',
        'address at which the page is served. 127.0.0.1: only this machine can open the page. 0.0.0.0: its '
        'whole network can', live=False)
    port: float = number(8080, 1, 65535, 'port at which the page is served', live=False)
    drive: Any = switch(
        AUTO, 'whether the page may drive the robot. auto: it may if it is served to this machine only')
    linear: float = number(0.3, 0, 2, 'speed at which the page drives the robot, in m/s')
    angular: float = number(0.8, 0, 8, 'speed at which the page turns the robot, in rad/s')


class Tile(NamedTuple):
    """One of the image topics that the page shows. ``tags``: the topic with the tags in sight.

    Without a ``number``, the tile is there only if its topic is published when the page is opened. Then only
    tiles with published topics are there.
    """

    number: str
    title: str
    topic: str
    tags: str

    @property
    def node(self):
        """The full name of the node that publishes it."""
        return self.topic.rpartition('/')[0]


# Those without a number are there while they are published.
TILES = [('5.1', 'The wall with its tags', CAMERA, 'exercise5_2/tags'),
         ('5.2', 'Tags detected', 'exercise5_2/image', 'exercise5_2/tags'),
         ('', 'Your 5.2', 'my_exercise5_2/image', 'my_exercise5_2/tags'),  # of learner's packages, see learn.py
         ('5.3', 'Centers, as they come', 'exercise5_3/image', 'exercise5_3/tags'),
         ('', 'Your 5.3', 'my_exercise5_3/image', 'my_exercise5_3/tags'),
         ('5.4', 'Centers in order', 'exercise5_4/image', 'exercise5_4/tags'),
         ('', 'Your 5.4', 'my_exercise5_4/image', 'my_exercise5_4/tags'),
         ('5.5', 'The area subtracted', 'exercise5_5/image', 'exercise5_5/tags'),
         ('', 'Your 5.5', 'my_exercise5_5/image', 'my_exercise5_5/tags'),
         ('5.6', 'A picture in its place', 'exercise5_6/image', 'exercise5_6/tags'),
         ('', 'Your 5.6', 'my_exercise5_6/image', 'my_exercise5_6/tags'),
         ('', 'Your last verdict', 'learn_verdict/image', 'learn_verdict/tags'),  # see nodes/learn_verdict.py
         ('', 'Calibration', 'calibrate_live/image', 'calibrate_live/tags')]


class Parts:
    """What the handlers share.

    ``drive_control`` is None if driving is off. ``browsers``, ``uploads``: the handlers of open websockets and
    of pictures on their way. ``viewers``: {handler that sends frames by HTTP: its connection}.
    """

    def __init__(self, drive_control, tiles, loop):
        """``tiles``: a list of Tile. ``loop``: the event loop of the server."""
        self.drive_control, self.tiles = drive_control, tiles
        self.browsers: Set[Live] = set()
        self.uploads: Set[Picture] = set()
        self.viewers: Dict[Any, Any] = {}
        self._last_state = None  # the state that was last sent to the browsers

        def tell():
            loop.call_soon_threadsafe(self.tell_browsers)
        self.topics, self.choices = Topics(), Choices(tell)
        self.advice = Advice([tile.node for tile in tiles], tell)

    def tags_beside(self, name):
        """The SharedTopic with the tags in sight on an image topic, or None if there is none."""
        beside = [tile.tags for tile in self.tiles if tile.topic == name]
        return self.topics.tags(beside[0]) if beside else None

    def state(self):
        """What can be chosen, what is chosen, whether the page may drive, and the sentence for each tile."""
        may_drive = self.drive_control is not None and self.drive_control.has_listeners()
        advice = {tile.topic: self.advice.of(tile.node) for tile in self.tiles}
        return dict(self.choices.state(), drive=may_drive, advice=advice)

    def tell_browsers(self):
        """Send the state to all browsers, if it has changed."""
        state = self.state()
        if state != self._last_state:
            self._last_state = state
            for browser in list(self.browsers):
                browser.tell({'state': state})


class Server(HTTPServer):
    """An HTTP server with at most MAX_CONNECTIONS, so that it never runs out of file descriptors.

    When a further connection arrives, the server closes the one whose last request is oldest, even if it is
    still in progress. So no client can lock out others. Connections that show a stream stay.
    """

    def initialize(self, *arguments, viewers, **options):  # type: ignore[override]  # only our own code calls it
        super().initialize(*arguments, **options)
        self._viewers, self._streams = viewers, {}  # in the order of their last requests

    @property
    def count(self):
        """The number of connections, without websockets."""
        return len(self._streams)

    def handle_stream(self, stream, address):
        if self.count >= MAX_CONNECTIONS:
            viewing = set(self._viewers.values())
            oldest = next(each for each in self._streams if each not in viewing)
            del self._streams[oldest]
            oldest.close()
        self._streams[stream] = None
        super().handle_stream(stream, address)

    def start_request(self, server_conn, request_conn):
        if server_conn.stream in self._streams:
            del self._streams[server_conn.stream]
            self._streams[server_conn.stream] = None
        return super().start_request(server_conn, request_conn)

    def on_close(self, server_conn):
        self._streams.pop(server_conn.stream, None)
        super().on_close(server_conn)


class Files(BaseHandler, StaticFileHandler):
    """The files in web/."""

    def should_return_304(self):
        try:
            return super().should_return_304()
        except (TypeError, ValueError):  # before tornado 6.5, if the header holds no date
            return False


def serve():
    """Serve the page until ROS shuts down. Raises InputError if it cannot be served."""
    settings = read_settings(PageSettings)
    address, port = settings.address, int(settings.port)
    for name in ('tornado.application', 'asyncio'):  # their errors go where the node's other faults go
        logging.getLogger(name).parent = logging.getLogger('rosout')
        logging.getLogger(name).addFilter(_note_faults)
    loop = asyncio.new_event_loop()
    asyncio.set_event_loop(loop)
    local, drive_control = is_loopback(address), None
    if local if settings.drive == AUTO else settings.drive:
        drive_control = DriveControl()
        drive_control.set_speeds(settings)
    Reconfigurer(settings, drive_control.set_speeds if drive_control else lambda settings: None)
    tiles = [Tile(number, title, rospy.resolve_name(topic), rospy.resolve_name(tags))
             for number, title, topic, tags in TILES]
    parts = Parts(drive_control, tiles, loop)
    # This timer is needed because nodes announce changes of their parameters, but not that they end.
    PeriodicCallback(parts.tell_browsers, STATE_MS).start()
    server = _listen(application(parts), parts.viewers, address, port)
    diagnostics = Diagnostics(lambda: (OK, 'The page is served.', {
        'connections': server.count, 'pages open': len(parts.browsers),
        'driving': 'on' if drive_control else 'off'}))
    PeriodicCallback(diagnostics.update, DIAGNOSTICS_MS).start()
    rospy.on_shutdown(lambda: loop.call_soon_threadsafe(loop.stop))
    name = 'localhost' if local else socket.gethostname() if address in ('0.0.0.0', '::') else \
        '[%s]' % address if ':' in address else address
    rospy.loginfo('The page is at http://%s:%d (driving is %s)', name, port,
                  'on' if drive_control else 'off')
    loop.run_forever()
    server.stop()


def _note_faults(record):
    """A filter of log records: notes an exception as a fault of the node, and does not log it a second time."""
    if record.exc_info:
        note_fault(record.exc_info[1])
    return not record.exc_info


def application(parts):
    """The tornado Application with all handlers."""
    files = os.path.join(package_folder(), 'web')
    mimetypes.add_type('application/yaml', '.yaml')  # not all systems define it
    shared = {'parts': parts}
    return Application([
        ('/', Page, shared), ('/live', Live, shared), ('/picture', Picture, shared),
        ('/stream', Stream, shared), ('/stream_viewer', StreamViewer, shared), ('/snapshot', Snapshot, shared),
        (r'/page/([a-z]+\.(?:js|css|svg|yaml))', Files, {'path': files}),
    ], default_handler_class=Unknown, default_handler_args=shared, template_path=files,
        log_function=lambda handler: None, websocket_ping_interval=PING_S, websocket_ping_timeout=2 * PING_S,
        websocket_max_message_size=64 * 1024)


def _listen(app, viewers, address, port):
    server = Server(app, viewers=viewers, idle_connection_timeout=IDLE_S, body_timeout=BODY_S,
                    max_header_size=16 * 1024, max_body_size=16 * 1024)
    try:
        listening = bind_sockets(port, address, backlog=MAX_CONNECTIONS)  # many may connect at once
    except OSError as error:
        raise InputError('The page cannot be served at %s:%d: %s. Give another port: port:=8081.'
                         % (address, port, error.strerror)) from None
    for each in listening:  # each connection inherits the options
        each.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER_BYTES)
        each.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, int(1000 * STALLED_S))
    server.add_sockets(listening)
    return server
