"""The HTTP handlers: the page, pictures, and image topics under the addresses of web_video_server."""
import asyncio
from contextlib import contextmanager, suppress
from urllib.parse import quote

from aruco_ar.base.errors import InputError
from aruco_ar.settings.settings import FITS
from aruco_ar.tags.tag import DICTIONARY_NAMES
from tornado.iostream import StreamClosedError
from tornado.web import Finish, RequestHandler, stream_request_body

from .access import is_own_name, is_same_site
from .shared import MAX_SIDE_PX
from .shelf import MAX_BYTES

BOUNDARY = 'boundarydonotcross'  # the same as in web_video_server
MAX_UPLOADS = 2                  # number of uploads at the same time
MAX_VIEWERS = 64                 # number of streams and snapshots at the same time
STALLED_S = 30.0                 # a browser that receives nothing for this time is disconnected
SILENT_S = 5.0                   # a snapshot waits this long for a frame
POLICY = ("default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
          "connect-src 'self' ws://%s wss://%s; base-uri 'none'; form-action 'self'; frame-ancestors 'self'")


def refusal_of(request):
    """Why a request is refused, in a sentence; None if it is not."""
    if not is_own_name(request.host):
        return ('"%s" is not a name of this server. Open it by its IP address or as localhost.'
                % request.host)
    has_effect = request.method != 'GET' or 'Upgrade' in request.headers
    if has_effect and not is_same_site(request.headers.get('Origin'), request.host):
        return 'Only pages of this server may do that, but this is a page of "%s".' % request.headers['Origin']
    return None


class BaseHandler(RequestHandler):
    """The base of all handlers, for HTTP and for the websocket: access, headers, and refusals in plain text."""

    def prepare(self):
        refusal = refusal_of(self.request)
        if refusal:
            self.refuse(403, refusal)

    def set_default_headers(self):
        self.set_header('Content-Type', 'text/plain; charset=utf-8')
        self.set_header('Server', 'unit5')
        self.set_header('X-Content-Type-Options', 'nosniff')
        self.set_header('Cache-Control', 'no-store')

    def refuse(self, status, sentence):
        """Answer with an error status and a sentence."""
        self.set_status(status)
        self.set_header('Content-Type', 'text/plain; charset=utf-8')
        self.finish(sentence + '\n')

    def write_error(self, status_code, **_):
        if status_code == 405:
            self.set_header('Allow', ', '.join(
                method for method in self.SUPPORTED_METHODS
                # Tornado answers this way if a handler does not have the method, and none has OPTIONS.
                if getattr(type(self), method.lower()) is not RequestHandler.options))
        self.refuse(status_code, 'The server cannot answer this request (%d: %s).'
                    % (status_code, self._reason))


class Handler(BaseHandler):
    """The base of the handlers that use the Site."""

    def initialize(self, site):
        self.site = site
        self.is_closed = False

    def on_connection_close(self):
        self.is_closed = True

    def show(self, template, **names):
        """Answer with a page made from a template."""
        self.set_header('Content-Type', 'text/html; charset=utf-8')
        self.render(template, **names)

    def number(self, name, high):
        """An argument of the query, a whole number from 1 to ``high``, or None if it is not given.

        Raises InputError if it is not valid.
        """
        text = self.get_query_argument(name, '')
        if not text:
            return None
        if not (text.isascii() and text.isdecimal() and len(text) < 9 and 1 <= int(text) <= high):
            raise InputError('%s is "%s"; it must be a whole number from 1 to %d.' % (name, text, high))
        return int(text)

    async def image(self):
        """(SharedImage, options) by the query; (None, None) if the request has been refused."""
        try:
            options = {'quality': self.number('quality', 100), 'width': self.number('width', MAX_SIDE_PX),
                       'height': self.number('height', MAX_SIDE_PX)}
        except InputError as error:
            self.refuse(400, str(error))
            return None, None
        kind = self.get_query_argument('type', 'mjpeg')
        if kind not in ('mjpeg', 'ros_compressed'):
            self.refuse(400, 'There is no stream of type "%s". Use mjpeg, or leave out type.' % kind)
            return None, None
        try:
            return await self.chosen(options), options
        except LookupError as error:
            self.refuse(404, error.args[0] + ' The page / lists all image topics.')
        except InputError as error:
            self.refuse(503, str(error))
        return None, None

    async def chosen(self, options):
        """The SharedImage by the query, as it is published now. Raises what Topics.image raises."""
        name = self.get_query_argument('topic', '')
        return await self.site.topics.image(name, exact=options['quality'] is not None)

    @contextmanager
    def counted(self):
        """A context manager that counts this request as a viewer. Ends it if there are too many."""
        if len(self.site.viewers) >= MAX_VIEWERS:
            self.refuse(503, 'There are %d streams and snapshots already, and there cannot be more. Try again '
                        'later.' % MAX_VIEWERS)
            raise Finish
        self.site.viewers[self] = self.request.connection.stream  # type: ignore[union-attr]  # as below
        try:
            yield
        finally:
            del self.site.viewers[self]


class Unknown(Handler):
    """Answers all other addresses."""

    def prepare(self):
        super().prepare()
        if not self._finished:
            self.refuse(404, 'There is no such page. The page / lists all image topics.')


