"""Values to try for a parameter: of wrong types, extreme, and close to the limits.

A parameter server gives whatever XML-RPC can carry. dynamic_reconfigure gives
texts, floats, ints and bools. A YAML file of areas may also have dates and
ints of any size.
"""
import base64
import datetime
import math
import os
import sys
from decimal import Decimal
from xml.sax.saxutils import escape
from xmlrpc.client import Binary, DateTime

import numpy as np
from aruco_ar.settings.declaration import Choice, Number

LONG = 100 * 1000
SHORT = 1000
DEPTH = 10 * 1000
INT32, INT64 = 2**31, 2**63
NUMBERS = (0, 1, -1, 2, 0.0, -0.0, 0.5, 1.0, -1.0, 1e-12, 5e-324, -5e-324, sys.float_info.min,
           sys.float_info.max, -sys.float_info.max, math.nan, math.inf, -math.inf, INT32 - 1, -INT32, INT32,
           -INT32 - 1, INT64 - 1, INT64, -INT64, 2**53 + 1, 10**30, 10**400, -10**400)
WORDS = ('', ' ', '\t\n', 'none', 'None', 'null', '~', 'yes', 'no', 'on', 'off', 'true', 'True', 'false',
         'auto', 'AUTO', 'nan', 'inf', '-inf', '1e999', '0x10', '1_000', '0.5', '1', '-1', '1,5', '12345',
         '\u0663', 'a' * LONG, '9' * LONG, ',' * LONG, '[' * LONG, ' ' * LONG, 'é', 'Grün',
         '\u202eright to left', '\U0001f600', 'e\u0301' * 50, 'two\nlines', 'Fatal: all is lost.\nall is well',
         'carriage\rreturn', 'bell\a', '\x1b[31mred\x1b[0m', 'back\b\b\b\b', 'nul\0nul', '\0', '\x7f', '\x85',
         '\ufeff', '\ufffe', '%s %d %n', '{0} {id!r} {id.__class__}', '{}', '{', '%', '"quoted"', "'", '\\',
         '$(arg camera)', '$HOME', '`true`', '; true', '<a>&amp;</a>', '- a: [1, 2', '{a: 1}', '[1, 2',
         '!!python/object:os.system', '&a [*a]', '2020-02-30', '12:30:45')
PATHS = ('.', '..', '/', '//', '../..', '../../../../../../etc/passwd', '/etc/shadow', '/dev/null', '/dev/full',
         '/dev/tty', '/proc/self/mem', '/proc/self/environ', '/sys', '~', '~nobody/x', '~no such user/x',
         '~' + 'a' * LONG, '/' * LONG, '/' + 'a/' * 2500, 'x' * 256, '/nonexistent/x', 'images',
         'config/wall.yaml', 'package.xml', 'images/earth.jpg/x', 'file:///etc/passwd',
         'http://localhost:1/x.png', 'rtsp://localhost:1/', 'x.jpg\n', 'images/%06d.jpg', 'topic:',
         'config/areas.yaml', '/dev/zero', '/dev/urandom')
TOPICS = ('topic: ', 'topic:/', 'topic:~', 'topic://bad name', 'topic:/a//b', 'topic:9', 'topic:a b',
          'topic:/a-b', 'topic:é', 'topic:~image', 'topic:~image/compressed', 'topic:topic:x',
          'topic:/' + 'a' * LONG, '//bad name', '/a//b', '9lives', 'a-b', 'a b', '/', '~', '~image',
          '/camera/rgb/image_raw', 'camera/{id}', '{id}', '{id}{id}', '/{id}', '{id', '{ID}')
IDS = ([], [1], [1, 2, 3], [1, 2, 3, 3], [1, 2, 3, 4, 5], [1, 2, 3, 10**9], [1, 2, 3, INT32], [1, 2, 3, 10**30],
       [1, 2, 3, -1], [0, 1, 2, 249], [0, 1, 2, 250], [1, 2, 3, 4.0], [1, 2, 3, True], [1, 2, 3, None],
       [1, 2, 3, [4]], [1, 2, 3, 'x'], ['1', '2', '3', '4'], [math.nan] * 4, list(range(5000)), '1,2,3,4',
       '1,2,3,3', '1,2,3,-4', '1,2,3,250', '1;2;3;4', '1,,2,,3,,4', '[1,2,3,4', '1 2 3 4 5', '1,2,3,1_0',
       '1.0,2,3,4', 'any,1', 'ANY', '1-4', '1,2,3,' + '9' * 5000)
SIZES = ({'7': 0.1}, {'7': 0}, {'7': -1}, {'7': math.nan}, {'7': math.inf}, {'7': 'x'}, {'7': None},
         {'7': True}, {'7': [0.1]}, {'7': {}}, {'7': 10**400}, {'x': 0.1}, {'': 0.1}, {'-7': 0.1}, {'7.5': 0.1},
         {'1_0': 0.1}, {str(10**30): 0.1}, {'7': 10, '8': 0.001}, {'7': 10.0001}, {'7': 0.000999},
         {str(number): 0.1 for number in range(3000)}, {'07': 0.1, '7': 0.2}, '7: 0.1', '7: 0.1, 7: 0.2',
         '7: 0.1,', '7:', ':', ':0.1', '7: 0.1: 3', '7: 1e-1', '7: nan', '7: 0x1', '-1: 0.1', '{}', '{7: 0.1',
         [['7', 0.1]], ['7: 0.1'], '7 = 0.1')
