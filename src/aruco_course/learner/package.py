"""The learner's own catkin package: made once, with skeletons that are cut out of the solutions."""
from __future__ import annotations

import os
import re
import time
from typing import Iterable, NamedTuple

from aruco_ar import InputError
from aruco_ar.base.files import in_package, read_whole, write_whole

from aruco_course.check import Challenge, Exercise

BEGIN, END = '### BEGIN SOLUTION', '### END SOLUTION'
TO_DO = '# Your code comes here.'

EXERCISES = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), 'exercises')
TEMPLATES = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'templates')
# The file of a template has one ending more, so that no tool takes this folder for a package.
TEMPLATE_ENDING = '.in'
HIDDEN = '.learn'   # the folder of what is ours in the learner's package
NAME = 'my_unit5'
OURS = 'unit5'
WORKSPACE = os.path.join('~', 'catkin_ws', 'src')
MAX_SOURCE_BYTES = 1024 * 1024
MAX_PICTURE_BYTES = 8 * 1024 * 1024


class Started(NamedTuple):
    """What ``start`` has done: the package, and the paths in it that are new, and those that were there."""

    package: Package
    made: list[str]
    kept: list[str]


class Package:
    """A learner's package. ``folder``: its full path."""

    def __init__(self, folder: str) -> None:
        self.folder = os.path.abspath(os.path.expanduser(folder))

    @property
    def name(self) -> str:
        """The name for ROS: that of package.xml, else that of the folder."""
        try:
            text = read_whole(self.path('package.xml'), MAX_SOURCE_BYTES).decode('utf-8', 'replace')
        except InputError:
            text = ''
        found = re.search(r'<name>\s*([\w-]+)\s*</name>', text)
        return found[1] if found else name_of(self.folder)

    def path(self, *parts: str) -> str:
        """The full path of a file in it."""
        return os.path.join(self.folder, *parts)

    def source(self, check: Exercise) -> str:
        """The full path of the learner's file of an exercise."""
        return self.path('src', check.name + '.py')

    def picture(self, check: Exercise) -> str:
        """The full path of the newest picture of an exercise's verdict."""
        return self.path(HIDDEN, 'pictures', check.number.replace('.', '_') + '.png')

    def challenge_picture(self, check: Exercise, challenge: Challenge) -> str:
        """The full path of the picture of a challenge that the code does not survive."""
        return self.path(HIDDEN, 'pictures', '%s_%s.png' % (check.number.replace('.', '_'),
                                                           challenge.name.replace(' ', '_')))

    def passed_picture(self, check: Exercise) -> str:
        """The full path of the picture of when the exercise was right."""
        return self.path(HIDDEN, 'pictures', check.number.replace('.', '_') + '_right.png')

    def keep(self, path: str) -> str | None:
        """Move a file of the package into .learn/old. Returns where it is now; None if there was none."""
        stem, ending = os.path.splitext(os.path.basename(path))
        now = time.strftime('%Y-%m-%d-%H.%M.%S')
        folder = self.path(HIDDEN, 'old')
        try:
            os.makedirs(folder, exist_ok=True)
            for number in range(1, 1000):
                kept = os.path.join(folder, '%s-%s%s%s' % (stem, now, '' if number == 1 else '-%d' % number,
                                                           ending))
                if not os.path.lexists(kept):
                    break
            os.rename(path, kept)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise InputError('Cannot keep "%s" in "%s": %s.' % (path, folder, error.strerror)) from None
        return kept


def start(folder: str, checks: Iterable[Exercise], learn: str = 'rosrun unit5 learn.py') -> Started:
    """Make a package in a folder, or what is missing of it. No file that is there is changed.

    ``learn``: the command that starts this program. Raises InputError if the folder is no place for one.
    """
    package = Package(folder)
    if os.path.isfile(package.path('package.xml')) and not os.path.isdir(package.path(HIDDEN)):
        raise InputError('"%s" is already a package, and not one that was started here. Choose another folder, '
                         'such as %s.' % (package.folder, os.path.join(os.path.dirname(package.folder), NAME)))
    if os.path.exists(package.folder) and not os.path.isdir(package.folder):
        raise InputError('"%s" is a file. Choose another folder.' % package.folder)
    around = _package_around(package.folder)
    if around is not None:
        raise InputError('"%s" is inside the package "%s", where ROS would not find it. Choose another folder.'
                         % (package.folder, around))
    if package.name == OURS:
        raise InputError('"%s" is the name of the package with the answers. Choose another folder, such as %s.'
                         % (OURS, os.path.join(os.path.dirname(package.folder), NAME)))
    started = Started(package, [], [])
    words = {'package': package.name, 'learn': learn}

    def write(path: str, data: bytes, mode: int = 0o644) -> None:
        full = package.path(path)
        if os.path.lexists(full):
            started.kept.append(path)
            return
        write_whole(full, data)
        os.chmod(full, mode & ~_umask())
        started.made.append(path)

    # First what says whose folder this is: if the rest is interrupted, start can be called again.
    _make(package.path(HIDDEN))
    for name in 'package.xml', 'CMakeLists.txt', 'README.md':
        write(name, template(name, words))
    for check in checks:
        write(os.path.join('src', check.name + '.py'), skeleton(check).encode(), 0o755)
        if has_node(check):
            write(os.path.join('launch', check.name + '.launch'),
                  template('exercise.launch', {**words, 'exercise': check.name, 'number': check.number}))
    _make(package.path('Tags'))
    write(os.path.join('images', 'earth.jpg'), read_whole(in_package('images/earth.jpg'), MAX_PICTURE_BYTES))
    return started


