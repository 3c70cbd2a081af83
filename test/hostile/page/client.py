"""A hostile client of the page's server: raw requests, uploads and websocket frames."""
import base64
import io
import os
import re
import socket
import struct
from urllib.parse import quote

import numpy as np
from PIL import Image
from rig.processes.started import WAIT_S

from hostile.files.png import png

ENOUGH = 1 << 20  # bytes of an answer, since a stream does not end
FORGED = 'FORGED'  # no line of a log may begin with it
SECRETS = b'root:', b'<name>unit5</name>', b'"""'  # from /etc/passwd, package.xml, and any of our modules
OUTSIDE = [
    '/../package.xml', '//package.xml', '/page/../package.xml', '/page/..%2fpackage.xml',
    '/page/%2e%2e/package.xml', '/page/%252e%252e/package.xml', '/page/..%252fpackage.xml',
    '/page/..\\package.xml', '/page/%5c..%5cpackage.xml', '/page/....//package.xml', '/page//etc/passwd',
    '/page/%2fetc%2fpasswd', '/page/page.js%00.svg', '/page/page.js/', '/page/page.js/../../package.xml',
    '/page/index.html', '/page/style.css%0a', '/page/%c0%ae%c0%ae/package.xml', '/page/..;/package.xml',
    '/./page/./../package.xml', '/page/.', '/page/..', '/page/', '/page', '/images/earth.jpg',
    '/picture?name=../package.xml', '/picture?name=%2e%2e/package.xml',
    '/picture?name=%252e%252e/package.xml', '/picture?name=/etc/passwd', '/picture?name=..%5cpackage.xml',
    '/picture?name=readme', '/picture?name=.', '/picture?name=', '/picture?name=readme/page.jpg',
    '/picture?name=earth.jpg/..', '/picture?name=./earth.jpg', '/picture?name=file:///etc/passwd',
    '/picture?name=topic:/eye/image', 'http://localhost/../package.xml', 'file:///etc/passwd',
    '/stream?topic=/etc/passwd', '/stream?topic=../../x']
ODD = [
    '', '0', '-1', '1e9', 'NaN', 'inf', '1.5', '+5', ' 7', '0x10', '\u0661\u0662', '99999999999999999999',
    '5_0', '%00', '%0d%0a' + FORGED, '%0a' + FORGED, '%ff', '%f0%9f%a4%96', '/\u00fcmlaut', '~', '~/x', '//',
    '/a//b', '{}', "'", '"><script>', '/eye/image', '/eye/image%0a', '/eye/image/', '/nowhere', '../..',
    '%2e%2e', '[]', 'a' * 3000, 'mjpeg', 'ros_compressed', 'h264', '80', '320', '4096', '4097', '&&==', ';',
    '#']
SAYINGS = [
    '', '[]', '7', 'null', 'true', '"look"', '["look"]', '{}', '{"look": 5}', '{"look": [5, null, [], {}]}',
    '{"look": {"a": 1}}', '{"look": ["/\\u0000", "~", "", "//", "\\ud800", "\\n%s"]}' % FORGED,
    '{"shown": []}', '{"shown": {}}', '{"drive": "fast"}', '{"drive": [1]}', '{"drive": [NaN, 1]}',
    '{"drive": [Infinity, -Infinity]}', '{"drive": [1e400, 0]}', '{"drive": [1%s, 0]}' % ('0' * 400),
    '{"drive": [true, false]}', '{"drive": {"a": 1, "b": 2}}', '{"drive": ["1", "1"]}', '{"drive": [[], []]}',
    '{"drive": [1, 2, 3]}', '{"picture": 5}', '{"picture": ["x"]}', '{"picture": {"a": 1}}',
    '{"picture": "\\n%s"}' % FORGED, '{"picture": "../package.xml"}', '{"slide": [1, 2, 3]}',
    '{"slide": ["noise", NaN]}', '{"slide": ["noise", 1e308]}', '{"slide": [["noise"], 1]}',
    '{"slide": ["falloff", "1"]}', '{"switch": ["light"]}', '{"switch": ["light", 1]}',
    '{"switch": [[], true]}', '{"write": ["ids"]}', '{"write": ["ids", 5]}', '{"write": [[], "x"]}',
    '{"write": ["ids", "\\ud800"]}', '{"write": ["ids", "%s"]}' % ('1,' * 30000),
    '{"write": ["dictionary", "\\n%s"]}' % FORGED,
    '{"write": ["picture", "/etc/passwd"]}', '{"slide": ["opacity", 1e6]}', '{"slide": ["picture", 1]}',
    '[' * 30000, '{"a":' * 10000, b'\xff\xfe', '{"look"', '\x00',
    '{"look": ["/%s"]}' % ('x' * 60000)]


