"""What is wrong with the learner's file before it is run: it is gone, cannot be read, or lacks the function."""
from __future__ import annotations

import ast
import difflib
import os
import re
import warnings

from aruco_course.check import Exercise, Fault

from .names import Function, called, imported, other_names, read_tree, top_functions

LARGEST = 1 << 20  # bytes
NO_FUNCTIONS = 'cv2', 'numpy', 'sensor_msgs.msg', 'std_msgs.msg'  # of which many import *
# What Python before 3.10 calls invalid syntax.
NO_COLON = re.compile(r'\s*(def|class|if|elif|else|for|while|try|with)\b[^:]*$')
EXERCISES = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), 'exercises')


def fault_of_source(path: str, check: Exercise) -> Fault | None:
    """The first thing that is wrong with the file as it is written, or None."""
    fault = fault_of_syntax(path)
    if fault or not check.function:
        return fault
    tree = read_tree(path)
    function = top_functions(tree).get(check.function)
    if not function:
        # A program without ROS is judged by the files it makes, however it makes them.
        if is_program(check) or check.function in other_names(tree) or has_star(tree):
            return None
        return fault_of_missing(path, check.function, check.number)
    wanted = wanted_arguments(check)
    return (fault_of_arguments(function, wanted) or fault_of_reading(function)
            or fault_of_margin(tree, function)) if wanted else None


def is_node_only(path: str, check: Exercise) -> bool:
    """Whether the file is Python without the exercise's function, such as a node that is one class."""
    if fault_of_syntax(path):
        return False
    tree = read_tree(path)
    return check.function not in {*top_functions(tree), *other_names(tree)} and not has_star(tree)


def fault_of_syntax(path: str) -> Fault | None:
    """A file that is gone, is empty, is no text, or is no Python, or None."""
    name = os.path.basename(path)
    reset = '"learn.py reset %s" brings it back as it was at the beginning.' % '.'.join(
        re.findall(r'\d+', name))
    try:
        with open(path, 'rb') as file:
            source = file.read(LARGEST + 1)
    except FileNotFoundError:
        return Fault('%s is not there. %s' % (name, reset))
    except OSError as error:
        return Fault('%s cannot be read: %s.' % (name, error.strerror))
    if len(source) > LARGEST:
        return Fault('%s is larger than 1 MB. Is it the right file?' % name)
    if not source.strip():
        return Fault('%s is empty. Was it saved? %s' % (name, reset))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter('ignore')
            compile(source, path, 'exec', dont_inherit=True)
    except SyntaxError as error:
        return of_syntax_error(error, source)
    except ValueError:
        return Fault('%s has zero bytes in it, so it is no text. Was it saved as UTF-8?' % name)
    except (RecursionError, MemoryError):
        return Fault('%s is nested too deep for Python.' % name)
    return None


