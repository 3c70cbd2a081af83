"""The lowest versions of Python and of the libraries, checked before anything else runs.

Every Python 3 must be able to parse this file.
"""
import importlib
import importlib.util
import re
import sys

# For each module: its name in messages, the lowest version that passes the tests, and pip's requirement.
LOWEST = {
    'python': ('Python', (3, 8), ''),
    'numpy': ('NumPy', (1, 23), 'numpy>=1.23,<2'),
    'cv2': ('OpenCV', (4, 9), 'opencv-contrib-python-headless>=4.9,<4.12'),
    'PIL': ('Pillow', (9, 1), 'pillow>=9.1,<13'),
    'tornado': ('Tornado', (6, 4, 2), 'tornado>=6.4.2,<7'),
    'distributed': ('Dask distributed', (2023, 5), 'distributed>=2023.5,<2026'),
    'av': ('PyAV', (12,), 'av>=12,<20'),
    'mcap': ('mcap', (1, 6), 'mcap>=1.6,<2'),
}


class SetupError(ImportError):
    """Its message is a sentence that says what is missing or too old, and what to do."""

    is_whole = True  # the message is enough; no traceback is needed


def need(module: str) -> None:
    """Raise SetupError if the module, one of LOWEST, is missing or too old for this package."""
    name, lowest, package = LOWEST[module]
    if module == 'python':
        found = '.'.join(map(str, sys.version_info[:3]))
    elif importlib.util.find_spec(module) is None:
        found = 'none'
    else:
        imported = importlib.import_module(module)
        found = getattr(imported, '__version__', None) or imported.version
    if _numbers(found) < lowest:
        sentence = 'unit5 needs %s %s or later, but %s has %s.' % (
            name, '.'.join(map(str, lowest)), sys.executable, found)
        if package:
            sentence += ' Run script/setup in the folder of unit5 and build it again, or: pip install "%s".' \
                % package
        raise SetupError(sentence)


def _numbers(version: str) -> 'tuple[int, ...]':
    """The numbers of a version: (4, 10, 0) for "4.10.0-dev", () for a text that is no version."""
    return tuple(int(number) for number in re.split(r'[^\d.]', version)[0].split('.') if number)


if __name__ == '__main__':  # script/setup checks the system's libraries this way
    try:
        for each in sys.argv[1:]:
            need(each)
    except SetupError as error:
        sys.exit(str(error))
