"""Wrong solutions of the course's exercises, as people write them, and right ones in other styles.

Each file of wrong/ is about an exercise. Most of its mistakes are made in
the course's own code, which is in right/ as a node: course5_4.py and so on.
"""
import ast
import glob
import importlib
import os
import re
import shutil
from dataclasses import dataclass

from aruco_course import exercises

FOLDER = os.path.dirname(os.path.abspath(__file__))
PACKAGE = os.path.dirname(os.path.dirname(FOLDER))
NUMBERS = ('5.1', '5.2', '5.3', '5.4', '5.5', '5.6')


@dataclass(frozen=True)
class Wrong:
    """A wrong solution: what is wrong in plain words, and the sentence that has to say so.

    ``says``: the whole sentence, without its place; "…" stands for what differs between versions and views.
    ``place``: how its place begins, "Frame" or "Line", or nothing. ``edits``: what is replaced by what in the
    code of ``base``: "course" or our "solution". Each old text is there once. ``body``: or else, a whole
    function, instead of the one of that name. ``executable``: whether the file is.
    """

    what: str
    says: str
    edits: 'tuple[tuple[str, str], ...]' = ()
    body: str = ''
    base: str = 'course'
    place: str = 'Frame'
    executable: bool = True

    def pattern(self):
        """A regular expression of the sentence."""
        return '.+'.join(re.escape(part) for part in self.says.split('…'))


def wrong_solutions(number):
    """Those of the exercise of this number, such as "5.4"."""
    return importlib.import_module('course.wrong.' + name_of(number)).WRONG


def right_solutions(number):
    """The paths of right solutions of this exercise: whatever of right/ has its number at its end."""
    paths = sorted(glob.glob(os.path.join(FOLDER, 'right', '*%s.py' % number.replace('.', '_'))))
    return [solution(number), *paths]


def name_of(number):
    return 'exercise' + number.replace('.', '_')


def solution(number):
    return os.path.join(os.path.dirname(exercises.__file__), name_of(number), 'solution.py')


def code_of(number, wrong):
    """The text of this wrong solution. An edit that does not fit is an AssertionError."""
    path = solution(number) if wrong.base == 'solution' \
        else os.path.join(FOLDER, 'right', 'course%s.py' % number.replace('.', '_'))
    with open(path, encoding='utf-8') as file:
        code = file.read()
    if wrong.body:
        code = replace_function(code, wrong.body.strip('\n'))
    for old, new in wrong.edits:
        assert code.count(old) == 1, '%s: %r is %d times in the code' % (wrong.what, old, code.count(old))
        code = code.replace(old, new)
    return code


def replace_function(code, body):
    """The code, with the function that the body begins with in place of its own of the same name."""
    name = ast.parse(body).body[0].name
    old, = (node for node in ast.parse(code).body if isinstance(node, ast.FunctionDef) and node.name == name)
    lines = code.split('\n')
    lines[old.lineno - 1:old.end_lineno] = body.split('\n')
    return '\n'.join(lines)


def write_package(folder, number, code, executable=True):
    """Make a folder a learner's package with this solution in it. Its path."""
    for name in 'src', 'images', 'Tags':
        os.makedirs(os.path.join(folder, name))
    shutil.copy(os.path.join(PACKAGE, 'images', 'earth.jpg'), os.path.join(folder, 'images'))
    path = os.path.join(folder, 'src', name_of(number) + '.py')
    with open(path, 'w', encoding='utf-8') as file:
        file.write(code)
    if executable:
        os.chmod(path, 0o755)
    return str(folder)
