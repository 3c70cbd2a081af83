"""What is wrong with the node around the learner's function, as far as its source tells."""
from __future__ import annotations

import ast
import os
import re
import shutil
from typing import Callable, Sequence

from aruco_ar.base.arrays import Image

from aruco_course.check import Check, Exercise, Fault

from .encodings import fault_of_encodings
from .names import Function, bound, called, imported, read_tree, text_of, top_functions, top_statements
from .source import is_program

SHEBANG = '#!/usr/bin/env python3'
NODE_NAME = re.compile(r'[A-Za-z][A-Za-z0-9_]*\Z')


class Node:
    """The learner's file, read and not run."""

    def __init__(self, path: str, check: Exercise, images: Sequence[Image]) -> None:
        self.path = path
        self.check = check
        self.images = images
        self.tree = read_tree(path)
        self.calls = [node for node in ast.walk(self.tree) if isinstance(node, ast.Call)]
        self.functions = [node for node in ast.walk(self.tree)
                          if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))]

    def calls_of(self, *names: str, within: ast.AST | None = None) -> list[ast.Call]:
        """The calls of functions with one of these names, whatever is before their last dot."""
        calls = self.calls
        if within is not None:
            calls = [node for node in ast.walk(within) if isinstance(node, ast.Call)]
        return [call for call in calls if called(call) in names]

    def callbacks(self) -> list[Function]:
        """The functions that a subscriber calls."""
        given = [call.args[2] for call in self.calls_of('Subscriber') if len(call.args) > 2]
        given += [keyword.value for call in self.calls_of('Subscriber') for keyword in call.keywords
                  if keyword.arg == 'callback']
        given += [call.args[0] for call in self.calls_of('registerCallback') if call.args]
        names = {one.id if isinstance(one, ast.Name) else one.attr for one in given
                 if isinstance(one, (ast.Name, ast.Attribute))}
        return [function for function in self.functions if function.name in names]


def fault_of_plumbing(path: str, check: Exercise, images: Sequence[Image] = ()) -> Fault | None:
    """The first thing that keeps the file from working as a node, though its function is right; or None.

    ``images``: what the function returned for a frame, if it is known.
    """
    node = Node(path, check, images)
    finders: tuple[Callable[[Node], Fault | None], ...] = (of_main,)
    if not is_program(check):
        finders = (of_no_node, of_main, of_executable, of_first_line, of_init, of_listening, of_publishing,
                   of_outputs, of_unknown_name, of_callback, of_unused_function, of_encodings, of_window,
                   of_spin)
    for find in finders:
        fault = find(node)
        if fault:
            return fault
    return None


def at(node: ast.AST) -> str:
    """The place of a piece of source."""
    return 'Line %d' % getattr(node, 'lineno', 0)


def of_no_node(node: Node) -> Fault | None:
    """A file that has nothing of ROS in it, and takes it from no file of the learner's own."""
    folder = os.path.dirname(os.path.abspath(node.path))
    for name in imported(node.tree):
        root = name.split('.')[0]
        beside = os.path.join(folder, root)
        if root in ('rospy', '') or os.path.exists(beside) or os.path.exists(beside + '.py'):
            return None
    return Fault('the function is right, but there is no node around it: nothing imports rospy. "learn.py '
                 'reset %s" brings back the file as it was, with its main(), and keeps yours.'
                 % node.check.number)


def of_main(node: Node) -> Fault | None:
    """A main() that nobody calls."""
    for compare in (one for one in ast.walk(node.tree) if isinstance(one, ast.Compare)):
        sides = [compare.left, *compare.comparators]
        texts = [text for text in map(text_of, sides) if text is not None]
        if any(isinstance(side, ast.Name) and side.id == '__name__' for side in sides) and texts and (
                texts[0] != '__main__') and 'main' in texts[0]:
            return Fault('__name__ is "__main__" in a program that runs, with two underscores on each side, '
                         'and never "%s".' % texts[0], at(compare))
    main = top_functions(node.tree).get('main')
    if not main:
        return None
    used = any(isinstance(one, ast.Name) and one.id == 'main' and isinstance(one.ctx, ast.Load)
               for one in ast.walk(node.tree))
    if not used:
        return Fault('nothing calls main(), so the program does nothing. At the end of the file belong "if '
                     '__name__ == \'__main__\':" and, indented below it, "main()".', at(main))
    for statement in top_statements(node.tree):
        if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Name) \
                and statement.value.id == 'main':
            return Fault('this does not call main, it only names it: "main()".', at(statement))
    return None