def of_syntax_error(error: SyntaxError, source: bytes) -> Fault:
    """What is wrong with the syntax, in words, and where."""
    message = (error.msg or '').rstrip('.')
    place = 'Line %d' % error.lineno if error.lineno else ''
    lines = source.decode('utf-8', 'replace').splitlines()
    line = lines[error.lineno - 1] if error.lineno and error.lineno <= len(lines) else ''
    if re.search('codec|encoding|Non-UTF-8', message) or isinstance(error.__cause__, UnicodeError):
        try:
            source.decode('utf-8')
        except UnicodeDecodeError as bad:
            place = 'Line %d' % (source[:bad.start].count(b'\n') + 1)
        return Fault('this is no UTF-8, so Python cannot read it. Save the file as UTF-8 in your '
                     'editor.', place)
    if isinstance(error, TabError) or 'inconsistent use of tabs' in message:
        return Fault('tabs and spaces are mixed here. Indent with spaces alone, four for each step.', place)
    code = [one.partition('#')[0].strip() for one in lines]
    if 'unexpected EOF' in message and next(filter(None, reversed(code)), '').endswith(':'):
        message = 'expected an indented block'  # as Python says from 3.9 on
    if isinstance(error, IndentationError) or 'expected an indented block' in message:
        if 'expected an indented block' in message:
            return Fault('something must be indented here, below the line that ends with a colon. A comment '
                         'alone is not enough: "pass" does nothing.', place)
        return Fault('this line is not indented as those around it: %s.' % message, place)
    if 'unterminated string literal' in message or 'EOL while scanning' in message:
        return Fault('a text begins here, and does not end in this line: the quotation mark at its end is '
                     'missing, and perhaps a bracket behind it.', place)
    if "Missing parentheses in call to 'print'" in message or line.strip().startswith('print '):
        return Fault('this is Python 2. In Python 3, print takes brackets: print(…).', place)
    if 'was never closed' in message or 'unexpected EOF' in message:
        return Fault('a bracket that begins here, or before, is never closed (Python says: '
                     '%s).' % message, place)
    if "expected ':'" in message or (message == 'invalid syntax' and NO_COLON.match(line)):
        return Fault('a colon (:) is missing at the end of this line.', place)
    if line.strip().startswith('return') and 'outside function' in message:
        return Fault('this return is outside of the function. Is the line indented as the others in it?', place)
    if message == 'invalid syntax':
        return Fault('this is no Python (invalid syntax). Look at the end of the line before it as well: is a '
                     'bracket, a comma or a colon missing?', place)
    if 'Perhaps you forgot a comma' in message:
        return Fault('this is no Python. Is a comma missing here, or is a bracket not closed?', place)
    return Fault('this is no Python: %s' % message + ('' if message.endswith('?') else '.'), place)


def fault_of_missing(path: str, name: str, number: str = '') -> Fault:
    """What to say of a file without the function: which name may be meant, and what there is."""
    tree = read_tree(path)
    functions = top_functions(tree)
    node = ' "learn.py check%s --node" judges the node as it is.' % (' ' + number if number else '')
    reset = ' "learn.py reset %s" brings back the file of the beginning.' % number if number else ''
    for holder in ast.walk(tree):
        if isinstance(holder, (ast.ClassDef, ast.FunctionDef)):
            for inner in holder.body:
                if isinstance(inner, (ast.FunctionDef, ast.AsyncFunctionDef)) and inner.name == name:
                    kind = 'class' if isinstance(holder, ast.ClassDef) else 'function'
                    return Fault('%s is inside the %s %s, where it cannot be called '
                                 'alone. Move it to the left margin, or let a function '
                                 'of this name call it.%s' % (name, kind, holder.name, node),
                                 'Line %d' % inner.lineno)
    close = difflib.get_close_matches(name, list(functions), 1, 0.75)
    same = [one for one in functions if one.replace('_', '').lower() == name.replace('_', '').lower()]
    if same or close:
        meant = functions[(same or close)[0]]
        return Fault('the function is called %s, but it is judged by its name, which must '
                     'be %s.' % (meant.name, name),
                     'Line %d' % meant.lineno)
    classes = [one for one in tree.body if isinstance(one, ast.ClassDef)]
    callbacks = [one for one in functions if 'callback' in one.lower() or one.lower().endswith(('_cb', 'cb'))]
    there = [one for one in functions if one != 'main' and one not in callbacks]
    if classes or (callbacks and not there):
        what = 'the class %s' % classes[0].name if classes else 'the callback %s' % callbacks[0]
        return Fault('there is no function %s, only %s. A function is judged by its name: let %s(…) take an '
                     'image and return one, and call it from there.%s' % (name, what, name, node))
    if there:
        names = ' and '.join([', '.join(there[:-1]), there[-1]]) if len(there) > 1 else there[0]
        return Fault('there is no function %s, only %s. It is judged by its name: put the lines that work on '
                     'an image into "def %s(…):".%s' % (name, names, name, reset))
    return Fault('there is no function %s. It is judged by its name: "def %s(…):" at the left margin.%s' % (
        name, name, node))


