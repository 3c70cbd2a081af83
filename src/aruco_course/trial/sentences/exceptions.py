"""What to say of an exception that the learner's code raised."""
from __future__ import annotations

import ast
import linecache
import re
from typing import Any, Sequence

import cv2

from aruco_course.check import Fault
from aruco_course.trial.names import Function, read_tree

from .gone import TODAY, of_gone
from .opencv import of_opencv
from .shapes import Values, arrays_of, fit_of

# Such as "module 'cv2.aruco' has no attribute 'Dictionary_get'".
ATTRIBUTE = re.compile(r"(?:module|type object)? ?'([^']+)' (?:object )?has no attribute '([^']+)'")
# What people take for the names of modules.
OTHER_NAMES = {'opencv': 'cv2', 'cv': 'cv2', 'OpenCV': 'cv2', 'cv3': 'cv2', 'cv4': 'cv2', 'open_cv': 'cv2',
               'opencv_python': 'cv2', 'np': 'numpy as np', 'cvbridge': 'cv_bridge', 'CvBridge': 'cv_bridge',
               'ros': 'rospy', 'sensor_msg': 'sensor_msgs'}
PIP = {'cv2': 'opencv-contrib-python', 'numpy': 'numpy', 'PIL': 'pillow', 'yaml': 'PyYAML',
       'imutils': 'imutils', 'scipy': 'scipy', 'skimage': 'scikit-image', 'matplotlib': 'matplotlib',
       'sklearn': 'scikit-learn'}


class Error:
    """What inside/describe.py told of an exception, with nothing in it believed."""

    def __init__(self, record: dict[str, Any], path: str, function: str | None,
                 outputs: Sequence[str] = ('image',)) -> None:
        self.type = str(record['type'])
        self.types = [str(one) for one in record['types']]
        self.message = str(record['message'])
        self.line = int(record['line'])
        self.beside = str(record['beside'])
        self.near = str(record['near'])
        self.name = str(record['name'])
        self.file = str(record['file'])
        self.opencv = str(record['opencv'])
        self.stage = str(record['stage'])
        self.call = int(record['call'])
        self.path, self.function, self.outputs = path, function, outputs
        self.values: Values = {str(name): dict(what) for name, what in record.get('values', {}).items()}
        unread = record.get('unread')
        self.unread = (str(unread[0]), int(unread[1])) if unread else None
        linecache.checkcache(path)
        self.source = linecache.getline(path, self.line).strip() if self.line else ''

    def is_a(self, kind: str) -> bool:
        """Whether it is an exception of this kind."""
        return kind in self.types


def fault_of_error(record: dict[str, Any], path: str, function: str | None,
                   outputs: Sequence[str] = ('image',)) -> Fault:
    """The sentence for an exception, and the line of the learner's file that raised it.

    ``outputs``: the names of the images that the function should return.
    """
    error = Error(record, path, function, outputs)
    place = 'Line %d' % error.line if error.line else 'Frame %d' % error.call if error.call else ''
    what = of_error(error)
    if error.beside:
        what += ' (It is %s.)' % error.beside
    return Fault(what, place)


def of_error(error: Error) -> str:
    """What happened, and what helps; if neither is known, what Python says."""
    for kind, say in SENTENCES:
        if error.is_a(kind):
            what = say(error)
            if what:
                return what
    what = '%s: %s' % (error.type, one_line(error.message)) if error.message else error.type
    return what[:400] + ('' if what.endswith(('.', '!', '?')) else '.')


def one_line(text: str) -> str:
    """A text without line breaks."""
    return ' '.join(text.split())


def of_node(error: Error) -> str:
    name = error.message
    if error.function is None:
        return 'rospy.%s is called, but this program needs no ROS. Leave it out.' % name
    where = 'while the file is imported' if error.stage == 'load' else 'in %s' % error.function
    if name == 'get_param':
        return ('rospy.get_param is called %s, where there is no ROS to ask. Call it in main(), or give it a '
                'value to take then.' % where)
    if error.stage == 'load':
        return ('rospy.%s is called %s. What the node does belongs into main(), which is called below '
                '"if __name__ == \'__main__\':".' % (name, where))
    return 'rospy.%s is called %s, for each frame. It belongs into main().' % (name, where)


def of_exit(error: Error) -> str:
    if error.function is None:
        return 'the program ends with an exit code that says that something failed (exit). Leave that out.'
    if error.stage == 'load':
        return 'the file ends Python while it is imported (exit). Leave that out, or move it into main().'
    return '%s ends the whole program (exit). To leave the function alone, use return.' % error.function