def of_executable(node: Node) -> Fault | None:
    """A file that rosrun does not find, since it is not executable."""
    if os.name == 'posix' and os.path.exists(node.path) and not os.access(node.path, os.X_OK):
        return Fault('the function is right, but rosrun does not find the file, since it is not executable: '
                     '"chmod +x %s".' % os.path.basename(node.path))
    return None


def of_first_line(node: Node) -> Fault | None:
    """A first line that does not tell Linux to run the file with Python."""
    with open(node.path, 'rb') as file:
        line = file.readline(500)
    place = 'Line 1'
    if line.startswith(b'\xef\xbb\xbf'):
        return Fault('an invisible mark (BOM) stands before the first line, so Linux does not see its #!. Save '
                     'the file as UTF-8 without BOM.', place)
    if not line.startswith(b'#!'):
        return Fault('the first line must be "%s", else Linux takes the file for a shell '
                     'script.' % SHEBANG, place)
    if line.endswith(b'\r\n'):
        return Fault('the lines end as those of Windows do (CRLF), and Linux looks for a program named '
                     '"python3\\r". Save the file with Unix line ends (LF).', place)
    words = line[2:].decode('utf-8', 'replace').split()
    program = words[1] if len(words) > 1 and os.path.basename(words[0]) == 'env' else words[0] if words else ''
    if 'python' not in program:
        return Fault('the first line must be "%s".' % SHEBANG, place)
    if os.name == 'posix' and not shutil.which(program):
        return Fault('there is no %s on this computer: "%s".' % (program, SHEBANG), place)
    return None


def of_init(node: Node) -> Fault | None:
    """A node that is not made, or whose name cannot be."""
    calls = node.calls_of('init_node')
    if not calls:
        return Fault('nothing calls rospy.init_node, so this is no node: it belongs at the beginning of '
                     'main().')
    name = text_of(calls[0].args[0]) if calls[0].args else None
    if name is not None and not NODE_NAME.match(name):
        return Fault('a node cannot have the name "%s": letters, digits and _ alone, and a letter '
                     'first.' % name,
                     at(calls[0]))
    return None


def of_listening(node: Node) -> Fault | None:
    """A node that gets no frames."""
    subscribers = node.calls_of('Subscriber')
    if not subscribers and not node.calls_of('wait_for_message', 'subscribe'):
        return Fault('nothing subscribes to the camera, so no frame ever comes: rospy.Subscriber(…) in main().')
    for call in subscribers:
        given = call.args[2] if len(call.args) > 2 else next(
            (keyword.value for keyword in call.keywords if keyword.arg == 'callback'), None)
        if isinstance(given, ast.Call) and isinstance(given.func, ast.Name):
            functions = [one for one in node.functions if one.name == given.func.id]
            if functions and not any(isinstance(one, ast.Return) and one.value
                                     for one in ast.walk(functions[-1])):
                return Fault('the subscriber wants the function itself: %s, without the brackets, which call '
                             'it at once.' % given.func.id, at(given))
    return None


def of_publishing(node: Node) -> Fault | None:
    """A node that shows nothing."""
    if any(isinstance(one, ast.Attribute) and one.attr == 'publish' for one in ast.walk(node.tree)):
        return None
    return Fault('nothing is published, so nobody sees what the function makes: publisher.publish(…) at the '
                 'end of the callback.')


