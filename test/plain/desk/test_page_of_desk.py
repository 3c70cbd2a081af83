"""The page of aruco-ar: what a browser is shown of a camera, and of a phone, without ROS."""
import asyncio
import json
import ssl
import struct
import sys
from contextlib import asynccontextmanager, contextmanager, suppress
from dataclasses import replace

import av
import cv2
import numpy as np
import pytest
from aruco_ar.simulation.robot import Path, Pose
from rig.accuracy.drives import WALL, drive
from rig.page.server import free_port
from rig.processes.started import WAIT_S, Started
from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.websocket import WebSocketClosedError, websocket_connect

CAMERA, PAINTED, SUBTRACTED = '/camera/rgb/image_raw', '/exercise5_6/image', '/exercise5_5/image'
GREEN, RED = (0, 200, 0), (0, 0, 220)
AHEAD = Path(Pose(-1.6, 0.0, 0.0), ((1, 0, 0),))


@pytest.fixture(scope='module')
def wall():
    """A frame of a simulated wall, whose tags are of DICT_6X6_250, and the middle of its area."""
    frame = next(drive(AHEAD, 1))
    return frame.image, np.rint(frame.corners.mean(axis=0)).astype(int)


def film(folder, image, seconds=20):
    """A clip of a wall that stands still."""
    path = str(folder / 'camera.avi')
    writer = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*'MJPG'), 20, image.shape[1::-1])
    for _ in range(20 * seconds):
        writer.write(image)
    writer.release()
    return path


@contextmanager
def served(folder, *options, is_away=False):
    """aruco-ar serves its page: the port. The folder has a green.png. ``is_away``: its camera is, at first."""
    cv2.imwrite(str(folder / 'green.png'), np.full((30, 40, 3), GREEN, np.uint8))
    port = free_port()
    command = Started(sys.executable, '-c', 'import sys; from aruco_desk.command import main; sys.exit(main())',
                      'paint', '--picture', str(folder / 'green.png'), '--port', str(port), *options)
    try:
        command.wait_for(':%d' % port)
        yield port
        if is_away:
            command.wait_for('aruco-ar: The camera', 'cannot be opened')
    finally:
        command.stop()
    assert not [line for line in command.lines if 'Traceback' in line], ''.join(command.lines)


class Socket:
    """A websocket. ``read`` gives its next message, and None when it is closed."""

    def __init__(self):
        self._messages = asyncio.Queue()

    @asynccontextmanager
    async def to(self, address):
        self.connection = await websocket_connect(address, on_message_callback=self._messages.put_nowait)
        try:
            yield self
        finally:
            self.connection.close()
            while await self.read() is not None:
                pass

    async def write(self, message):
        await self.connection.write_message(message, binary=isinstance(message, bytes))

    async def read(self):
        message = await asyncio.wait_for(self._messages.get(), WAIT_S)
        if message is None:
            self._messages.put_nowait(None)  # it stays closed
        return message


class Browser(Socket):
    """What a browser gets by the page's websocket. ``state``: the last one."""

    state = None

    async def say(self, **message):
        await self.write(json.dumps(message))

    async def until(self, is_right):
        """Read until ``is_right`` of (a JSON object, a frame or None) is true. Returns them."""
        async def read():
            while True:
                message = await self.read()
                assert message is not None, 'the server has closed the connection'
                if isinstance(message, str):
                    head, frame = json.loads(message), None
                    self.state = head.get('state', self.state)
                else:
                    length, = struct.unpack('>I', message[:4])
                    head = json.loads(message[4:4 + length])
                    frame = cv2.imdecode(np.frombuffer(message[4 + length:], np.uint8), 1)
                    await self.say(shown=head['topic'])
                if is_right(head, frame):
                    return head, frame
        return await asyncio.wait_for(read(), WAIT_S)

    async def until_painted(self, place, color, topic=PAINTED):
        """Read until an image has that color at a place (x, y)."""
        x, y = place

        def is_right(head, frame):
            return frame is not None and head['topic'] == topic and \
                np.abs(frame[y, x] - np.int32(color)).max() < 9
        return await self.until(is_right)


def advice_of(head):
    """All sentences in a JSON object for the page, if it is a state."""
    return str(head.get('state', {}).get('advice'))


def test_the_page_shows_what_the_exercises_make_of_a_camera(tmp_path, wall):
    image, middle = wall

    async def look(port):
        async with Browser().to('ws://127.0.0.1:%d/live' % port) as browser:
            await browser.say(look=[PAINTED, SUBTRACTED])
            head, _ = await browser.until_painted(middle, GREEN)
            assert head['tags'] == [1, 2, 3, 4]
            await browser.until_painted(middle, (0, 0, 0), SUBTRACTED)
            _, frame = await browser.until_painted(middle, GREEN)
            outside = np.abs(frame[:20].astype(int) - image[:20]).mean()
            assert outside < 4  # it is JPEG
            await browser.say(slide=['opacity', 0])
            await browser.until_painted(middle, image[middle[1], middle[0]])
            picture = cv2.imencode('.png', np.full((30, 40, 3), RED, np.uint8))[1].tobytes()
            answer = await AsyncHTTPClient().fetch(HTTPRequest(
                'http://127.0.0.1:%d/picture' % port, 'POST', body=picture))
            assert answer.code == 204
            await browser.say(slide=['opacity', 1])
            await browser.until_painted(middle, RED)
            await browser.say(picture='earth.jpg')
            await browser.until(lambda head, frame: head.get('state', {}).get('picture') == 'earth.jpg')
            await browser.say(write=['ids', '1,2,3'])
            refused, _ = await browser.until(lambda head, frame: 'problem' in head)
            assert 'the ids of four different tags' in refused['problem']
    with served(tmp_path, '--camera', film(tmp_path, image)) as port:
        asyncio.run(look(port))