def of_interrupt(error: Error) -> str:
    return 'the code interrupts itself (%s).' % error.type


def of_memory(error: Error) -> str:
    return ('this takes more memory than the 1 GB that it may have%s. Look at the size of what is made '
            'here.' % (
        ': ' + one_line(error.message).rstrip('.') if error.message else ''))


def of_recursion(error: Error) -> str:
    return 'a function calls itself, and that call calls itself, without end.'


def of_end_of_file(error: Error) -> str:
    if 'EOF when reading' in error.message:
        return 'input() waits for a key, and a node has no keyboard. Leave it out.'
    return ''


def of_module(error: Error) -> str:
    root = error.name.split('.')[0]
    if root == 'aruco':
        return 'there is no module aruco. It is a part of OpenCV: "from cv2 import aruco".'
    if root in OTHER_NAMES:
        return 'there is no module %s: it is "import %s".' % (error.name, OTHER_NAMES[root])
    if error.name == 'cv2.aruco':
        return of_no_aruco(error)
    if error.near and error.near != root:
        return 'there is no module %s. Is %s meant?' % (error.name, error.near)
    return 'there is no module %s here. Is its name right? "pip install %s" may bring it.' % (
        error.name, PIP.get(root, root))


def of_no_aruco(error: Error) -> str:
    return ('your OpenCV, %s, has no aruco: "pip uninstall opencv-python", then "pip install '
            'opencv-contrib-python".'
            % error.opencv)


def of_import(error: Error) -> str:
    match = re.match(r"cannot import name '([^']+)' from '([^']+)'", error.message)
    if not match:
        return ''
    name, module = match.groups()
    if module.startswith('cv2'):
        if name == 'aruco':
            return of_no_aruco(error)
        gone = of_gone(name, error.opencv)
        if gone:
            return gone
    return '%s has no %s.%s' % (module, name, meant(error))


def others_gone(error: Error) -> str:
    """What else of the file is gone, so that it need not be found one by one."""
    others = [(number, name) for number, name in others_of(error, r'\baruco\.(\w+)\(')
              if name in TODAY and not hasattr(cv2.aruco, name)]
    return ''.join(' In line %d, %s is %s now.' % (number, name, TODAY[name]) for number, name in others[:3])


def meant(error: Error) -> str:
    """A question that goes behind a sentence about a name."""
    return ' Is %s meant?' % error.near if error.near else ''


def of_attribute(error: Error) -> str:
    match = ATTRIBUTE.match(error.message)
    if not match:
        return ''
    holder, name = match.groups()
    if holder == 'cv2' and name == 'aruco':
        return of_no_aruco(error)
    if holder.startswith('cv2'):
        gone = of_gone(name, error.opencv)
        if gone:
            return gone + others_gone(error)
    if holder == 'NoneType':
        return of_none(error, 'it has no %s' % name)
    if holder in ('tuple', 'list') and name in ('shape', 'astype', 'reshape', 'sum', 'mean', 'copy', 'dtype'):
        return ('this is a %s, and only an array has %s: np.array(…) makes one of it. (detectMarkers returns a '
                'tuple of arrays, one for each tag.)' % (holder, name))
    if holder == 'numpy.ndarray' and name in ('append', 'add', 'extend'):
        return 'an array has no %s. Collect in a list, and make an array of it at the end: np.array(…).' % name
    if holder == 'numpy':
        return of_numpy(name) or 'NumPy has no %s.%s' % (name, meant(error))
    if holder == 'cv2':
        return 'OpenCV %s has no cv2.%s.%s' % (error.opencv, name, meant(error))
    return '%s has no %s.%s' % (holder, name, meant(error))


def of_numpy(name: str) -> str:
    if name in ('int', 'float', 'bool', 'object', 'str', 'long'):
        return 'NumPy has no np.%s any more: write %s alone, or np.int32, np.float32.' % (name, name)
    if name == 'float_':
        return 'NumPy has no np.float_ any more: it is np.float64 now.'
    return ''


def of_none(error: Error, but: str) -> str:
    """The sentence for a None where something else was expected. ``but``: what cannot be done with it."""
    if error.unread and error.stage:
        return of_unread(error)
    name = next((name for name, what in error.values.items() if what['type'] == 'NoneType'), 'something')
    if name == 'ids' or (name == 'something' and re.search(r'\bids\b', error.source)):
        return ('ids is None here, and %s: detectMarkers found no tag. Ask "if ids is None" first, and '
                '%s.' % (but, back(error)))
    return ('%s is None here, and %s. Where does it come from? OpenCV gives ids = None without '
            'tags, and imread gives None if it finds no file.' % (name, but))