class Page(Handler):
    """The page itself, with the list of all image topics."""

    async def get(self):
        try:
            topics = await self.site.topics.images()
        except InputError:
            topics = []
        self.set_header('Content-Security-Policy', POLICY % (self.request.host, self.request.host))
        self.set_header('Referrer-Policy', 'no-referrer')
        tiles = [tile for tile in self.site.tiles if tile.number]
        if any(tile.topic in topics for tile in self.site.tiles if not tile.number):  # such as calibration
            tiles = [tile for tile in self.site.tiles if tile.topic in topics]
        self.show('index.html', tiles=tiles, topics=topics, quote=quote, fits=FITS,
                  dictionaries=DICTIONARY_NAMES, films=self.site.phone is not None)


class StreamViewer(Handler):
    """A stream in a page of its own."""

    async def get(self):
        topic, _ = await self.image()
        if topic is not None:
            self.set_header('Content-Security-Policy', "default-src 'none'; img-src 'self'")
            self.show('stream_viewer.html', name=self.get_query_argument('topic'), query=self.request.query)


class Stream(Handler):
    """An image topic as MJPEG. Each frame is sent as soon as the browser has received the one before."""

    async def get(self):
        topic, options = await self.image()
        if topic is None:
            return
        with self.counted():
            self.set_header('Content-Type', 'multipart/x-mixed-replace;boundary=' + BOUNDARY)
            try:
                self.write('--%s\r\n' % BOUNDARY)
                await self.flush()
                while not self.is_closed:
                    with topic.subscribed():
                        topic = await self._send_all(topic, options)
            except StreamClosedError:
                pass
            except asyncio.TimeoutError:
                self.request.connection.stream.close()  # type: ignore[union-attr]  # it is an HTTP1Connection

    async def _send_all(self, topic, options):
        """Send the frames of an SharedImage until the camera has another one; returns that."""
        number, chosen = topic.number, topic
        while chosen is topic and not self.is_closed:
            if await topic.newer(number, 1.0):
                number = topic.number
                await self._send(topic, options)
            else:
                with suppress(LookupError, InputError):  # it is away, or the ROS master, and may come back
                    chosen = await self.chosen(options)
        return chosen

    async def _send(self, topic, options):
        stamp = divmod(topic.stamp_ns, 10**9)
        try:
            jpeg = await topic.jpeg(**options)
        except InputError:  # skip this frame; the next one may be usable
            return
        self.write('Content-type: image/jpeg\r\nX-Timestamp: %d.%09d\r\nContent-Length: %d\r\n\r\n'
                   % (*stamp, len(jpeg)))
        self.write(jpeg)
        self.write('\r\n--%s\r\n' % BOUNDARY)
        await asyncio.wait_for(self.flush(), STALLED_S)


class Snapshot(Handler):
    """The next frame of an image topic, as JPEG."""

    async def get(self):
        topic, options = await self.image()
        if topic is None:
            return
        with self.counted(), topic.subscribed():
            if not await topic.newer(topic.number, SILENT_S):
                self.refuse(503, 'Nothing has arrived on %s for %g s.' % (topic.name, SILENT_S))
                return
            stamp = divmod(topic.stamp_ns, 10**9)
            try:
                jpeg = await topic.jpeg(**options)
            except InputError as error:
                self.refuse(503, str(error))
                return
        self.set_header('Content-Type', 'image/jpeg')
        self.set_header('X-Timestamp', '%d.%09d' % stamp)
        self.finish(jpeg)


@stream_request_body
class Picture(Handler):
    """GET: a thumbnail of a picture. POST: have the picture in the body painted."""

    def initialize(self, site):
        super().initialize(site)
        self._body, self._bytes, self._is_complete = [], 0, False

    def prepare(self):
        # Otherwise tornado refuses without a sentence. The connection is an HTTP1Connection.
        self.request.connection.set_max_body_size(1 << 62)  # type: ignore[union-attr]
        super().prepare()
        announced = self.request.headers.get('Content-Length', '0')
        if not self._finished and announced.isdecimal() and int(announced) > MAX_BYTES:
            self._refuse_size()
        if not self._finished and self.request.method == 'POST':
            if len(self.site.uploads) >= MAX_UPLOADS:
                self.set_header('Connection', 'close')
                self.refuse(503, 'Other pictures are being uploaded. Try again later.')
            else:
                self.site.uploads.add(self)

    def on_finish(self):
        self.site.uploads.discard(self)

    def on_connection_close(self):
        super().on_connection_close()
        if not self._is_complete:  # otherwise post() still uses it
            self._body = []
            self.site.uploads.discard(self)

    def data_received(self, chunk):
        self._bytes += len(chunk)
        if self._bytes <= MAX_BYTES and not self._finished:
            self._body.append(chunk)
        elif not self._finished:
            self._refuse_size()

    async def get(self):
        try:
            jpeg = await self.site.choices.thumbnail(self.get_query_argument('name', ''))
        except InputError as error:
            self.refuse(404, str(error))
            return
        self.set_header('Content-Type', 'image/jpeg')
        self.finish(jpeg)

    async def post(self):
        if self._finished:
            return
        body, self._body, self._is_complete = self._body, [], True
        try:
            await self.site.choices.drop(body)
        except InputError as error:
            self.refuse(422, str(error))
            return
        finally:
            self.site.uploads.discard(self)
        self.set_status(204)

    def _refuse_size(self):
        self._body = []
        self.set_header('Connection', 'close')
        self.refuse(413, 'The picture is larger than %d MB.' % (MAX_BYTES // 1024**2))