def requests():
    """[(name, bytes, the most answers allowed)] of malformed and ambiguous requests."""
    get = b'GET / HTTP/1.1\r\nHost: localhost\r\n'
    post = b'POST /picture HTTP/1.1\r\nHost: localhost\r\n'
    hidden = b'GET /page/page.js HTTP/1.1\r\nHost: localhost\r\n\r\n'
    chunked = b'Transfer-Encoding: chunked\r\n'
    return [
        ('two lengths', post + b'Content-Length: 5\r\nContent-Length: 6\r\n\r\nabcde' + hidden, 1),
        ('length and chunks', post + b'Content-Length: 4\r\n' + chunked + b'\r\n0\r\n\r\n' + hidden, 1),
        ('chunks and length', post + chunked + b'Content-Length: 60\r\n\r\n0\r\n\r\n' + hidden, 1),
        ('odd coding', post + b'Transfer-Encoding: xchunked\r\n\r\n0\r\n\r\n' + hidden, 1),
        ('two codings', post + b'Transfer-Encoding: chunked, identity\r\n\r\n0\r\n\r\n' + hidden, 1),
        ('coding with a tab', post + b'Transfer-Encoding:\tchunked\x0b\r\n\r\n0\r\n\r\n' + hidden, 1),
        ('length with a sign', post + b'Content-Length: +5\r\n\r\nabcde' + hidden, 1),
        ('length with a line', post + b'Content-Length: 0_5\r\n\r\nabcde' + hidden, 1),
        ('negative length', post + b'Content-Length: -5\r\n\r\nabcde' + hidden, 1),
        ('length in other digits', post + 'Content-Length: \u0665\r\n\r\nabcde'.encode() + hidden, 1),
        ('chunk with a sign', post + chunked + b'\r\n+0\r\n\r\n' + hidden, 1),
        ('chunk that is none', post + chunked + b'\r\nzz\r\n\r\n' + hidden, 1),
        ('chunk of a huge size', post + chunked + b'\r\nffffffffffffffff\r\nab', 1),
        ('chunk with a long name', post + chunked + b'\r\n5;' + b'a' * 100000 + b'\r\nabcde\r\n0\r\n\r\n', 1),
        ('chunk that does not end', post + chunked + b'\r\n3\r\nabcde\r\n0\r\n\r\n' + hidden, 1),
        # Before 6.5, Tornado takes the length for another header, and the rest for a second request.
        ('space before the colon', get + b'Content-Length : 5\r\n\r\nabcde' + hidden, 2),
        ('folded header', get + b'X: a\r\n ' + FORGED.encode() + b'\r\n\r\n', 1),
        ('bare CR in a header', get + b'X: a\r' + FORGED.encode() + b': b\r\n\r\n', 1),
        ('NUL in a header', get + b'X: a\x00b\r\n\r\n', 1),
        ('many headers', get + b''.join(b'X-%d: 1\r\n' % n for n in range(5000)) + b'\r\n', 1),
        ('the same header often', get + b'X: 1\r\n' * 2500 + b'\r\n', 1),
        ('a long header', get + b'X: ' + b'a' * 10**6 + b'\r\n\r\n', 1),
        ('a long address', b'GET /' + b'a' * 10**6 + b' HTTP/1.1\r\nHost: localhost\r\n\r\n', 1),
        ('a long query', b'GET /stream?topic=/' + b'a' * 12000 + b' HTTP/1.1\r\nHost: localhost\r\n\r\n', 1),
        ('many arguments', b'GET /stream?' + b'a=1&' * 3000 + b' HTTP/1.1\r\nHost: localhost\r\n\r\n', 1),
        ('no host', b'GET / HTTP/1.1\r\n\r\n', 1), ('an empty host', b'GET / HTTP/1.1\r\nHost:\r\n\r\n', 1),
        ('two hosts', get + b'Host: evil.example\r\n\r\n', 1),
        ('a host with more in it', b'GET / HTTP/1.1\r\nHost: localhost/;script-src *\r\n\r\n', 1),
        ('a host with a user', b'GET / HTTP/1.1\r\nHost: evil.example@localhost\r\n\r\n', 1),
        ('another name', b'GET / HTTP/1.1\r\nHost: rebound.example\r\n\r\n', 1),
        ('another name with our address', b'GET / HTTP/1.1\r\nHost: 127.0.0.1.evil.example\r\n\r\n', 1),
        ('garbage', bytes(range(256)) * 20, 1),
        ('TLS', b'\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03' + bytes(500), 1),
        ('no words', b'\r\n' * 3000 + b'\r\n', 1), ('one word', b'GET\r\n\r\n', 1),
        ('HTTP/0.9', b'GET /\r\n\r\n', 1),
        ('HTTP/9.9', b'GET / HTTP/9.9\r\nHost: localhost\r\n\r\n', 1),
        ('HTTP/2', b'PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n', 1),
        ('a body where none belongs', get + b'Content-Length: 5\r\nConnection: close\r\n\r\nabcde', 1),
        ('a form that is none', b'POST / HTTP/1.1\r\nHost: localhost\r\n'
         b'Content-Type: multipart/form-data; boundary=a\r\nContent-Length: 9000\r\n'
         b'Connection: close\r\n\r\n' + b'--a\r\n\r\n\r\n' * 900, 1),
        ('a range', b'GET /page/page.js HTTP/1.1\r\nHost: localhost\r\nRange: bytes=9-5,-1,a-\r\n\r\n', 1),
        ('a date', b'GET /page/page.js HTTP/1.1\r\nHost: localhost\r\nIf-Modified-Since: never\r\n\r\n', 1),
        ('a half request', get[:20], 0),
        *(('method ' + method, b'%s %s HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' % (
            method.encode(), target), 1)
          for method in (
              'PUT', 'DELETE', 'TRACE', 'OPTIONS', 'HEAD', 'CONNECT', 'PATCH', 'get', 'FOO', 'G\u00cbT')
          for target in (b'/', b'/picture', b'/live', b'/stream', b'/page/page.js', b'*')),
    ]