def back(error: Error) -> str:
    """What to return without tags."""
    if 'mask' in error.outputs:
        return 'return a black mask of the size of the image, and the image as it is'
    return 'return the image as it is'


def of_unread(error: Error) -> str:
    assert error.unread
    name, line = error.unread
    if name.startswith('~'):
        return ('cv2.imread found no image at %s, and gave None instead: only a shell knows what ~ is. '
                'os.path.expanduser(path) replaces it.' % name)
    where = name + (' (line %d)' % line if line and line != error.line else '')
    if error.function and any(one.lineno <= line <= last_line(one) for one in functions(error.path)
                              if one.name == error.function):
        return ('cv2.imread found no image at %s, and gave None instead. Leave it out: the function is given '
                'all images that it needs.' % where)
    return ('cv2.imread found no image at %s, and gave None instead. Is the path right? Make it from that of '
            'your file: os.path.join(os.path.dirname(os.path.abspath(__file__)), …).' % where)


def of_type(error: Error) -> str:
    message = error.message
    match = re.match(r"(?:descriptor|unbound method) '(\w+)'.* '?cv2\.(?:aruco\.)?(\w+)", message)
    if match:
        return ('%s belongs to %s, of which one is made first: %s(…).%s(…).' % (
            match.group(1), match.group(2), match.group(2), match.group(1)))
    if "'NoneType'" in message:
        if 'len()' in message:
            return of_none(error, 'it has no length')
        if 'not iterable' in message or 'unpack' in message:
            return of_none(error, 'there is nothing to go through')
        if 'not subscriptable' in message:
            return of_none(error, 'there is nothing at [0]')
        return of_none(error, 'Python says: %s' % one_line(message))
    match = re.match(r"descriptor '(\w+)' for '([\w.]+)' objects doesn't apply", message)
    if match:
        return '%s is a class, and one object of it is made first: %s(…).%s(…).' % (
            match.group(2), match.group(2), match.group(1))
    match = re.match(r'(?:[\w.<>]*\.)?(\w+)\(\) (?:takes|missing|got) ', message)
    if match and error.function and match.group(1) == error.function and not error.line \
            and not error.source.startswith('def '):
        return '%s cannot be called with the arguments that it gets: %s.' % (error.function, one_line(message))
    if message.startswith('Expected cv::'):
        return of_opencv(message, error.source, error.values)
    if 'only integer scalar arrays' in message or 'indices must be integers' in message:
        return 'an index must be a whole number (%s): int(…), or .astype(int) for an array.' % one_line(message)
    if 'can only concatenate str' in message:
        return 'a text and a number cannot be added. str(…) makes a text of a number.'
    if "'float' object cannot be interpreted as an integer" in message:
        return 'this must be a whole number: int(…), or // instead of /.'
    if 'unhashable' in message and 'ndarray' in message:
        return 'an array cannot be a key. Take the number in it, such as int(ids[i][0]).'
    if 'return arrays must be of ArrayType' in message:
        return 'this function of NumPy takes one argument. np.arctan2(y, x) takes two.'
    if re.search('only (size-1|length-1) arrays', message):
        return ('there is an array of several numbers where one is needed. corners[i][0] has all four corners '
                'of a tag, corners[i][0][0] the first of them, and corners[i][0][0][0] its x.')
    if 'not callable' in message and 'key=' in error.source:
        return 'key= wants a function, which is called for each thing to be sorted: key=lambda point: ….'
    if "'tuple' object is not callable" in message or 'object is not callable' in message:
        return ('something that is no function is called here, with (…): %s. Are [ ] meant, or is a comma '
                'missing?' % one_line(message))
    if "'tuple' object does not support item assignment" in message:
        return 'a tuple cannot be changed. Make a list or an array of it first: np.array(…).'
    if 'list indices must be integers or slices, not tuple' in message:
        return 'a list cannot be indexed with two numbers; an array can: np.array(…) makes one of it.'
    return ''


