"""The server: its connections, its addresses, and what a page is made of."""
from __future__ import annotations

import asyncio
import mimetypes
import os
import socket
from abc import ABC, abstractmethod
from typing import Any, Sequence

from aruco_ar.base.errors import InputError
from aruco_ar.base.files import package_folder
from tornado.httpserver import HTTPServer
from tornado.ioloop import PeriodicCallback
from tornado.netutil import bind_sockets
from tornado.web import Application, StaticFileHandler

from .access import is_loopback
from .choices import Choices
from .filming import Film
from .handlers import STALLED_S, BaseHandler, Page, Picture, Snapshot, Stream, StreamViewer, Unknown
from .live import Live
from .shared import Shared, SharedImage
from .tiles import Tile

SEND_BUFFER_BYTES = 128 * 1024  # the buffer is small, since frames that wait in it become stale
IDLE_S = 20         # time limit from the end of one request to the end of the next one's header
BODY_S = 60         # time limit for the body of a request
MAX_CONNECTIONS = 256
PING_S = 10
STATE_MS = 2000


class Images(ABC):
    """The images that can be shown, by their names."""

    @abstractmethod
    async def images(self) -> list[str]:
        """The sorted names of all images. Raises InputError if they cannot be listed."""

    @abstractmethod
    async def image(self, name: str, exact: bool = False) -> SharedImage:
        """The SharedImage of that name. ``exact``: best as it was before any compression.

        Raises LookupError, with a sentence, if there is none, and InputError if they cannot be listed.
        """

    @abstractmethod
    def tags(self, name: str) -> Shared:
        """The sorted ids of tags, as Shared, by a name that a Tile has."""


class Site(ABC):
    """What the handlers share: what the page shows, and what can be chosen.

    ``choices``, ``topics``: set by the subclass. ``drive_control``: None if driving is off. ``phone``: what
    takes the frames of a device that films, or None; ``filming``: that device's handler. ``browsers``,
    ``uploads``: the handlers of open websockets and of pictures on their way. ``viewers``: {handler that sends
    frames by HTTP: its connection}.
    """

    choices: Choices
    topics: Images
    drive_control: Any = None
    phone: Any = None
    filming: Any = None

    def __init__(self, tiles: Sequence[Tile], loop: asyncio.AbstractEventLoop) -> None:
        """``loop``: the event loop of the server."""
        self.tiles, self._loop = tiles, loop
        self.browsers: set[Live] = set()
        self.uploads: set[Picture] = set()
        self.viewers: dict[Any, Any] = {}
        self._last_state: Any = None  # the state that was last sent to the browsers

    @abstractmethod
    def now(self) -> float:
        """The time by the clock of the frames' stamps, seconds."""

    @abstractmethod
    def advice_of(self, node: str) -> tuple[str, bool]:
        """(a sentence on what a node shows, whether it says why there are no frames); '' without a sentence."""

    def on_change(self) -> None:
        """Something of the state has changed, so the browsers are told. Call it from any thread."""
        self._loop.call_soon_threadsafe(self.tell_browsers)

    def tags_beside(self, name: str) -> Shared | None:
        """The Shared ids of the tags in sight on an image, or None if there are none."""
        beside = [tile.tags for tile in self.tiles if tile.topic == name]
        return self.topics.tags(beside[0]) if beside else None

    def state(self) -> dict[str, Any]:
        """What can be chosen, what is chosen, whether the page may drive, and the sentence for each tile."""
        may_drive = self.drive_control is not None and self.drive_control.has_listeners()
        advice = {tile.topic: self.advice_of(tile.node) for tile in self.tiles}
        return dict(self.choices.state(), drive=may_drive, advice=advice)

    def tell_browsers(self) -> None:
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


def application(site):
    """The tornado Application with all handlers. ``site``: the Site."""
    files = os.path.join(package_folder(), 'web')
    mimetypes.add_type('application/yaml', '.yaml')  # not all systems define it
    shared = {'site': site}
    return Application([
        ('/', Page, shared), ('/live', Live, shared), ('/picture', Picture, shared),
        ('/film', Film, shared),
        ('/stream', Stream, shared), ('/stream_viewer', StreamViewer, shared), ('/snapshot', Snapshot, shared),
        (r'/page/([a-z]+\.(?:js|css|svg|yaml))', Files, {'path': files}),
    ], default_handler_class=Unknown, default_handler_args=shared, template_path=files,
        log_function=lambda handler: None, websocket_ping_interval=PING_S, websocket_ping_timeout=PING_S,
        websocket_max_message_size=64 * 1024)


def listen(site, address, port, tls=None):
    """Serve the page of a Site from now on, in the current event loop. Returns the Server.

    ``address``: an IP address, or localhost. ``tls``: an SSLContext for HTTPS, or None. Raises InputError if it
    cannot be served there.
    """
    server = Server(application(site), viewers=site.viewers, ssl_options=tls, idle_connection_timeout=IDLE_S,
                    body_timeout=BODY_S, max_header_size=16 * 1024, max_body_size=16 * 1024)
    try:
        listening = bind_sockets(port, address, backlog=MAX_CONNECTIONS)  # many may connect at once
    except OSError as error:
        raise InputError('The page cannot be served at %s:%d: %s. Give another port: port:=8081.'
                         % (address, port, error.strerror)) from None
    for each in listening:  # each connection inherits the options
        each.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER_BYTES)
        if hasattr(socket, 'TCP_USER_TIMEOUT'):  # on Linux
            each.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, int(1000 * STALLED_S))
    server.add_sockets(listening)
    # Who makes the images may end without saying so.
    PeriodicCallback(site.tell_browsers, STATE_MS).start()
    return server


def address_of_page(address, port, tls=None):
    """Where a browser finds the page that is served at an address."""
    name = 'localhost' if is_loopback(address) else socket.gethostname() if address in ('0.0.0.0', '::') else \
        '[%s]' % address if ':' in address else address
    return '%s://%s:%d' % ('https' if tls else 'http', name, port)