def connect(port, received=None):
    """Open a connection. ``received``: the size in bytes of the receive buffer, if the client will not read."""
    line = socket.socket()
    if received:
        line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, received)
    line.settimeout(WAIT_S)
    line.connect(('127.0.0.1', port))
    return line


def say(port, data, pause=0.3, patience=WAIT_S):
    """Send raw data; returns the answer.

    The answer ends if the server hangs up, or sends nothing more for ``pause`` seconds. It is empty if nothing
    comes within ``patience`` seconds.
    """
    answer = b''
    with connect(port) as line:
        line.settimeout(patience)
        try:
            line.sendall(data)
            while len(answer) < ENOUGH:
                more = line.recv(65536)
                if not more:
                    break
                answer += more
                line.settimeout(pause)
        except (socket.timeout, OSError):
            pass  # the server has hung up, or sends nothing more
    return answer


def get(port, target, pause=0.3):
    """The answer to a GET request for a raw target."""
    request = 'GET %s HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' % target
    return say(port, request.encode(), pause)


def statuses(answer):
    """The status codes in an answer."""
    return [int(code) for code in re.findall(rb'(?:^|\n)HTTP/1\.[01] (\d{3}) ', answer)]


def query(random):
    """A random target whose query is wrong, or nearly right. ``random``: a random.Random."""
    address = random.choice([
        '/stream', '/snapshot', '/stream_viewer', '/picture', '/live', '/', '/page/page.js'])
    known = {'topic': '/eye/image'} if random.random() < 0.7 else {}
    wrong = {random.choice(['topic', 'quality', 'width', 'height', 'type', 'name', 'x']): random.choice(ODD)
             for _ in range(random.randrange(4))}
    text = '&'.join('%s=%s' % part for part in dict(known, **wrong).items())
    return address + '?' + re.sub(r'[^!-~]', lambda odd: quote(odd.group()), text)


def made(kind, width, height, **options):
    """The bytes of a black picture in this format."""
    data = io.BytesIO()
    Image.fromarray(np.zeros((height, width), np.uint8)).save(data, kind, **options)
    return data.getvalue()


def scans(count, side=4000):
    """A progressive JPEG with ``count`` superfluous scans, each as wide as the picture."""
    data = made('JPEG', side, side, progressive=True)
    last = data.rindex(b'\xff\xda')
    return data[:-2] + data[last:-2] * count + b'\xff\xd9'