def of_value(error: Error) -> str:
    message = error.message
    if 'could not be broadcast' in message or 'could not broadcast' in message:
        fit = fit_of(error.values)
        if fit:
            return 'these arrays do not have the same shape: %s' % fit
        return ('these arrays do not have the same shape: %s. For images: the same height and width, and the '
                'same number of channels?' % one_line(message).rstrip('.'))
    if 'truth value of an array' in message and re.search(r'\b(sorted|min|max|sort)\(', error.source):
        return ('points cannot be compared, only numbers. Name the number that counts: key=lambda point: '
                'point[0], for example.')
    if 'truth value of an array' in message:
        return ('an array of several values is neither true nor false. Is "if ids is None", "ids is not None", '
                'or .any(), .all() meant?')
    match = re.match(r'(?:not enough|too many) values to unpack \(expected (\d+)(?:, got (\d+))?\)', message)
    if match:
        many = message.startswith('too')
        if 'shape' in error.source:
            return ("a colored image's shape has three numbers (height, width, channels), a gray one's has "
                    'two. image.shape[:2] has two of both.')
        if 'findContours' in error.source:
            return 'cv2.findContours returns two values today: contours, hierarchy.'
        if 'detectMarkers' in error.source:
            return 'detectMarkers returns three values: corners, ids, rejected.'
        return 'there are %s values on the right than the %s names on the left.' % (
            'more' if many else 'fewer', match.group(1))
    if 'cannot reshape array' in message:
        return ('this array cannot have that shape: %s. Were all four tags found?'
                % one_line(message).rstrip('.'))
    if 'inhomogeneous' in message:
        return 'these values do not make an array, since they are not all of the same length.'
    if 'argmin of an empty' in message or 'argmax of an empty' in message or 'zero-size array' in message:
        return 'there are no points here: no tag was found. Ask for that first, and %s.' % back(error)
    if 'assignment destination is read-only' in message:
        return 'this array may not be changed; its .copy() may.'
    return ''


def of_index(error: Error) -> str:
    match = re.match(r'index (-?\d+) is out of bounds for axis (\d+) with size (\d+)', error.message)
    if match:
        index, axis, size = match.groups()
        if re.search(r'arg(min|max|sort)', error.source):
            return ('there is no [%s] here, only %s of them. argmin and argmax count through '
                    'all numbers of an array, row by row: is there one number for each point? '
                    'np.diff(points, axis=1) and points.sum(axis=1) have one.' % (index, size))
        shapes = [what['shape'] for what in arrays_of(error.values).values()]
        if any(len(shape) > 1 and min(shape[:2]) > 16 for shape in shapes):  # an image, no list of points
            return ('there is no place %s along axis %s, which has %s. An image is indexed image[y, x]: are x '
                    'and y exchanged?' % (index, axis, size))
        return ('there is no [%s] here, only %s of them, and counting begins with 0. Were as many tags found '
                "as you expect? A tag's id is not its place in the list." % (index, size))
    if 'list index' in error.message or 'tuple index' in error.message:
        return ("the list is shorter than that index. Were as many tags found as you expect? A tag's id is "
                'not its place in the list, and counting begins with 0.')
    if 'too many indices' in error.message:
        return 'this array has fewer axes than there are indices: %s. print(….shape) shows them.' % (
            one_line(error.message).rstrip('.'))
    if 'must be integers' in error.message or 'only integers' in error.message:
        return 'an index must be a whole number: int(…), or .astype(int) for an array.'
    return ''


def of_key(error: Error) -> str:
    key = one_line(error.message)[:100]
    if key.isdigit():
        return 'this dict has no key %s. Is it an id? A tag may have any, so count on none.' % key
    return 'this dict has no key %s.' % key


def of_name(error: Error) -> str:
    match = re.search(r"'([^']+)'", error.message)
    name = match.group(1) if match else error.name
    if error.is_a('UnboundLocalError'):
        return of_no_value(error, name)
    if name == 'TAGS':
        return ('TAGS is not known. It was in the file at the beginning: TAGS = os.path.join(os.path.dirname('
                "os.path.dirname(os.path.abspath(__file__))), 'Tags').")
    if name in ('np', 'cv2', 'rospy', 'os', 'sys', 'math', 'aruco', 'numpy', 'CvBridge', 'Image'):
        how = {'np': 'import numpy as np', 'aruco': 'from cv2 import aruco',
               'CvBridge': 'from cv_bridge import CvBridge',
               'Image': 'from sensor_msgs.msg import Image'}.get(name, 'import %s' % name)
        return '%s is not known. "%s" is missing at the top of the file.' % (name, how)
    if error.near:
        return '%s is not known.%s' % (name, meant(error))
    return '%s is not known. Does it get its value in another function, or further below?' % name


