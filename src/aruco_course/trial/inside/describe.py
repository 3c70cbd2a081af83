"""Says in plain data what the learner's code returned or raised, for ../sentences."""
import builtins
import difflib
import linecache
import os
import re
import sys

import cv2
import numpy as np

LARGEST = 1 << 24  # bytes of an image


def images(value, outputs):
    """(images, None) if the value is what was asked for, else (None, what it is)."""
    several = isinstance(value, (list, tuple))
    values = list(value) if several and outputs > 1 else [value]
    if len(values) == outputs and all(is_image(one) for one in values):
        return [np.ascontiguousarray(one[..., 0] if one.ndim == 3 and one.shape[2] == 1 else one)
                for one in values], None
    return None, describe(value)


def is_image(value):
    """Whether it is a gray or colored image of numbers from 0 to 255."""
    return (isinstance(value, np.ndarray) and value.dtype == np.uint8 and 0 < value.nbytes <= LARGEST
            and (value.ndim == 2 or (value.ndim == 3 and value.shape[2] in (1, 3))))


def describe(value, depth=0):
    """What a value is, in a few words and numbers."""
    kind = type(value)
    what = {'type': kind.__name__[:60], 'module': str(kind.__module__)[:60]}
    if isinstance(value, np.ndarray):
        what['shape'] = [int(size) for size in value.shape][:8]
        what['dtype'] = str(value.dtype)[:40]
        if value.size and value.nbytes <= 4 * LARGEST and value.dtype.kind in 'biuf':
            what['low'] = float(np.nan_to_num(value.min()))
            what['high'] = float(np.nan_to_num(value.max()))
    elif isinstance(value, (list, tuple)):
        what['length'] = len(value)
        if not depth:
            what['items'] = [describe(item, 1) for item in value[:8]]
    elif isinstance(value, (bool, int, float, str)):
        what['value'] = repr(value[:40] if isinstance(value, str) else value)[:60]
    return what


def line_now(path):
    """The line of the file that is being run, or 0."""
    frame = sys._getframe()
    while frame:
        if frame.f_code.co_filename == path:
            return frame.f_lineno
        frame = frame.f_back
    return 0


def error(raised, path, unread):
    """What was raised, where, and what may help to say why."""
    line, inner = 0, None
    last = own = None
    trace = raised.__traceback__
    while trace:
        code = trace.tb_frame.f_code
        last = trace.tb_frame
        inner = (code.co_filename, trace.tb_lineno, code.co_name)
        if code.co_filename == path:
            line, own = trace.tb_lineno, trace.tb_frame
        trace = trace.tb_next
    beside = ''
    if isinstance(raised, SyntaxError) and raised.filename:
        inner = (raised.filename, raised.lineno or 0, '')
        if raised.filename == path:
            line = raised.lineno or 0
    if inner and inner[0] != path and os.path.dirname(os.path.abspath(inner[0])) == os.path.dirname(path):
        beside = '%s, line %d' % (os.path.basename(inner[0]), inner[1])
    try:
        message = str(raised)
    except Exception:
        message = ''
    return {'type': type(raised).__name__[:80],
            'types': [kind.__name__[:80] for kind in type(raised).__mro__[:8]],
            'message': message[:2000], 'line': line, 'beside': beside,
            'near': near(raised, last), 'opencv': cv2.__version__,
            'name': str(getattr(raised, 'name', None) or '')[:200],
            'file': str(getattr(raised, 'filename', None) or '')[:500],
            'values': values_of(path, line, own), 'unread': unread}


def values_of(path, line, frame):
    """What the names have in them that are in this line of the file."""
    if frame is None:
        return {}
    names = dict.fromkeys(re.findall(r'[A-Za-z_]\w*', linecache.getline(path, line)))
    there = dict(frame.f_globals, **frame.f_locals)
    return {name[:60]: describe(there[name]) for name in list(names)[:30]
            if name in there and not isinstance(there[name], (type(sys), type)) and not callable(there[name])}


def near(raised, frame):
    """The name that may have been meant where a name is not known, or ''."""
    words = str(raised).split("'")
    if isinstance(raised, AttributeError) and len(words) >= 4:
        names = dir(raised.obj if hasattr(raised, 'obj') else sys.modules.get(words[1], ()))
        wanted = words[3]
    elif isinstance(raised, NameError) and len(words) >= 2:
        wanted = words[1]
        names = list(frame.f_globals) + list(frame.f_locals) if frame else []
        # Most short words are like one of these.
        names += [name for name in dir(builtins) if sorted(name) == sorted(wanted)]
    elif isinstance(raised, ModuleNotFoundError):
        wanted = (raised.name or '').split('.')[0]
        names = ['cv2', 'numpy', 'rospy', 'cv_bridge', 'sensor_msgs', 'message_filters', 'rospkg']
        if not difflib.get_close_matches(wanted, names, 1, 0.7):
            names = list(getattr(sys, 'stdlib_module_names', ()))
    elif isinstance(raised, ImportError) and len(words) >= 4:
        wanted = words[1]
        names = dir(sys.modules.get(words[3], ()))
    else:
        return ''
    same = [name for name in names if name.lower() == wanted.lower() and name != wanted]
    return (same or difflib.get_close_matches(wanted, [name for name in names if name != wanted], 1, 0.7)
            or [''])[0][:80]
