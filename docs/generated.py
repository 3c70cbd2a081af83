"""The pages that are made from the code: parameters, launch arguments, messages, what --help prints, and
tables of nodes and topics, which are read from that.

conf.py calls write_all; the pages of reference/ include what it writes.
"""
import glob
import os
import re
import runpy
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from xml.etree import ElementTree

from aruco_ar.settings.declaration import parameters_of
from aruco_node.page import node as page
from aruco_node.parameters import settings
from aruco_node.parameters.parameters import ros_values
from course import corpus

PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
# Title, class, and the class whose parameters it has besides.
SETTINGS = [
    ('Every node that takes frames', settings.FrameSettings, None),
    ('Every node that looks for tags', settings.TagSettings, settings.FrameSettings),
    ('Nodes that track the area: `exercise5_5`, `exercise5_6`, `tag_poses`', settings.AreaSettings,
     settings.TagSettings),
    ('`exercise5_6`', settings.PictureSettings, settings.AreaSettings),
    ('`tag_poses`', settings.PoseSettings, settings.AreaSettings),
    ('`calibrate_live`', settings.CalibrationSettings, settings.FrameSettings),
    ('`camera_relay`', settings.RelaySettings, settings.FrameSettings),
    ('`wall_camera`', runpy.run_path(PACKAGE + '/nodes/wall_camera.py')['WallCameraSettings'], None),
    ('`page`', page.PageSettings, None),
]
NODES = ['exercise5_2', 'exercise5_3', 'exercise5_4', 'exercise5_5', 'exercise5_6', 'tag_poses', 'wall_camera',
         'camera_relay', 'calibrate_live', 'page']
PROGRAMS = ['learn', 'check_node', 'artag_generator', 'annotate_bags', 'calibrate_camera', 'gazebo_wall',
            'video_camera']


# What the page says of all nodes, above the table, which leaves it out.
COMMON = re.compile(r'/diagnostics|~parameter_\w+|~set_parameters|.*/compressed')


def write_all(folder):
    """Write all pages into a folder; those that are as they were are left alone."""
    os.makedirs(folder, exist_ok=True)
    nodes = manuals(NODES)
    pages = {'parameters': parameters(), 'launch': launch_files(), 'messages': messages(),
             'nodes': boxes(nodes), 'programs': boxes(manuals(PROGRAMS)), 'node_table': node_table(nodes),
             'subscribed': topics(nodes, 'Subscribes'), 'published': topics(nodes, 'Publishes'),
             'mistakes': mistakes()}
    for name, text in pages.items():
        path = os.path.join(folder, name + '.md')
        if not os.path.exists(path) or text_of(path) != text:
            with open(path, 'w', encoding='utf-8') as file:
                file.write(text)


def text_of(path):
    with open(path, encoding='utf-8') as file:
        return file.read()


def parameters():
    """A table for each class of settings, of the parameters that it adds."""
    parts = []
    for title, kind, base in SETTINGS:
        values, known = ros_values(kind()), parameters_of(base) if base else {}
        rows = [('`~%s`' % name, code(values[name]), parameter.what, parameter.kind.allowed,
                 'yes' if parameter.live else 'no')
                for name, parameter in parameters_of(kind).items() if name not in known]
        parts.append('## %s\n\n%s' % (title, table(
            ('Parameter', 'Default', 'Meaning', 'Allowed', 'Live'), rows)))
    return '\n'.join(parts)


def launch_files():
    """The arguments of every launch file, and the comment at its top."""
    parts = []
    for path in sorted(glob.glob(os.path.join(PACKAGE, 'launch', '*.launch')) + [
            os.path.join(PACKAGE, 'launch', 'check.test')]):
        parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
        root = ElementTree.parse(path, parser).getroot()
        about = root[0].text.strip() if root[0].tag is ElementTree.Comment else ''
        rows = [('`%s`' % arg.get('name'), code(arg.get('default', 'required')), arg.get('doc', ''))
                for arg in root.findall('arg')]
        parts.append('## %s\n\n%s\n\n%s' % (os.path.basename(path), ' '.join(about.split()), table(
            ('Argument', 'Default', 'Meaning'), rows)))
    return '\n'.join(parts)


def messages():
    """The definition of every message, whose comments say what is in it."""
    paths = sorted(glob.glob(os.path.join(PACKAGE, 'msg', '*.msg')))
    return '\n'.join('## unit5/%s\n\n```text\n%s```\n' % (os.path.basename(path)[:-len('.msg')], text_of(path))
                     for path in paths)


def mistakes():
    """A table for each exercise of the course: mistakes, and what is said of each. A test sees to that."""
    rows = {number: [(plain(wrong.what), plain(wrong.says)) for wrong in corpus.wrong_solutions(number)]
            for number in corpus.NUMBERS}
    return '\n'.join('### Exercise %s\n\n%s' % (number, table(('What is wrong', 'What `learn.py` says'), each))
                     for number, each in rows.items())


def manuals(names):
    """{name: what --help of this program prints}."""
    with ThreadPoolExecutor(2) as pool:
        return dict(zip(names, pool.map(manual, names)))


def manual(name):
    path, = glob.glob('%s/*/%s.py' % (PACKAGE, name))
    done = subprocess.run([sys.executable, path, '--help'], env=dict(os.environ, COLUMNS='110'),
                          stdout=subprocess.PIPE, text=True, check=True)
    return done.stdout.strip()


def boxes(texts):
    """What --help prints, each in a box below the name of its program."""
    return '\n'.join('### %s\n\n```text\n%s\n```\n' % item for item in texts.items())


def node_table(texts):
    """A table of the nodes: what each is for, and what it subscribes to, publishes and offers."""
    rows = [('`%s`' % name, text.split('\n\n')[0].replace('\n', ' '), *(
        ', '.join('`%s`' % row[0] for row in interface(text, title) if not COMMON.fullmatch(row[0]))
        for title in ('Subscribes', 'Publishes', 'Services'))) for name, text in texts.items()]
    return table(('Node', 'What it does', 'Subscribes', 'Publishes', 'Services'), rows)


def topics(texts, title):
    """A table of the topics under this title of --help, and of the nodes that have them."""
    nodes = {}
    for name, text in texts.items():
        for row in interface(text, title):
            nodes.setdefault(row, []).append('`%s`' % name)
    rows = [('`%s`' % topic, '`%s`' % kind, what, 'all' if len(names) == len(texts) else ', '.join(names))
            for (topic, kind, what), names in nodes.items()]
    return table(('Topic', 'Type', 'What it carries', 'Nodes'), rows)


def interface(text, title):
    """The rows under a title of what --help prints: (name, type, what it is)."""
    rows = []
    block = next((part for part in text.split('\n\n') if part.startswith(title + ':')), '')
    for line in block.splitlines()[1:]:
        if line.startswith('   '):  # it goes on
            rows[-1][2] += ' ' + line.strip()
        else:
            rows.append((re.split(' {2,}', line.strip()) + [''])[:3])
    return [tuple(row) for row in rows]


def code(value):
    """A value as code, as YAML and a command line have it; nothing if it is empty."""
    return '`%s`' % (str(value).lower() if isinstance(value, bool) else value) if value != '' else ''


def plain(text):
    """A sentence that may have code in it, for Markdown, in which some of its signs mean something."""
    return re.sub(r'([\\`*_\[\]<>~#$])', r'\\\1', text)


def table(head, rows):
    """A Markdown table."""
    lines = [head, ['---'] * len(head), *rows]
    return ''.join('| %s |\n' % ' | '.join(str(cell).replace('|', '\\|') for cell in line) for line in lines)