def fault_of_arguments(function: Function, wanted: list[str]) -> Fault | None:
    """A function that cannot be called with the arguments it gets, or None."""
    arguments = function.args
    names = [one.arg for one in [*getattr(arguments, 'posonlyargs', []), *arguments.args]]
    needed = len(names) - len(arguments.defaults)
    forced = [one.arg for one, default in zip(arguments.kwonlyargs, arguments.kw_defaults) if default is None]
    right = 'def %s(%s):' % (function.name, ', '.join(wanted))
    place = 'Line %d' % function.lineno
    if names[:1] == ['self']:
        return Fault('%s takes self, but it is in no class: "%s".' % (function.name, right), place)
    if needed > len(wanted) or forced or (len(names) < len(wanted) and not arguments.vararg):
        return Fault('%s takes %s, but it is called with %s: "%s".' % (
            function.name, count(len(names) + len(forced)), count(len(wanted)), right), place)
    return None


def fault_of_reading(function: Function) -> Fault | None:
    """A function that reads an image from a file, and not the one that it is given, or None."""
    given = [one.arg for one in function.args.args]
    names = [one for one in ast.walk(function) if isinstance(one, ast.Name)]
    used = {one.id for one in names if isinstance(one.ctx, ast.Load)}
    for statement in ast.walk(function):
        if not (isinstance(statement, ast.Assign) and isinstance(statement.value, ast.Call)
                and called(statement.value) == 'imread'):
            continue
        place = 'Line %d' % statement.lineno
        made = {one.id for target in statement.targets for one in ast.walk(target) if isinstance(one, ast.Name)}
        for name in given:
            if name in made:
                return Fault('%s is given to the function, and this line puts an image of a file in its place. '
                             'Leave the line out.' % name, place)
            if name not in used:
                return Fault('an image is read from a file here, but %s, which is given to the function, is '
                             'not used. Leave this line out, and write %s below wherever this image is meant.'
                             % (name, name), place)
    return None


def fault_of_margin(tree: ast.Module, function: Function) -> Fault | None:
    """Lines of the function that are not indented, so that they do not belong to it, or None."""
    if not function.args.args or any(isinstance(one, ast.Call) for one in ast.walk(function)):
        return None
    given = function.args.args[0].arg
    for statement in tree.body[tree.body.index(function) + 1:] if function in tree.body else []:
        if not isinstance(statement, ast.Assign):
            continue
        made = [one.id for target in statement.targets for one in ast.walk(target) if isinstance(one, ast.Name)]
        if given in made:
            return Fault('this line does not belong to %s, since it is not indented. Indent all lines of the '
                         'function by four spaces. %s is given to it, so it needs no value.'
                         % (function.name, given), 'Line %d' % statement.lineno)
    return None


def count(number: int) -> str:
    """Such as '2 arguments'."""
    return 'no argument' if not number else '1 argument' if number == 1 else '%d arguments' % number


def wanted_arguments(check: Exercise) -> list[str]:
    """The names of the arguments that the function gets: those of its solution's; none without a solution."""
    function = top_functions(read_tree(solution(check))).get(check.function)
    return [one.arg for one in function.args.args] if function else []


def is_program(check: Exercise) -> bool:
    """Whether the exercise's solution is a program without ROS."""
    tree = read_tree(solution(check))
    return bool(tree.body) and 'rospy' not in imported(tree)


def solution(check: Exercise) -> str:
    """The path of the exercise's solution."""
    return os.path.join(EXERCISES, check.name, 'solution.py')


def has_star(tree: ast.Module) -> bool:
    """Whether the file imports all that another one has."""
    return any(isinstance(node, ast.ImportFrom) and any(alias.name == '*' for alias in node.names)
               and node.module not in NO_FUNCTIONS for node in ast.walk(tree))
