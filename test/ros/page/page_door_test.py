#!/usr/bin/env python3
"""Access to the page's server: who may ask for what, and what it refuses."""
import asyncio
import json
import queue
import socket

import cv2
import rospy
import rostest
from geometry_msgs.msg import Twist
from hostile.files.png import png
from rig.nodes.topics import Inbox
from rig.page.server import PICTURE, ServerTest, ask, free_port
from rig.processes.started import WAIT_S, node
from rosgraph import Master
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect


def bomb(side):
    """A PNG of a few bytes with side x side pixels."""
    return png(side, side, bytes((side // 8 + 1) * side))


class PageDoor(ServerTest):
    def test_no_path_leads_out_of_the_served_folders(self):
        secret = b'unit5</name>'
        for path in ('/page/../package.xml', '/page/..%2fpackage.xml', '/page/%2e%2e/package.xml',
                     '/../package.xml', '//package.xml', '/page//etc/passwd', '/page/index.html',
                     '/page/....//package.xml', '/picture?name=../package.xml',
                     '/picture?name=%2e%2e/package.xml', '/picture?name=/etc/passwd', '/picture?name=readme',
                     '/page/page.js/../../package.xml'):
            with socket.create_connection(('127.0.0.1', self.port), WAIT_S) as line:
                line.sendall(b'GET %s HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' % path.encode())
                answer = b''.join(iter(lambda: line.recv(65536), b''))
            self.assertRegex(answer, b'^HTTP/1.1 40[034]', path)
            self.assertNotIn(secret, answer)
            self.assertNotIn(b'root:', answer)
        self.assertEqual(ask(self.port, '/page/page.js')[0], 200)

    def test_other_sites_and_other_host_names_are_refused(self):
        png = cv2.imencode('.png', PICTURE)[1].tobytes()
        for headers in ({'Origin': 'http://evil.example'}, {'Origin': 'null'}, {'Origin': 'http://127.0.0.1:1'},
                        {'Host': 'evil.example:%d' % self.port}):
            self.assertEqual(ask(self.port, '/picture', png, **headers)[0], 403, headers)
        self.assertEqual(ask(self.port, '/', Host='rebound.example')[0], 403)
        self.assertEqual(ask(self.port, '/page/page.js', Host='rebound.example')[0], 403)
        for headers in ({'Origin': 'http://evil.example'}, {'Host': 'rebound.example'}):
            with self.assertRaises(HTTPClientError) as refused:
                asyncio.run(self.talk([], headers))
            self.assertEqual(refused.exception.code, 403)

    async def talk(self, messages, headers=None, port=None):
        """Open the websocket, send these messages, and return the first reply, or None if it was closed."""
        live = await websocket_connect(HTTPRequest('ws://127.0.0.1:%d/live' % (port or self.port),
                                                   headers=headers or {}))
        for message in messages:
            await live.write_message(message)
        first = await asyncio.wait_for(live.read_message(), WAIT_S)
        live.close()
        return first and json.loads(first)  # None if the connection was closed

    def test_nonsense_on_the_websocket_closes_only_that_websocket(self):
        for message in ('', '[]', '7', '{"drive": "fast"}', '{"drive": [1]}', '{"drive": [NaN, 1]}',
                        '{"look": 5}', '{"picture": 5}', '{"slide": [1, 2, 3]}', b'\xff\xfe',
                        '{"look": ["/\\u0000", "~", ""]}', '[' * 30000, '{"drive": [1%s, 0]}' % ('0' * 400),
                        '{"slide": ["noise", NaN]}'):
            asyncio.run(self.talk([message]))
        self.assertIn('state', asyncio.run(self.talk([])))

    def test_pictures_that_are_too_large_or_unreadable_are_refused(self):
        for data, status, words in ((b'no picture', 422, 'not a picture'),
                                    (b'', 422, 'not a picture'),
                                    (bomb(30000), 422, 'at most 32 million pixels'),
                                    (bomb(6000), 422, 'at most 32 million pixels'),
                                    (cv2.imencode('.png', PICTURE)[1].tobytes()[:200], 422, 'cannot be read'),
                                    (b'<svg xmlns="http://www.w3.org/2000/svg"/>', 422, 'not a picture')):
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
                    pass  # the server has already hung up
                self.assertRegex(line.recv(65536), b'^HTTP/1.1 413 .*')
        # If no node can paint it, even a good picture is refused with a sentence.
        answered, _, body = ask(self.port, '/picture', cv2.imencode('.png', PICTURE)[1].tobytes())
        self.assertEqual((answered, body.decode()), (
            422, '/exercise5_6 does not answer: it is not running. Start it, or look at its log.\n'))

    def test_it_can_only_be_reached_from_this_machine(self):
        with open('/proc/net/tcp') as table:
            listening = [line.split()[1] for line in table if line.split()[3] == '0A']
        self.assertIn('0100007F:%04X' % self.port, listening)
        self.assertNotIn('00000000:%04X' % self.port, listening)

    def test_driving_is_off_if_it_is_turned_off_or_the_network_can_reach_the_page(self):
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

    def test_a_robot_is_stopped_if_its_driver_sends_nothing_though_still_connected(self):
        commands = Inbox('/cmd_vel', Twist)
        self.addCleanup(commands.subscriber.unregister)

        async def drive():
            live = await websocket_connect('ws://127.0.0.1:%d/live' % self.port)
            loop = asyncio.get_running_loop()
            speeds = []
            while not any(map(any, speeds)):  # until the subscriber is connected; it is stopped if this is slow
                await live.write_message('{"drive": [1, -0.5]}')
                try:
                    command = await loop.run_in_executor(None, lambda: commands.get(timeout=0.2))
                    speeds.append((command.linear.x, command.angular.z))
                except queue.Empty:
                    continue
            while speeds[-1] != (0, 0):
                command = await loop.run_in_executor(None, commands.next)
                speeds.append((command.linear.x, command.angular.z))
            await live.write_message('{"look": []}')  # the websocket is still open
            live.close()
            return speeds
        speeds = asyncio.run(drive())
        driven = next(filter(any, speeds))
        self.assertAlmostEqual(driven[0], 0.3)
        self.assertAlmostEqual(driven[1], -0.4)

    def test_an_impossible_address_or_parameter_ends_it_with_a_sentence(self):
        for arguments, words in ((['_port:=%d' % self.port], 'cannot be served at 127.0.0.1:%d' % self.port),
                                 (['_port:=0'], '~port is 0; it must be a number from 1 to 65535'),
                                 (['_address:=nowhere'], '~address is "nowhere"; it must be an IP address'),
                                 (['_address:=192.0.2.1', '_port:=%d' % free_port()],
                                  'cannot be served at 192.0.2.1'),
                                 (['_drive:=perhaps'], '~drive is "perhaps"; it must be true, false or auto')):
            page = node('page.py', '__name:=page_other', *arguments)
            self.assertEqual(page.ends(), 1)
            page.wait_for(words)
            self.assertFalse(any('Traceback' in line for line in page.lines), page.lines)
            rospy.delete_param('/page_other')


if __name__ == '__main__':
    rospy.init_node('page_door_test')
    rostest.rosrun('unit5', 'page_door_test', PageDoor)