def test_frames_come_as_h264_if_the_browser_asks_for_it(tmp_path, wall):
    image, middle = wall

    async def look(port):
        decoder, found = av.CodecContext.create('h264', 'r'), []
        async with Browser().to('ws://127.0.0.1:%d/live' % port) as browser:
            await browser.say(look=[PAINTED], h264=True)
            while len(found) < 12:
                message = await browser.read()
                if isinstance(message, bytes):
                    length, = struct.unpack('>I', message[:4])
                    head, data = json.loads(message[4:4 + length]), message[4 + length:]
                    if len(found) == 6:  # the browser has lost the stream
                        await browser.say(lost=PAINTED)
                    await browser.say(shown=PAINTED)
                    frames = decoder.decode(av.Packet(data))
                    assert len(frames) == 1  # none waits for the next one
                    found.append((head['key'], len(data), frames[0].to_ndarray(format='bgr24')))
        firsts = [number for number, (is_first, _, _) in enumerate(found) if is_first]
        assert firsts in ([0, 6], [0, 7])
        assert np.median([size for is_first, size, _ in found if not is_first]) < found[0][1] / 5
        painted = found[-1][2]
        assert painted.shape == image.shape
        assert np.abs(painted[middle[1], middle[0]] - np.int32(GREEN)).max() < 12
        assert np.abs(painted[:20].astype(int) - image[:20]).mean() < 6
    with served(tmp_path, '--camera', film(tmp_path, image)) as port:
        asyncio.run(look(port))


def test_the_dictionary_of_the_tags_in_sight_is_found(tmp_path):
    frame = next(drive(AHEAD, 1, wall=replace(WALL, dictionary='DICT_4X4_50')))
    middle = np.rint(frame.corners.mean(axis=0)).astype(int)

    async def look(port):
        async with Browser().to('ws://127.0.0.1:%d/live' % port) as browser:
            await browser.say(look=[PAINTED])
            await browser.until_painted(middle, GREEN)
            assert browser.state['fields']['dictionary'] == 'DICT_4X4_50'
    with served(tmp_path, '--camera', film(tmp_path, frame.image)) as port:
        asyncio.run(look(port))


def test_a_camera_that_is_away_is_awaited(tmp_path, wall):
    image, middle = wall

    async def look(port):
        async with Browser().to('ws://127.0.0.1:%d/live' % port) as browser:
            await browser.say(look=[PAINTED])
            await browser.until(lambda head, frame: 'cannot be opened' in advice_of(head))
            sentence, is_trouble = browser.state['advice'][PAINTED]
            assert is_trouble and 'Is it plugged in' in sentence
            film(tmp_path, image)
            await browser.until_painted(middle, GREEN)
    with served(tmp_path, '--camera', str(tmp_path / 'camera.avi'), is_away=True) as port:
        asyncio.run(look(port))


def test_a_phone_films_over_https(tmp_path, wall):
    image, middle = wall
    jpeg = cv2.imencode('.jpg', image)[1].tobytes()
    trusting = ssl.create_default_context()
    trusting.check_hostname, trusting.verify_mode = False, ssl.CERT_NONE

    async def send(device):
        with suppress(WebSocketClosedError):
            await device.write(jpeg)
            while await device.read() is not None:
                await device.write(jpeg)

    def secure(port, path):
        return HTTPRequest('wss://127.0.0.1:%d%s' % (port, path), ssl_options=trusting)

    async def look(port):
        page = await AsyncHTTPClient().fetch('https://127.0.0.1:%d/' % port, ssl_options=trusting)
        assert 'Film with this device' in page.body.decode()
        async with Browser().to(secure(port, '/live')) as browser, Socket().to(secure(port, '/film')) as first:
            await browser.say(look=[PAINTED])
            await browser.until(lambda head, frame: 'No phone films' in advice_of(head))
            sending = asyncio.ensure_future(send(first))
            await browser.until_painted(middle, GREEN)
            async with Socket().to(secure(port, '/film')) as second:  # the last one to begin is the camera
                await sending
                assert first.connection.close_reason == 'Another device films now.'
                await second.write(b'no JPEG')
                await browser.until(lambda head, frame: 'that are no JPEGs' in advice_of(head))
                sending = asyncio.ensure_future(send(second))
                await browser.until_painted(middle, GREEN)
                sending.cancel()
    with served(tmp_path, '--phone') as port:
        asyncio.run(look(port))