def reset(package: Package, check: Exercise) -> str | None:
    """Bring back an exercise's skeleton. Returns where the old file is kept, or None if there was none."""
    path = package.source(check)
    kept = package.keep(path)
    write_whole(path, skeleton(check).encode())
    os.chmod(path, 0o755 & ~_umask())
    return kept


def is_untouched(package: Package, check: Exercise) -> bool:
    """Whether the learner's file is still the skeleton."""
    try:
        return read_whole(package.source(check), MAX_SOURCE_BYTES) == skeleton(check).encode()
    except InputError:
        return False


def has_node(check: Exercise) -> bool:
    """Whether the exercise's file is a ROS node. That of 5.1 is not: it writes files."""
    return 'rospy' in solution(check)


def skeleton(check: Exercise) -> str:
    """The source that the learner begins with: the solution without what is between its marks."""
    return without_solution(_marked_solution(check))


def solution(check: Exercise) -> str:
    """Our plain solution, without the marks."""
    return ''.join(line for line in _marked_solution(check).splitlines(keepends=True)
                   if line.strip() not in (BEGIN, END))


def without_solution(source: str) -> str:
    """A source, with a line that says "your code" in place of what is between its marks."""
    lines, inside = [], False
    for number, line in enumerate(source.splitlines(keepends=True), start=1):
        mark = line.strip()
        if mark == (END if inside else BEGIN):
            if not inside:
                lines.append(line.replace(BEGIN, TO_DO))
            inside = not inside
        elif mark in (BEGIN, END):
            raise ValueError('line %d: %s comes twice' % (number, mark))
        elif not inside:
            lines.append(line)
    if inside:
        raise ValueError('%s is missing' % END)
    return ''.join(lines)


def find(folder: str) -> Package | None:
    """The learner's package that a folder is in or is; None if there is none."""
    folder = os.path.abspath(os.path.expanduser(folder))
    while True:
        if os.path.isdir(os.path.join(folder, HIDDEN)) and os.path.isdir(os.path.join(folder, 'src')):
            return Package(folder)
        above = os.path.dirname(folder)
        if above == folder:
            return None
        folder = above


def default_folder() -> str:
    """Where a package is made if nobody says: in the usual workspace, else here; within unit5, beside it."""
    workspace = os.path.expanduser(WORKSPACE)
    if os.path.isdir(workspace):
        return os.path.join(workspace, NAME)
    folder = os.path.abspath(NAME)
    around = _package_around(folder)
    return folder if around is None else os.path.join(os.path.dirname(around), NAME)


def name_of(folder: str) -> str:
    """A name that ROS takes for the package in a folder: small letters, digits and underscores."""
    name = re.sub(r'[^a-z0-9]+', '_', os.path.basename(os.path.abspath(folder)).lower()).strip('_')
    return name if re.match('[a-z]', name) else (NAME + '_' + name).rstrip('_')


def template(name: str, words: dict[str, str]) -> bytes:
    """A file of the folder templates, with the words in place of their names, such as @package@."""
    text = read_whole(os.path.join(TEMPLATES, name + TEMPLATE_ENDING), MAX_SOURCE_BYTES).decode()
    return re.sub('@([a-z]+)@', lambda found: words[found[1]], text).encode()


def _package_around(folder: str) -> str | None:
    above = os.path.dirname(folder)
    while above != os.path.dirname(above):
        if os.path.isfile(os.path.join(above, 'package.xml')):
            return above
        above = os.path.dirname(above)
    return None


def _marked_solution(check: Exercise) -> str:
    path = os.path.join(EXERCISES, check.name, 'solution.py')
    return read_whole(path, MAX_SOURCE_BYTES).decode()


def _make(folder: str) -> None:
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise InputError('Cannot make the folder "%s": %s. Choose another place.'
                         % (folder, error.strerror)) from None


def _umask() -> int:
    mask = os.umask(0)  # there is no other way to read it
    os.umask(mask)
    return mask
