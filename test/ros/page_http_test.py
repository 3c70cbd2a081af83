#!/usr/bin/env python3
"""The page's server without a browser: web_video_server's addresses, and what it does not do."""
import asyncio
import json
import os
import re
import socket
import struct
import unittest
import urllib.error
import urllib.request
import zlib

import cv2
import numpy as np
import rospy
import rostest
from aruco_ar.messages import compressed_from_frame, image_from_frame
from geometry_msgs.msg import Twist
from listening import Connections, Inbox
from rosgraph import Master
from sensor_msgs.msg import CompressedImage, Image
from started import WAIT_S, Started, node
from std_msgs.msg import Header, String
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect

PICTURE = np.zeros((480, 640, 3), np.uint8)
PICTURE[:, :320] = (200, 60, 20)
PICTURE[100:200, 400:500] = np.random.RandomState(1).randint(0, 255, (100, 100, 3))


def free_port():
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]


def ask(port, path, data=None, **headers):
    """(status, headers, body)."""
    request = urllib.request.Request('http://127.0.0.1:%d%s' % (port, path), data,
                                     {name.replace('_', '-'): value for name, value in headers.items()})
    try:
        with urllib.request.urlopen(request, timeout=WAIT_S) as answer:
            return answer.status, answer.headers, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.headers, error.read()


class Stream:
    """An MJPEG stream, read part by part."""

    def __init__(self, port, path):
        self._file = urllib.request.urlopen('http://127.0.0.1:%d%s' % (port, path), timeout=WAIT_S)
        self.kind = self._file.headers['Content-Type']
        self._boundary = re.search('boundary=(.*)', self.kind).group(1).encode()

    def part(self):
        """(headers, body) of the next part."""
        assert self._file.readline().strip() == b'--' + self._boundary
        headers = {}
        for line in iter(self._file.readline, b'\r\n'):
            name, _, value = line.decode().strip().partition(': ')
            headers[name.lower()] = value
        body = self._file.read(int(headers['content-length']))
        assert self._file.readline() == b'\r\n'
        return headers, body

    def close(self):
        self._file.close()


