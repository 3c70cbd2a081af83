"""Files: the package's own folders, reading files, writing them completely or not at all, and YAML."""
from __future__ import annotations

import errno
import os
import re
import stat
from collections import Counter
from contextlib import contextmanager, suppress
from typing import IO, Any, Iterator
from urllib.parse import unquote

import yaml
from yaml.error import MarkedYAMLError

from .errors import InputError
from .system import give_name, open_at_once, open_unnamed

# The file of a wall with a thousand tags has 60 kB.
MAX_YAML_BYTES = 128 * 1024

FILE_ADDRESS = re.compile('file:(?://[^/]*)?(/.*)', re.DOTALL)
DISK_FULL = errno.ENOSPC, errno.EDQUOT


def package_folder() -> str:
    """The folder that holds images/, and with ROS also config/ and Tags/.

    It is the source folder, the folder share of a wheel, or share/unit5 in an install space. Raises InputError
    if ROS does not know the install space, or if only a part of unit5 was copied.
    """
    library = os.path.abspath(os.path.join(os.path.dirname(__file__), '..'))
    source, shared = os.path.dirname(os.path.dirname(library)), os.path.join(library, 'share')
    if os.path.isfile(os.path.join(source, 'package.xml')):
        return source
    if os.path.isdir(shared):
        return shared
    try:
        import rospkg  # not needed to run from the source folder
    except ImportError:
        raise InputError("aruco_ar is installed alone, without unit5's config/ and images/; give a file of "
                         'your own.') from None
    try:
        return rospkg.RosPack().get_path('unit5')
    except rospkg.ResourceNotFound:
        raise InputError('ROS cannot find the package unit5; source the setup.bash of the install '
                         'space.') from None


def in_package(path: str) -> str:
    """The full path of a file. ``path`` may be relative to the package's folder, or what path_of takes."""
    return os.path.join(package_folder(), path_of(path))


def path_of(text: str) -> str:
    """The path in a text, which may begin with ~, or be an address such as file:///home/me/wall.png."""
    address = FILE_ADDRESS.match(text)
    if not address:
        return os.path.expanduser(text)
    path = unquote(address[1], errors='surrogateescape')
    return path[1:] if os.path.splitdrive(path[1:])[0] else path  # Windows: file:///C:/wall.png


def own_folder(name: str) -> str:
    """A folder of that name to write into: the package's own, or ./name if that is not writable."""
    try:
        folder = os.path.join(package_folder(), name)
    except InputError:
        return name
    return folder if os.access(folder, os.W_OK) else name


def write_whole(path: str, data: bytes) -> None:
    """Write bytes to a file, which appears only when it is complete.

    Makes its folder if that is missing. Raises InputError, which names the
    file, if it cannot be written.
    """
    folder = os.path.dirname(os.path.abspath(path))
    draft = os.path.join(folder, '.unit5-' + os.urandom(8).hex())
    try:
        os.makedirs(folder, exist_ok=True)
        try:
            _write(folder, draft, path, data)
        except BaseException:
            with suppress(FileNotFoundError):
                os.unlink(draft)
            raise
    except (OSError, ValueError) as error:  # ValueError: the text cannot be a path
        remedy = 'Make room there, or choose' if getattr(error, 'errno', None) in DISK_FULL else 'Choose'
        raise InputError('Cannot write "%s": %s. %s another place to write to.'
                         % (path, _reason(error), remedy)) from None


def _write(folder: str, draft: str, path: str, data: bytes) -> None:
    """Write bytes to a file that has no name until it is complete, so that a killed process leaves nothing.

    Where there are no files without a name, it leaves a part of the draft. If another file is replaced, it may
    leave all of it.
    """
    handle = open_unnamed(folder)
    if handle is None:
        with open(draft, 'xb') as file:
            file.write(data)
        os.replace(draft, path)
        return
    with open(handle, 'wb') as file:
        file.write(data)
        file.flush()
        try:
            give_name(handle, os.path.join(folder, os.path.basename(path)))
        except FileExistsError:
            give_name(handle, draft)
            os.replace(draft, path)


@contextmanager
def opened(path: str) -> Iterator[IO[bytes]]:
    """A file to read bytes from, for a ``with`` block.

    Raises InputError, which names the file, if it cannot be opened, or cannot
    be read within the block. A pipe or a device is not even opened, since
    reading from it may never end.
    """
    try:
        _check_is_file(path, os.stat(path))
        with open(open_at_once(path), 'rb') as file:
            _check_is_file(path, os.fstat(file.fileno()))
            yield file
    except InputError:
        raise
    except (OSError, ValueError) as error:  # ValueError: the text cannot be a path
        raise InputError('The file "%s" cannot be read: %s. Check its path and its permissions.'
                         % (path, _reason(error))) from None


def read_whole(path: str, limit: int) -> bytes:
    """The bytes of a file.

    Raises InputError, which names the file, if it cannot be read or is larger than ``limit`` bytes.
    """
    with opened(path) as file:
        if os.fstat(file.fileno()).st_size <= limit:
            data = file.read(limit + 1)  # some files, such as those in /proc, are longer than their size says
            if len(data) <= limit:
                return data
    raise InputError('The file "%s" is too large; give one of at most %d kB.' % (path, limit // 1024))


def _check_is_file(path: str, status: os.stat_result) -> None:
    if not stat.S_ISREG(status.st_mode):
        raise InputError('"%s" is not a file but a folder, pipe or device; give the path of a file.' % path)


def _reason(error: Exception) -> object:
    return getattr(error, 'strerror', None) or error


class _PlainLoader(yaml.SafeLoader):
    """A YAML loader that refuses aliases and duplicate entries.

    With aliases, a short file could expand to an endless one. Of duplicate
    entries, PyYAML would silently drop the first.
    """

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            event = self.peek_event()  # type: ignore[no-untyped-call]  # PyYAML has no types
            raise MarkedYAMLError(problem='aliases are not allowed; write out the value of *%s' % event.anchor,
                                  problem_mark=event.start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        mapping = super().construct_mapping(node, deep)
        if len(mapping) < len(node.value):
            (name, _), = Counter(key.value for key, _ in node.value).most_common(1)
            raise MarkedYAMLError(problem='the entry "%s" appears twice' % name, problem_mark=node.start_mark)
        return mapping


@contextmanager
def yaml_entries(path: str) -> Iterator[Any]:
    """The content of a YAML file, for a ``with`` block that reads its entries.

    Raises InputError, which names the file, if it cannot be read, is larger
    than MAX_YAML_BYTES, or is not YAML. The same error is raised if the block
    finds that an entry is missing or has the wrong form.
    """
    text = read_whole(path, MAX_YAML_BYTES)
    try:
        data = yaml.load(text, _PlainLoader)
    except Exception as error:  # PyYAML passes on any error of the constructors of its values
        raise InputError('The file "%s" is not YAML: %s.'
                         % (path, ' '.join(str(error).split()))) from None
    try:
        yield data
    except KeyError as error:
        raise InputError('The file "%s" lacks the entry %s.' % (path, error)) from None
    except (TypeError, ValueError, AttributeError, OverflowError) as error:
        raise InputError('The file "%s" has an entry of the wrong form: %s.'
                         % (path, str(error).rstrip('.'))) from None


def within(value: Any, low: float, high: float) -> float:
    """The value as a float. Raises ValueError, which yaml_entries explains, if it is not from low to high."""
    if isinstance(value, bool):  # YAML reads on, off, yes and no as booleans
        raise ValueError('%s is not a number' % value)
    number = float(value)
    if not low <= number <= high:
        raise ValueError('%s is not between %g and %g' % (value, low, high))
    return number
