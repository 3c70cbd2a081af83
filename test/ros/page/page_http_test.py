#!/usr/bin/env python3
"""The page's server without a browser: the addresses of web_video_server."""
import asyncio
import json
import re
import struct
import urllib.request

import cv2
import numpy as np
import rospy
import rostest
from aruco_node.messages.images import compressed_from_frame, image_from_frame
from rig.nodes.topics import Connections, until
from rig.page.server import PICTURE, ServerTest, ask
from rig.processes.started import WAIT_S
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header, String
from tornado.websocket import websocket_connect


class Stream:
    """An MJPEG stream that is read part by part."""

    def __init__(self, port, path):
        self._file = urllib.request.urlopen('http://127.0.0.1:%d%s' % (port, path), timeout=WAIT_S)
        self.kind = self._file.headers['Content-Type']
        self._boundary = re.search('boundary=(.*)', self.kind).group(1).encode()

    def part(self):
        """Read the next part; returns (headers, body)."""
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


class PageHttp(ServerTest):
    def camera(self, topic='/eye/image', kind=Image):
        """(publish, connections) of an image topic."""
        connections = Connections()
        publisher = rospy.Publisher(topic, kind, connections, queue_size=1)
        self.addCleanup(publisher.unregister)
        self.addCleanup(connections.wait, 0)  # otherwise the next test would count this one's subscriber
        make = image_from_frame if kind is Image else compressed_from_frame

        def publish(picture=PICTURE, number=1):
            publisher.publish(make(picture, Header(stamp=rospy.Time(number, 500))))
        return publish, connections

    def publish_repeatedly(self, publish):
        timer = rospy.Timer(rospy.Duration(1 / 30), lambda event: publish())
        self.addCleanup(timer.shutdown)

    def wait_until_listed(self, topic):
        """Wait until the page lists a topic."""
        until(lambda: topic in ask(self.port, '/')[2].decode())

    def test_it_lists_the_image_topics_and_no_others(self):
        self.camera()
        other = rospy.Publisher('/words', String, queue_size=1)
        self.addCleanup(other.unregister)
        self.wait_until_listed('/eye/image')
        _, headers, body = ask(self.port, '/')
        self.assertIn('href="/stream?topic=/eye/image"', body.decode())
        self.assertIn('href="/snapshot?topic=/eye/image"', body.decode())
        self.assertNotIn('/words', body.decode())
        self.assertIn("default-src 'none'", headers['Content-Security-Policy'])

    def test_a_learners_node_is_shown_beside_ours(self):
        self.camera('/exercise5_4/image')
        self.camera('/my_exercise5_4/image')
        self.wait_until_listed('data-topic="/my_exercise5_4/image"')
        page = ask(self.port, '/')[2].decode()
        self.assertEqual(re.findall('data-topic="(.*?)"', page),
                         ['/exercise5_4/image', '/my_exercise5_4/image'])

    def test_a_stream_of_jpegs_subscribes_only_while_somebody_watches(self):
        publish, connections = self.camera()
        self.wait_until_listed('/eye/image')
        self.assertEqual(connections.count, 0)
        stream = Stream(self.port, '/stream?topic=/eye/image&quality=90')
        self.assertEqual(stream.kind, 'multipart/x-mixed-replace;boundary=boundarydonotcross')
        connections.wait(1)
        sizes = []
        for number in (7, 8):
            publish(number=number)
            headers, body = stream.part()
            self.assertEqual((headers['content-type'], headers['x-timestamp']),
                             ('image/jpeg', '%d.000000500' % number))
            picture = cv2.imdecode(np.frombuffer(body, np.uint8), 1)
            np.testing.assert_allclose(picture[240, 100], PICTURE[240, 100], atol=4)
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

    def test_a_stream_goes_on_if_the_camera_comes_back_with_another_transport(self):
        stream = None
        for suffix, kind, blue in (('/compressed', CompressedImage, 10), ('', Image, 200)):
            connections = Connections()
            publisher = rospy.Publisher('/other/image' + suffix, kind, connections, queue_size=1)
            self.wait_until_listed('/other/image')
            stream = stream or Stream(self.port, '/stream?topic=/other/image')
            connections.wait(1)
            make = image_from_frame if kind is Image else compressed_from_frame
            publisher.publish(make(np.full((48, 64, 3), blue, np.uint8), Header(stamp=rospy.Time(1))))
            shown = cv2.imdecode(np.frombuffer(stream.part()[1], np.uint8), 1)
            self.assertLess(abs(int(shown[20, 30, 0]) - blue), 5)
            if kind is Image:
                stream.close()
                connections.wait(0)
            publisher.unregister()

    def test_snapshots_of_a_raw_and_of_a_compressed_camera(self):
        for topic, suffix, kind in (('/eye/image', '', Image), ('/lens/image', '/compressed', CompressedImage)):
            publish, connections = self.camera(topic + suffix, kind)
            self.wait_until_listed(topic)
            self.publish_repeatedly(publish)
            status, headers, body = ask(self.port, '/snapshot?topic=' + topic)
            self.assertEqual((status, headers['Content-Type'], headers['X-Timestamp']),
                             (200, 'image/jpeg', '1.000000500'))
            self.assertEqual(cv2.imdecode(np.frombuffer(body, np.uint8), 1).shape, (480, 640, 3))
            connections.wait(0)
        viewer = ask(self.port, '/stream_viewer?topic=/eye/image')[2].decode()
        self.assertIn('src="/stream?topic=/eye/image"', viewer)

    def test_an_impossible_request_is_answered_with_a_sentence(self):
        self.camera()
        self.wait_until_listed('/eye/image')
        words = rospy.Publisher('/words', String, queue_size=1)
        self.addCleanup(words.unregister)
        until(lambda: b'its type is' in ask(self.port, '/stream?topic=/words')[2])
        for path, status, sentence in (
                ('/stream?topic=/nowhere', 404, 'There is no image topic /nowhere'),
                ('/snapshot?topic=/nowhere', 404, 'There is no image topic /nowhere'),
                ('/stream_viewer?topic=/nowhere', 404, 'There is no image topic /nowhere'),
                ('/stream?topic=/words', 404, 'its type is std_msgs/String'),
                ('/stream', 404, 'Give the name of an image topic'),
                ('/stream?topic=%00%3Cb%3E', 404, 'Give the name of an image topic'),
                ('/stream?topic=%ff', 400, 'The server cannot answer this request (400'),
                ('/stream?topic=/eye/image&quality=101', 400,
                 'quality is "101"; it must be a whole number from 1 to 100'),
                ('/stream?topic=/eye/image&width=-5', 400, 'width is "-5"'),
                ('/stream?topic=/eye/image&type=h264', 400, 'no stream of type "h264"'),
                ('/snapshot?topic=/eye/image', 503, 'Nothing has arrived on /eye/image'),
                ('/elsewhere', 404, 'There is no such page'),
                ('/picture?name=nothing.jpg', 404, 'There is no picture "nothing.jpg" in images/')):
            answered, headers, body = ask(self.port, path)
            self.assertEqual((answered, headers['Content-Type']), (status, 'text/plain; charset=utf-8'), path)
            self.assertIn(sentence, body.decode())

    def test_the_page_gets_the_newest_frame_after_it_has_shown_the_last(self):
        publish, connections = self.camera()
        self.wait_until_listed('/eye/image')

        async def look():
            live = await self.look(connections)
            other = Stream(self.port, '/stream?topic=/eye/image')  # its parts tell when a frame has arrived
            for number in range(1, 11):
                publish(number=number)
                other.part()
            other.close()
            frames = [await self.next_frame(live)]
            await live.write_message('{"shown": "/eye/image"}')
            frames.append(await self.next_frame(live))
            live.close()
            return [head['stamp'] for head, _ in frames]
        np.testing.assert_allclose(asyncio.run(look()), [1, 10], atol=0.01)

    async def look(self, connections):
        """Open a websocket that looks at /eye/image."""
        live = await websocket_connect('ws://127.0.0.1:%d/live' % self.port)
        await live.write_message(json.dumps({'look': ['/eye/image']}))
        connections.wait(1)
        return live

    async def next_frame(self, live):
        """(head, picture) of the next frame that a websocket sends."""
        message = ''
        while isinstance(message, str):
            message = await asyncio.wait_for(live.read_message(), WAIT_S)
        length, = struct.unpack('>I', message[:4])
        return json.loads(message[4:4 + length]), cv2.imdecode(np.frombuffer(message[4 + length:], np.uint8), 1)

    def test_an_unusable_frame_is_explained_and_the_next_one_is_shown(self):
        publish, connections = self.camera()
        self.wait_until_listed('/eye/image')

        async def look():
            live = await self.look(connections)
            publish(np.zeros((1, 70000, 3), np.uint8))
            reply = ''
            while 'without' not in reply:
                reply = await asyncio.wait_for(live.read_message(), WAIT_S)
            publish()
            head, picture = await self.next_frame(live)
            live.close()
            return json.loads(reply), head, picture
        reply, head, picture = asyncio.run(look())
        self.assertEqual(reply['without'], '/eye/image')
        self.assertIn('A frame of 70000 x 1 pixels is too large', reply['why'])
        self.assertEqual((head['topic'], picture.shape), ('/eye/image', (480, 640, 3)))

    def test_frames_are_sent_as_large_as_they_are_shown(self):
        publish, connections = self.camera()
        self.wait_until_listed('/eye/image')

        async def look():
            live = await self.look(connections)
            for width, wanted in (320, (180, 320)), (5000, (1080, 1920)), (640, (360, 640)):
                await live.write_message(json.dumps({'look': ['/eye/image'], 'width': width}))
                shape = None
                while shape != wanted:  # a frame may have been on its way
                    publish(np.zeros((1080, 1920, 3), np.uint8))
                    _, picture = await self.next_frame(live)
                    shape = picture.shape[:2]
                    await live.write_message(json.dumps({'shown': '/eye/image'}))
            live.close()
        asyncio.run(asyncio.wait_for(look(), WAIT_S))

    def test_a_slow_browser_gets_fewer_frames_and_does_not_slow_others(self):
        publish, connections = self.camera()
        self.wait_until_listed('/eye/image')
        noise = np.random.RandomState(0).randint(0, 255, (480, 640, 3), np.uint8)  # about 400 kB per frame
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


if __name__ == '__main__':
    rospy.init_node('page_http_test')
    rostest.rosrun('unit5', 'page_http_test', PageHttp)
