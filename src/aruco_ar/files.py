"""Files: where the package's own are, writing them whole or not at all, and reading YAML."""
from __future__ import annotations

import os
import tempfile
from contextlib import contextmanager
from typing import Any, Iterator

import yaml

from .errors import InputError


def package_folder() -> str:
    """Where config/, images/ and Tags/ are: the source folder, or share/unit5 once installed.

    Raises InputError in an install space that ROS does not know of.
    """
    source = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    if os.path.isfile(os.path.join(source, 'package.xml')):
        return source
    import rospkg  # not needed to run from the source folder
    try:
        return rospkg.RosPack().get_path('unit5')
    except rospkg.ResourceNotFound:
        raise InputError('ROS does not find the package unit5; source the setup.bash of the install '
                         'space.') from None


def own_folder(name: str) -> str:
    """The package's folder of that name, to write into, or ./name where that cannot be written."""
    try:
        folder = os.path.join(package_folder(), name)
    except InputError:
        return name
    return folder if os.access(folder, os.W_OK) else name


def write_whole(path: str, data: bytes) -> None:
    """Write bytes to a file that appears only when it is complete.

    Makes the folder if there is none. Raises InputError naming the folder if
    it cannot be written.
    """
    folder = os.path.dirname(os.path.abspath(path))
    try:
        os.makedirs(folder, exist_ok=True)
        handle, draft = tempfile.mkstemp(dir=folder, prefix='.' + os.path.basename(path))
        try:
            with os.fdopen(handle, 'wb') as file:
                file.write(data)
            os.chmod(draft, 0o666 & ~_umask())  # mkstemp makes files private
            os.replace(draft, path)
        except BaseException:
            os.unlink(draft)
            raise
    except OSError as error:
        raise InputError('Cannot write "%s": %s. Choose another place to write to.'
                         % (path, error.strerror)) from None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


@contextmanager
def yaml_entries(path: str) -> Iterator[Any]:
    """What a YAML file holds, for a ``with`` block that takes its entries from it.

    Raises InputError naming the file if it cannot be read, is not YAML, or if
    the block finds an entry missing or of the wrong form.
    """
    try:
        with open(path, encoding='utf-8') as file:
            data = yaml.safe_load(file)
    except OSError as error:
        raise InputError('The file "%s" cannot be read: %s.' % (path, error.strerror)) from None
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError) as error:
        raise InputError('The file "%s" is not YAML: %s.'
                         % (path, ' '.join(str(error).split()))) from None
    try:
        yield data
    except KeyError as error:
        raise InputError('The file "%s" lacks the entry %s.' % (path, error)) from None
    except (TypeError, ValueError, AttributeError) as error:
        raise InputError('The file "%s" has an entry of the wrong form: %s.' % (path, error)) from None


def within(value: Any, low: float, high: float) -> float:
    """The number as a float. Raises ValueError, which yaml_entries explains, if it is out of bounds."""
    number = float(value)
    if not low <= number <= high:
        raise ValueError('%s is not from %g to %g' % (value, low, high))
    return number