def of_no_value(error: Error, name: str) -> str:
    """The sentence for a name of the function that has no value yet."""
    inside = [one for one in functions(error.path) if one.lineno <= error.line <= last_line(one)]
    nodes = list(ast.walk(inside[-1])) if inside else []
    imports = [one.lineno for one in nodes if isinstance(one, (ast.Import, ast.ImportFrom))
               and any((alias.asname or alias.name).split('.')[0] == name for alias in one.names)]
    if imports and min(imports) > error.line:
        return ('%s has no value here yet, since it is imported further below, in line %d. Imports belong to '
                'the top of the file: move it there, or leave it out if it is there already.'
                % (name, min(imports)))
    lines = [one.lineno for one in nodes
             if isinstance(one, ast.Name) and one.id == name and isinstance(one.ctx, ast.Store)]
    if lines and min(lines) > error.line:
        return ('%s has no value here yet. It gets its first one further below, in line %d: exchange the two.'
                % (name, min(lines)))
    return ('%s has no value here yet. It gets one in this function, but only in a loop or after an "if" '
            'that was not taken for this frame.' % name)


def functions(path: str) -> list[Function]:
    """All functions of the file, the outer ones first."""
    return [one for one in ast.walk(read_tree(path))
            if isinstance(one, (ast.FunctionDef, ast.AsyncFunctionDef))]


def last_line(function: Function) -> int:
    """The number of a function's last line."""
    return function.end_lineno or function.lineno


def of_file(error: Error) -> str:
    if not error.file:
        return ''
    return ('there is no file %s. Make its path from that of your file: '
            'os.path.join(os.path.dirname(os.path.abspath(__file__)), …).' % error.file)


def of_permission(error: Error) -> str:
    return 'it is not allowed to open %s.' % error.file if error.file else ''


def of_zero(error: Error) -> str:
    return 'this divides by zero. Were no tags found?'


def of_ros(error: Error) -> str:
    return ('this asks ROS (%s), which does not run while the function is judged. It belongs into main(), or '
            'into the callback.' % one_line(error.message)[:120])


def of_opencv_error(error: Error) -> str:
    if error.unread and re.search(r'empty\(\)|NoneType|is not a numpy array', error.message):
        return of_unread(error)
    return of_opencv(error.message, error.source, error.values)


def of_syntax(error: Error) -> str:
    return 'this is no Python: %s.' % one_line(error.message).rstrip('.')


def of_assertion(error: Error) -> str:
    why = ': ' + one_line(error.message)[:200] if error.message else ''
    return 'an assert of the code itself failed%s.' % why


def of_screen(error: Error) -> str:
    others = others_of(error, r'\bcv2\.(imshow|waitKey|namedWindow|destroyAllWindows|destroyWindow)\(')
    return ('cv2.%s needs a window on a screen, which a robot does not have, nor the OpenCV that comes with '
            'pip. Leave it out%s.%s' % (
                error.message, ', and return %s' % (shown(error) or 'the image') if error.function else '',
                ' The same goes for %s.' % listed(['%s in line %d' % (name, number)
                                                   for number, name in others]) if others else ''))


def shown(error: Error) -> str:
    """The name of the image that is shown in the line, or ''."""
    match = re.search(r'imshow\([^,]+,\s*([A-Za-z_]\w*)\s*\)', error.source)
    return match.group(1) if match and len(error.outputs) == 1 else ''


def listed(parts: Sequence[str]) -> str:
    """Such as "one, two and three"."""
    return ' and '.join([', '.join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)


def others_of(error: Error, pattern: str) -> list[tuple[int, str]]:
    """The other lines of the file in which a pattern is found, each with its number and what is found."""
    found = []
    for number, line in enumerate(linecache.getlines(error.path), start=1):
        match = re.search(pattern, line.partition('#')[0])
        if match and number != error.line:
            found.append((number, match.group(1)))
    return found


def of_file_there(error: Error) -> str:
    if not error.file:
        return ''
    return '%s is there already. os.makedirs(…, exist_ok=True) does not mind that.' % error.file


SENTENCES = (
    ('NoScreenError', of_screen), ('FileExistsError', of_file_there),
    ('NodeNeededError', of_node), ('SystemExit', of_exit), ('KeyboardInterrupt', of_interrupt),
    ('MemoryError', of_memory), ('RecursionError', of_recursion), ('EOFError', of_end_of_file),
    ('ModuleNotFoundError', of_module), ('ImportError', of_import), ('AttributeError', of_attribute),
    ('error', of_opencv_error), ('TypeError', of_type), ('ValueError', of_value), ('IndexError', of_index),
    ('KeyError', of_key), ('NameError', of_name), ('FileNotFoundError', of_file),
    ('PermissionError', of_permission),
    ('ZeroDivisionError', of_zero), ('ROSException', of_ros), ('SyntaxError', of_syntax),
    ('AssertionError', of_assertion))