def bomb(side):
    """A PNG of a few bytes and side x side pixels."""
    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))
    rows = zlib.compress(b'\0' * ((side // 8 + 1) * side), 9)
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', side, side, 1, 0, 0, 0, 0))
            + chunk(b'IDAT', rows) + chunk(b'IEND', b''))


class PageServer(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.port = free_port()
        cls.page = Started('roslaunch', 'unit5', 'page.launch', 'port:=%d' % cls.port)
        cls.page.wait_for('The page is at http://localhost:%d (driving is on)' % cls.port)

    @classmethod
    def tearDownClass(cls):
        cls.page.stop()

    def camera(self, topic='/eye/image', kind=Image):
        """(publish, connections) of an image topic."""
        connections = Connections()
        publisher = rospy.Publisher(topic, kind, connections, queue_size=1)
        self.addCleanup(publisher.unregister)
        make = image_from_frame if kind is Image else compressed_from_frame

        def publish(picture=PICTURE, number=1):
            publisher.publish(make(picture, Header(stamp=rospy.Time(number, 500))))
        return publish, connections

    def publish_always(self, publish):
        timer = rospy.Timer(rospy.Duration(1 / 30), lambda event: publish())
        self.addCleanup(timer.shutdown)

    def listed(self, topic):
        """Wait until the page lists a topic that was just published."""
        self.until(lambda: topic in ask(self.port, '/')[2].decode())

    def until(self, true):
        event = rospy.Rate(10)
        for _ in range(10 * WAIT_S):
            if true():
                return
            event.sleep()
        self.fail('it never came true')

    def test_it_lists_the_image_topics_and_no_others(self):
        self.camera()
        other = rospy.Publisher('/words', String, queue_size=1)
        self.addCleanup(other.unregister)
        self.listed('/eye/image')
        status, headers, body = ask(self.port, '/')
        self.assertIn('href="/stream?topic=/eye/image"', body.decode())
        self.assertIn('href="/snapshot?topic=/eye/image"', body.decode())
        self.assertNotIn('/words', body.decode())
        self.assertIn("default-src 'none'", headers['Content-Security-Policy'])

    def test_a_stream_of_jpegs_only_while_somebody_looks(self):
        publish, connections = self.camera()
        self.listed('/eye/image')
        self.assertEqual(connections.count, 0)
        stream = Stream(self.port, '/stream?topic=/eye/image&quality=90')
        self.assertEqual(stream.kind, 'multipart/x-mixed-replace;boundary=boundarydonotcross')
        connections.wait(1)
        sizes = []
        for number in (7, 8):
            publish(number=number)
            headers, body = stream.part()
            self.assertEqual((headers['content-type'], headers['x-timestamp']), ('image/jpeg', '%d.000000500' % number))
            np.testing.assert_allclose(cv2.imdecode(np.frombuffer(body, np.uint8), 1)[240, 100], PICTURE[240, 100], atol=4)
            sizes.append(len(body))
        stream.close()
        connections.wait(0)
        stream = Stream(self.port, '/stream?topic=eye/image&quality=20&width=320')
        connections.wait(1)
        publish()
        body = stream.part()[1]
        self.assertLess(len(body), min(sizes) / 2)
        self.assertEqual(cv2.imdecode(np.frombuffer(body, np.uint8), 1).shape, (240, 320, 3))
        stream.close()

    def test_a_snapshot_and_one_of_a_camera_that_is_only_there_compressed(self):
        for topic, kind in (('/eye/image', Image), ('/lens/image/compressed', CompressedImage)):
            publish, connections = self.camera(topic, kind)
            topic = topic.replace('/compressed', '')
            self.listed(topic)
            self.publish_always(publish)
            status, headers, body = ask(self.port, '/snapshot?topic=' + topic)
            self.assertEqual((status, headers['Content-Type'], headers['X-Timestamp']),
                             (200, 'image/jpeg', '1.000000500'))
            self.assertEqual(cv2.imdecode(np.frombuffer(body, np.uint8), 1).shape, (480, 640, 3))
            connections.wait(0)
        self.assertIn('src="/stream?topic=/eye/image"', ask(self.port, '/stream_viewer?topic=/eye/image')[2].decode())

    def test_what_is_not_there_is_answered_with_a_sentence(self):
        self.camera()
        self.listed('/eye/image')
        words = rospy.Publisher('/words', String, queue_size=1)
        self.addCleanup(words.unregister)
        self.until(lambda: b'only one of type' in ask(self.port, '/stream?topic=/words')[2])
        for path, status, sentence in (
                ('/stream?topic=/nowhere', 404, 'There is no image topic /nowhere'),
                ('/snapshot?topic=/nowhere', 404, 'There is no image topic /nowhere'),
                ('/stream_viewer?topic=/nowhere', 404, 'There is no image topic /nowhere'),
                ('/stream?topic=/words', 404, 'only one of type std_msgs/String'),
                ('/stream', 404, 'Give the name of an image topic'),
                ('/stream?topic=%00%3Cb%3E', 404, 'Give the name of an image topic'),
                ('/stream?topic=%ff', 400, 'The server cannot answer this (400'),
                ('/stream?topic=/eye/image&quality=101', 400, 'quality is "101"; it must be a whole number from 1 to 100'),
                ('/stream?topic=/eye/image&width=-5', 400, 'width is "-5"'),
                ('/stream?topic=/eye/image&type=h264', 400, 'no stream of type "h264"'),
                ('/snapshot?topic=/eye/image', 503, 'Nothing has arrived on /eye/image'),
                ('/elsewhere', 404, 'There is no such page'),
                ('/picture?name=nothing.jpg', 404, 'There is no picture "nothing.jpg" in images/')):
            answered, headers, body = ask(self.port, path)
            self.assertEqual((answered, headers['Content-Type']), (status, 'text/plain; charset=utf-8'), path)
            self.assertIn(sentence, body.decode())

    def test_no_path_leads_out(self):
        secret = b'unit5</name>'
        for path in ('/page/../package.xml', '/page/..%2fpackage.xml', '/page/%2e%2e/package.xml', '/../package.xml',
                     '//package.xml', '/page//etc/passwd', '/page/index.html', '/page/....//package.xml',
                     '/picture?name=../package.xml', '/picture?name=%2e%2e/package.xml', '/picture?name=/etc/passwd',
                     '/picture?name=readme', '/page/page.js/../../package.xml'):
            with socket.create_connection(('127.0.0.1', self.port), WAIT_S) as line:
                line.sendall(b'GET %s HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' % path.encode())
                answer = b''.join(iter(lambda: line.recv(65536), b''))
            self.assertRegex(answer, b'^HTTP/1.1 40[034]', path)
            self.assertNotIn(secret, answer)
            self.assertNotIn(b'root:', answer)
        self.assertEqual(ask(self.port, '/page/page.js')[0], 200)

    def test_a_slow_browser_gets_fewer_frames_and_slows_nobody(self):
        publish, connections = self.camera()
        self.listed('/eye/image')
        noise = np.random.RandomState(0).randint(0, 255, (480, 640, 3), np.uint8)  # some 400 kB a frame
        slow = Stream(self.port, '/stream?topic=/eye/image')
        quick = Stream(self.port, '/stream?topic=/eye/image')
        connections.wait(1)
        sent = 40
        for number in range(1, sent + 1):
            publish(noise, number)
            self.assertEqual(quick.part()[0]['x-timestamp'], '%d.000000500' % number)
        publish(noise, 1000)
        got = [int(slow.part()[0]['x-timestamp'].split('.')[0])]
        while got[-1] != 1000:
            got.append(int(slow.part()[0]['x-timestamp'].split('.')[0]))
        self.assertLess(len(got), sent / 2)
        self.assertEqual(got, sorted(set(got)))
        slow.close()
        quick.close()

    def test_other_sites_and_other_names_are_refused(self):
        png = cv2.imencode('.png', PICTURE)[1].tobytes()
        for headers in ({'Origin': 'http://evil.example'}, {'Origin': 'null'}, {'Origin': 'http://127.0.0.1:1'},
                        {'Host': 'evil.example:%d' % self.port}):
            status, _, body = ask(self.port, '/picture', png, **headers)
            self.assertEqual(status, 403, headers)
        self.assertEqual(ask(self.port, '/', Host='rebound.example')[0], 403)
        self.assertEqual(ask(self.port, '/page/page.js', Host='rebound.example')[0], 403)
        for headers in ({'Origin': 'http://evil.example'}, {'Host': 'rebound.example'}):
            with self.assertRaises(HTTPClientError) as refused:
                asyncio.run(self.talk([], headers))
            self.assertEqual(refused.exception.code, 403)

    async def talk(self, messages, headers=None, port=None):
        """Open the websocket, say these, and return the first that is answered."""
        live = await websocket_connect(HTTPRequest('ws://127.0.0.1:%d/live' % (port or self.port), headers=headers or {}))
        for message in messages:
            await live.write_message(message)
        first = await asyncio.wait_for(live.read_message(), WAIT_S)
        live.close()
        return json.loads(first)

    def test_nonsense_on_the_websocket_closes_it_and_nothing_else(self):
        for message in ('', '[]', '7', '{"drive": "fast"}', '{"drive": [1]}', '{"drive": [NaN, 1]}', '{"look": 5}',
                        '{"picture": 5}', '{"slide": [1, 2, 3]}', b'\xff\xfe', '{"look": ["/\\u0000", "~", ""]}'):
            self.assertIn('state', asyncio.run(self.talk([message])))
        self.assertEqual(ask(self.port, '/')[0], 200)

    def test_only_pictures_of_a_bearable_size_are_taken(self):
        for data, status, words in ((b'no picture', 422, 'That is no picture'), (b'', 422, 'That is no picture'),
                                    (bomb(30000), 422, 'at most 32 million pixels'),
                                    (bomb(6000), 422, 'at most 32 million pixels'),
                                    (cv2.imencode('.png', PICTURE)[1].tobytes()[:200], 422, 'no picture'),
                                    (b'<svg xmlns="http://www.w3.org/2000/svg"/>', 422, 'That is no picture')):
            answered, _, body = ask(self.port, '/picture', data)
            self.assertEqual(answered, status, body)
            self.assertIn(words, body.decode())
        for headers in (b'Content-Length: 17000000', b'Transfer-Encoding: chunked'):
            with socket.create_connection(('127.0.0.1', self.port), WAIT_S) as line:
                line.sendall(b'POST /picture HTTP/1.1\r\nHost: localhost\r\n' + headers + b'\r\n\r\n')
                try:
                    for _ in range(17 * 16):
                        line.sendall(b'10000\r\n' + bytes(0x10000) + b'\r\n')
                except OSError:
                    pass  # it has hung up already
                self.assertRegex(line.recv(65536), b'^HTTP/1.1 413 .*')
        # Without anybody to paint it, a good one is refused with a sentence as well.
        answered, _, body = ask(self.port, '/picture', cv2.imencode('.png', PICTURE)[1].tobytes())
        self.assertEqual((answered, body), (422, b'/exercise5_6 is not running, so nothing is changed.\n'))

    def test_it_listens_to_this_machine_alone(self):
        with open('/proc/net/tcp') as table:
            listening = [line.split()[1] for line in table if line.split()[3] == '0A']
        self.assertIn('0100007F:%04X' % self.port, listening)
        self.assertNotIn('00000000:%04X' % self.port, listening)

    def test_driving_is_off_where_it_is_turned_off_or_the_network_can_reach_it(self):
        commands = Inbox('/cmd_vel', Twist)
        self.addCleanup(commands.subscriber.unregister)
        for arguments in (['_drive:=false'], ['_address:=0.0.0.0']):
            port = free_port()
            page = node('page.py', '__name:=page_%d' % port, '_port:=%d' % port, *arguments)
            self.addCleanup(page.stop)
            page.wait_for('The page is at', '(driving is off)')
            state = asyncio.run(self.talk(['{"drive": [1, 0]}'], port=port))
            self.assertIs(state['state']['drive'], False)
            publishers = dict(Master('/test').getSystemState()[0]).get('/cmd_vel', [])
            self.assertNotIn('/page_%d' % port, publishers)
        self.assertTrue(commands.empty())

    def test_what_cannot_be_served_ends_it_with_a_sentence(self):
        for arguments, words in ((['_port:=%d' % self.port], 'cannot be served at 127.0.0.1:%d' % self.port),
                                 (['_port:=0'], '~port is 0; it must be a number from 1 to 65535'),
                                 (['_address:=nowhere'], '~address is "nowhere"; it must be an IP address'),
                                 (['_address:=192.0.2.1', '_port:=%d' % free_port()], 'cannot be served at 192.0.2.1'),
                                 (['_drive:=perhaps'], '~drive is perhaps; it must be true, false or auto')):
            page = node('page.py', '__name:=page_other', *arguments)
            self.assertEqual(page.ends(), 1)
            page.wait_for(words)
            self.assertFalse(any('Traceback' in line for line in page.lines), page.lines)
            rospy.delete_param('/page_other')


if __name__ == '__main__':
    rospy.init_node('page_http_test')
    rostest.rosrun('unit5', 'page_http_test', PageServer)
