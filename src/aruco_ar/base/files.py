"""Files: where the package's own are, reading and writing them whole or not at all, and YAML."""
from __future__ import annotations

import errno
import os
import stat
from collections import Counter
from contextlib import contextmanager, suppress
from typing import IO, Any, Iterator

import yaml
from yaml.error import MarkedYAMLError

from .errors import InputError

# A wall of a thousand tags has 60 kB.
MAX_YAML_BYTES = 128 * 1024

FULL = errno.ENOSPC, errno.EDQUOT
NO_NAMELESS = errno.EOPNOTSUPP, errno.EISDIR  # of file systems that have no files without a name


def package_folder() -> str:
    """Where config/, images/ and Tags/ are: the source folder, or share/unit5 once installed.

    Raises InputError in an install space that ROS does not know of, and where only aruco_ar was installed.
    """
    source = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..', '..'))
    if os.path.isfile(os.path.join(source, 'package.xml')):
        return source
    try:
        import rospkg  # not needed to run from the source folder
    except ImportError:
        raise InputError('config/ and images/ of unit5 are not installed with aruco_ar alone; give a file of '
                         'your own.') from None
    try:
        return rospkg.RosPack().get_path('unit5')
    except rospkg.ResourceNotFound:
        raise InputError('ROS does not find the package unit5; source the setup.bash of the install '
                         'space.') from None


def in_package(path: str) -> str:
    """The full path of a file, of a path that may be within the package, or begin with ~."""
    return os.path.join(package_folder(), os.path.expanduser(path))


def own_folder(name: str) -> str:
    """The package's folder of that name, to write into, or ./name where that cannot be written."""
    try:
        folder = os.path.join(package_folder(), name)
    except InputError:
        return name
    return folder if os.access(folder, os.W_OK) else name


def write_whole(path: str, data: bytes) -> None:
    """Write bytes to a file that appears only when it is complete.

    Makes the folder if there is none. Raises InputError naming the file if it
    cannot be written.
    """
    folder = os.path.dirname(os.path.abspath(path))
    draft = os.path.join(folder, '.unit5-' + os.urandom(8).hex())
    try:
        os.makedirs(folder, exist_ok=True)
        try:
            _write_draft(folder, draft, data)
            os.replace(draft, path)
        except BaseException:
            with suppress(FileNotFoundError):
                os.unlink(draft)
            raise
    except (OSError, ValueError) as error:  # ValueError: what can be no path
        remedy = 'Make room there, or choose' if getattr(error, 'errno', None) in FULL else 'Choose'
        raise InputError('Cannot write "%s": %s. %s another place to write to.'
                         % (path, _reason(error), remedy)) from None


def _write_draft(folder: str, draft: str, data: bytes) -> None:
    """Write bytes to a file without a name until it is complete: a process that is killed leaves nothing."""
    try:
        handle = os.open(folder, os.O_TMPFILE | os.O_WRONLY, 0o666)
    except OSError as error:
        if error.errno not in NO_NAMELESS:
            raise
        with open(draft, 'xb') as file:
            file.write(data)
        return
    with open(handle, 'wb') as file:
        file.write(data)
        file.flush()
        # Only with a folder's descriptor does Python follow the link to the file; the path needs none.
        os.link('/proc/self/fd/%d' % handle, draft, src_dir_fd=handle)


@contextmanager
def opened(path: str) -> Iterator[IO[bytes]]:
    """A file to read bytes from, for a ``with`` block.

    Raises InputError naming the file if it cannot be read, be it later on, in
    the block. A pipe or a device, from which reading may never end, is not even
    opened.
    """
    try:
        _check_is_file(path, os.stat(path))
        # Not waiting, should it have become a pipe since.
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), 'rb') as file:
            _check_is_file(path, os.fstat(file.fileno()))
            yield file
    except InputError:
        raise
    except (OSError, ValueError) as error:  # ValueError: what can be no path
        raise InputError('The file "%s" cannot be read: %s. Check its path and its permissions.'
                         % (path, _reason(error))) from None


def read_whole(path: str, limit: int) -> bytes:
    """The bytes of a file.

    Raises InputError naming it if it cannot be read or is larger than that many bytes.
    """
    with opened(path) as file:
        if os.fstat(file.fileno()).st_size <= limit:
            data = file.read(limit + 1)  # some, as those in /proc, hold more than they say
            if len(data) <= limit:
                return data
    raise InputError('The file "%s" is too large; give one of at most %d kB.' % (path, limit // 1024))


def _check_is_file(path: str, status: os.stat_result) -> None:
    if not stat.S_ISREG(status.st_mode):
        raise InputError('"%s" is not a file but a folder, pipe or device; give the path of a file.' % path)


def _reason(error: Exception) -> object:
    return getattr(error, 'strerror', None) or error


class _PlainLoader(yaml.SafeLoader):
    """YAML in which all that there is is written out, and once.

    Aliases could make a short file an endless one, and of an entry that is
    there twice, YAML would drop the first without a word.
    """

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            event = self.peek_event()  # type: ignore[no-untyped-call]  # of PyYAML
            raise MarkedYAMLError(problem='write out what the alias *%s stands for' % event.anchor,
                                  problem_mark=event.start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        mapping = super().construct_mapping(node, deep)
        if len(mapping) < len(node.value):
            (name, _), = Counter(key.value for key, _ in node.value).most_common(1)
            raise MarkedYAMLError(problem='the entry "%s" is there twice' % name, problem_mark=node.start_mark)
        return mapping


@contextmanager
def yaml_entries(path: str) -> Iterator[Any]:
    """What a YAML file holds, for a ``with`` block that takes its entries from it.

    Raises InputError naming the file if it cannot be read, is larger than
    MAX_YAML_BYTES, is not YAML, or if the block finds an entry missing or of
    the wrong form.
    """
    text = read_whole(path, MAX_YAML_BYTES)
    try:
        data = yaml.load(text, _PlainLoader)
    except Exception as error:  # PyYAML raises whatever the values that it makes raise
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
    """The number as a float. Raises ValueError, which yaml_entries explains, if it is none or out of bounds."""
    if isinstance(value, bool):  # as YAML takes on, off, yes and no
        raise ValueError('%s is no number' % value)
    number = float(value)
    if not low <= number <= high:
        raise ValueError('%s is not from %g to %g' % (value, low, high))
    return number