def of_outputs(node: Node) -> Fault | None:
    """A node that publishes one of two images."""
    outputs = node.check.outputs if isinstance(node.check, Check) else ()
    publishers = node.calls_of('Publisher')
    if len(outputs) > 1 and len(publishers) == 1 and publishers[0].args and text_of(publishers[0].args[0]):
        return Fault('there is one publisher, but %s are published, each by its own: %s.' % (
            ' and '.join(outputs), ' and '.join("'~%s'" % name for name in outputs)), at(publishers[0]))
    return None


def of_unknown_name(node: Node) -> Fault | None:
    """A name that nothing in the file makes. Only the callback would tell, while the node runs."""
    known = bound(node.tree)
    if any(alias.name == '*' for one in ast.walk(node.tree) if isinstance(one, ast.ImportFrom)
           for alias in one.names):
        return None
    for one in ast.walk(node.tree):
        if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Load) and one.id not in known:
            return Fault('%s is not known. Where is it made? A publisher, for example, is made once, in '
                         'main(): "publisher = rospy.Publisher(…)".' % one.id, at(one))
    return None


def of_callback(node: Node) -> Fault | None:
    """What belongs into main(), but is done for each frame."""
    for callback in node.callbacks():
        for call in node.calls_of('Publisher', within=callback):
            return Fault('a publisher is made for each frame, in %s. A new one has no '
                         'listeners yet, so its messages are lost: make it once, in '
                         'main(), before the subscriber.' % callback.name, at(call))
        for call in node.calls_of('Subscriber', 'init_node', 'spin', within=callback):
            return Fault('%s is called for each frame, in %s. It belongs into main().'
                         % (called(call), callback.name),
                         at(call))
        for call in node.calls_of('sleep', within=callback):
            return Fault('%s sleeps, so it is slower than the camera, and frames get lost or come late. Leave '
                         'it out: ROS calls it when there is a frame.' % callback.name, at(call))
    return None


def of_unused_function(node: Node) -> Fault | None:
    """A function that nothing uses."""
    name = node.check.function
    used = any((isinstance(one, ast.Name) and one.id == name and isinstance(one.ctx, ast.Load))
               or (isinstance(one, ast.Attribute) and one.attr == name) for one in ast.walk(node.tree))
    function = top_functions(node.tree).get(name)
    if used or not function:
        return None
    return Fault('%s is right, but nothing calls it: the callback must, with the frame.' % name, at(function))


def of_encodings(node: Node) -> Fault | None:
    """Encodings of cv_bridge that are none, or do not fit."""
    outputs = node.check.outputs if isinstance(node.check, Check) else ()
    return fault_of_encodings(node.tree, node.calls, outputs, node.images)


def of_window(node: Node) -> Fault | None:
    """A window, for which a robot has no screen."""
    for call in node.calls_of('imshow', 'waitKey', 'namedWindow'):
        if text_of_dotted(call).split('.')[0] == 'cv2' or isinstance(call.func, ast.Name):
            return Fault('cv2.%s needs a screen. A robot has none, nor has every '
                         'OpenCV windows: there the callback fails. Leave it out, and '
                         'look at the topic with rqt_image_view.' % called(call), at(call))
    return None


def text_of_dotted(call: ast.Call) -> str:
    """Such as 'cv2.imshow'."""
    func: ast.expr = call.func
    parts = []
    while isinstance(func, ast.Attribute):
        parts.append(func.attr)
        func = func.value
    return '.'.join([func.id if isinstance(func, ast.Name) else '', *reversed(parts)])


def of_spin(node: Node) -> Fault | None:
    """A program that ends at once."""
    kept = {'spin', 'is_shutdown', 'sleep', 'wait_for_message', 'join', 'pause', 'wait', 'on_shutdown'}
    if any((isinstance(one, ast.Attribute) and one.attr in kept)
           or (isinstance(one, ast.Name) and one.id in kept)
           for one in ast.walk(node.tree)):
        return None
    return Fault('the program ends at once, before the first frame comes: rospy.spin() at the end of main() '
                 'lets it wait for frames.')