def bombs():
    """{name: bytes} of uploads that are not pictures, or would take too much memory or time."""
    good, gif, bmp = made('PNG', 64, 64), made('GIF', 2, 2), made('BMP', 2, 2)
    return {
        'nothing': b'', 'text': b'no picture', 'half a PNG': good[:60],
        'SVG': b'<svg xmlns="http://www.w3.org/2000/svg"/>', 'a PNG of 60000 x 60000': png(60000, 60000),
        'a PNG of 6000 x 6000': png(6000, 6000, bytes(751 * 6000)),
        'a PNG of 2147483647 x 2147483647': png(2**31 - 1, 2**31 - 1), 'a PNG of 0 x 0': png(0, 0),
        'a PNG without rows': png(3000, 3000), 'a GIF': made('GIF', 100, 100),
        'a GIF of 65535 x 65535': gif[:6] + b'\xff\xff\xff\xff' + gif[10:],
        'a WebP of 16383 x 16383': made('WEBP', 64, 64)[:26] + b'\xff\x3f\xff\x3f' + bytes(500),
        'a BMP of 100000 x 100000': bmp[:18] + struct.pack('<ii', 100000, 100000) + bmp[26:],
        'a BMP of -1 x -1': bmp[:18] + struct.pack('<ii', -1, -1) + bmp[26:],
        'a JPEG of 2000 scans': scans(2000), 'TIFF': made('TIFF', 10, 10), 'ICO': made('ICO', 16, 16),
        'PDF': b'%PDF-1.4\n' + bytes(100), 'EPS': b'%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n',
        'noise': os.urandom(100000)}


def post(data, length=True):
    """The request that uploads a picture. ``length``: whether it says its length, or comes in chunks."""
    how = b'Content-Length: %d' % len(data) if length else b'Transfer-Encoding: chunked'
    body = data if length else b''.join(b'%x\r\n%s\r\n' % (len(data[at:at + 65536]), data[at:at + 65536])
                                        for at in range(0, len(data), 65536)) + b'0\r\n\r\n'
    return b'POST /picture HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n%s\r\n\r\n%s' % (how, body)


def upgrade(port, received=None):
    """Open a websocket; returns its connection, or None if it was refused."""
    line = connect(port, received)
    key = base64.b64encode(os.urandom(16))
    line.sendall(b'GET /live HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n'
                 b'Sec-WebSocket-Key: %s\r\nSec-WebSocket-Version: 13\r\n\r\n' % key)
    answer = b''
    while b'\r\n\r\n' not in answer:
        more = line.recv(1)
        if not more:
            break
        answer += more
    if statuses(answer) == [101]:
        return line
    line.close()
    return None


def frame(data, opcode=1, fin=True, length=None, mask=b'\0\0\0\0'):
    """A websocket frame. ``length``: the length that it claims. Without a ``mask`` it breaks the protocol."""
    length = len(data) if length is None else length
    size = bytes([length]) if length < 126 else b'\x7e' + struct.pack('>H', length) if length < 65536 else \
        b'\x7f' + struct.pack('>Q', length)
    return bytes([opcode | (0x80 if fin else 0), size[0] | (0x80 if mask else 0)]) + size[1:] + mask + data


def frames():
    """{name: bytes} of invalid websocket frames, and of far too many valid ones."""
    text = frame(b'{"look": []}')
    return {
        'a giant message': frame(b'a' * 200000), 'a claimed giant': frame(b'a', length=2**63 - 1),
        'a message in a million parts': frame(b'{', fin=False) + frame(b' ', 0, fin=False) * 100000,
        'empty parts': frame(b'', fin=False) + frame(b'', 0, fin=False) * 100000,
        'no mask': frame(b'{}', mask=b''), 'garbage': os.urandom(5000),
        'an opcode that is none': frame(b'', 7), 'a part of nothing': frame(b'a', 0),
        'a long ping': frame(b'a' * 300, 9), 'pings': frame(b'a' * 125, 9) * 50000,
        'pongs': frame(b'', 10) * 50000, 'reserved bits': bytes([text[0] | 0x70]) + text[1:],
        'an odd farewell': frame(b'a', 8), 'a farewell of no code': frame(struct.pack('>H', 5), 8),
        'no UTF-8': frame(b'\xff\xfe\xc0'), 'HTTP again': b'GET / HTTP/1.1\r\nHost: localhost\r\n\r\n'}


def closed(line):
    """Whether the server is known to have hung up."""
    line.setblocking(False)
    try:
        while True:
            if not line.recv(65536):
                return True
    except BlockingIOError:
        return False
    except OSError:
        return True