LENSES = ([0] * 5, [0.0] * 4, [0.0] * 6, [math.nan] * 5, [math.inf, 0, 0, 0, 0], [1e300] * 5, [5e-324] * 5,
          [10**400] * 5, ['0'] * 5, ['x'] * 5, [None] * 5, [True] * 5, [[0]] * 5, '00000', '0 0 0 0 0',
          '0,0,0,0,0', {'k1': 0, 'k2': 0, 'p1': 0, 'p2': 0, 'k3': 0},
          {str(number): number for number in range(5)}, [-100.0] * 5, [1e6, -1e6, 1e6, -1e6, 1e6],
          [-0.3, 0.1, 0, 0, 0])


def others():
    """Values that are neither numbers nor texts."""
    deep = []
    for _ in range(DEPTH):
        deep = [deep]
    nested = [[[[[[[[[[[{'x': [[[[[[]]]]]]}]]]]]]]]]]]
    wide = {'key %d' % number: list(range(10)) for number in range(1000)}
    return [None, True, False, [], {}, [None], [[]], [1.0], ['raw'], {'': ''}, {'x': 1},
            {'x': {'y': {'z': [1, {}]}}}, wide, ['x' * LONG], [0] * LONG, deep, nested, b'', b'bytes',
            bytes(range(256)), Binary(b''), Binary(b'\0' * LONG), DateTime('20200230T12:30:45'), DateTime(0),
            datetime.datetime(2020, 2, 2), datetime.date(1, 1, 1), datetime.time(1), Decimal('1e400'), 1j, (),
            (1, 2, 3, 4), {1, 2}, object]


def around(low, high):
    """Numbers just inside and just outside of [low, high]."""
    return [float(value) for bound in (low, high) for value in (bound, np.nextafter(bound, math.inf),
                                                                np.nextafter(bound, -math.inf))] + \
        [low, high, low - 1, high + 1, (low + high) / 2]


def values(parameter, random, count=20):
    """Values to try for a Parameter. ``count`` of them are random."""
    kind = parameter.kind
    own = around(kind.low, kind.high) if isinstance(kind, Number) else []
    if isinstance(kind, Choice):
        own = [changed for text in kind.choices
               for changed in (text, text.lower(), text + ' ', text[:-1], [text])]
    common = [*NUMBERS, *WORDS, *PATHS, *TOPICS, *IDS, *SIZES, *LENSES, *others()]
    return own + common + [_any(random, common) for _ in range(count)]


def _any(random, common):
    """A random value."""
    chance = random.random_sample()
    if chance < 0.3:
        return float(np.frombuffer(random.bytes(8))[0])
    if chance < 0.5:
        return ''.join(chr(code) for code in random.randint(1, 0xd7ff, random.randint(1, 60)))
    if chance < 0.6:
        return bytes(random.bytes(random.randint(1, 60))).decode('latin-1')
    return [common[index] for index in random.randint(0, len(common), random.randint(0, 6))]


def typed(given):
    """The values that a dynamic_reconfigure/Config can carry."""
    return [value for value in given if isinstance(value, (float, bool))
            or (isinstance(value, str) and as_xml(value)) or (type(value) is int and -INT32 <= value < INT32)]


def short(given):
    """The values that are fast to write and to read, even as YAML."""
    return [value for value in given if len(as_xml(value) or LONG * 'x') < SHORT]


def as_xml(value):
    """The value as XML-RPC, even if Python's own client refuses it; None if there is no way to write it."""
    try:
        return '<value>%s</value>' % _as_xml(value)
    except (TypeError, UnicodeEncodeError, RecursionError):
        return None


def _as_xml(value):
    for kind, tag in (bool, 'boolean'), (int, 'int'), (float, 'double'), (Decimal, 'bigdecimal'):
        if isinstance(value, kind):
            return '<%s>%s</%s>' % (tag, int(value) if kind is bool else value, tag)
    if value is None:
        return '<nil/>'
    if isinstance(value, str):
        value.encode()  # raises an error for a lone surrogate
        return '<string>%s</string>' % escape(value)
    if isinstance(value, (bytes, Binary)):
        return '<base64>%s</base64>' % base64.b64encode(getattr(value, 'data', value)).decode()
    if isinstance(value, (DateTime, datetime.datetime)):
        return '<dateTime.iso8601>%s</dateTime.iso8601>' % DateTime(value)
    if isinstance(value, (list, tuple)):
        return '<array><data>%s</data></array>' % ''.join('<value>%s</value>' % _as_xml(each) for each in value)
    if isinstance(value, dict):
        return '<struct>%s</struct>' % ''.join('<member><name>%s</name><value>%s</value></member>' % (
            escape(key), _as_xml(each)) for key, each in value.items())
    raise TypeError('XML-RPC has no %s' % type(value))


def pipe(folder):
    """The path of a pipe in a folder. Opening it for reading would block forever."""
    path = os.path.join(folder, 'pipe')
    if not os.path.exists(path):
        os.mkfifo(path)
    return path
