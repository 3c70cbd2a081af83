"""The public API, one promise a line: what must not change without a word in CHANGELOG.rst.

reference/api.txt has that of the last release. Run script/remake/api for the next one.
"""
import glob
import inspect
import os
import re
from xml.etree import ElementTree

import aruco_ar
from generated import NODES, PACKAGE, interface, manuals, text_of

RECORD = os.path.join(PACKAGE, 'docs', 'reference', 'api.txt')
PARAMETERS = 'Parameters, * can be changed while it runs (dynamic_reconfigure)'  # the title in --help
DEFAULT = re.compile(r'(.*?)(?: \*)?')  # of a parameter in what --help prints, without the star of a live one


def promises():
    """The sorted lines: kind, what it belongs to, name, and its type or default."""
    return sorted({*_of_nodes(), *_of_launch_files(), *_of_messages(), *_of_python()})


def unsaid(record, now, changelog):
    """The changes of the API, lines with - or +, whose names are not in the changelog's section Forthcoming.

    ``record``, ``now``: the promises of the last release, and those of today. ``changelog``: its text.
    """
    news = re.search(r'^Forthcoming\n-+\n(.*?)(?=^\S[^\n]*\n---|\Z)', changelog, re.DOTALL | re.MULTILINE)
    news = news[1] if news else ''
    changes = ['- ' + line for line in record if line not in now]
    changes += ['+ ' + line for line in now if line not in record]
    return [line for line in changes if not re.search(r'(?<![\w.])%s(?!\w)' % re.escape(name_of(line)), news)]


def name_of(promise):
    """The name in a promise, as a changelog has it: without ~, and without arguments."""
    return re.search(r': ~?([^\s(]+)', promise)[1]


def _of_nodes():
    for node, text in manuals(NODES).items():
        for title in 'Subscribes', 'Publishes', 'Services':
            for name, kind, _ in interface(text, title):
                yield '%s %s: %s %s' % (node, title.lower(), name, kind)
        for name, default, _ in interface(text, PARAMETERS):
            yield '%s parameter: %s %s' % (node, name, DEFAULT.fullmatch(default)[1])


def _of_launch_files():
    for path in glob.glob(os.path.join(PACKAGE, 'launch', '*.launch')):
        for arg in ElementTree.parse(path).getroot().findall('arg'):
            yield '%s argument: %s %s' % (
                os.path.basename(path), arg.get('name'), arg.get('default', 'required'))


def _of_messages():
    for path in glob.glob(os.path.join(PACKAGE, 'msg', '*.msg')):
        for line in text_of(path).splitlines():
            field = line.partition('#')[0].split()
            if field:
                yield 'unit5/%s field: %s %s' % (os.path.basename(path)[:-len('.msg')], field[1], field[0])


def _of_python():
    for name in aruco_ar.__all__:
        thing = getattr(aruco_ar, name)
        yield 'aruco_ar name: %s%s' % (name, _arguments(thing))
        for member, method in vars(thing).items() if inspect.isclass(thing) else ():  # as Sphinx shows them
            if not member.startswith('_'):
                yield 'aruco_ar name: %s.%s%s' % (name, member, _arguments(method))


def _arguments(thing):
    """The names and defaults of what a function or a class takes; '' for anything else."""
    if not callable(thing):
        return ''
    arguments = inspect.signature(thing).parameters.values()
    return '(%s)' % ', '.join(str(each.replace(annotation=inspect.Parameter.empty)) for each in arguments)
