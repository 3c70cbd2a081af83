"""What a node prints for ``--help``: its topics, services and parameters."""
from dataclasses import dataclass
from textwrap import fill
from typing import Any, List, Tuple

from aruco_ar.settings.declaration import parameters_of

from aruco_node.messages.annotations import KIND
from aruco_node.parameters.parameters import ros_values

from .frame_node import CAMERA

TEXT_WIDTH, WIDTH = 60, 120
Row = Tuple[str, str, str]  # name, type, what it is. The name TOPIC stands for any topic


@dataclass(frozen=True)
class Manual:
    """The interface of a node. ``settings``: the class of its parameters."""

    subscribes: List[Row]
    publishes: List[Row]
    services: List[Row]
    settings: Any
    launch: str = ''  # name of the launch file, if it is not the node's name

    def text(self, name, purpose):
        """The manual of the node of that name; ``purpose`` says what it is for."""
        live = any(each.live for each in parameters_of(self.settings).values())
        publishes, services = self.publishes + COMMON, list(self.services)
        if live:
            publishes = publishes + LIVE
            services.append(('~set_parameters', 'dynamic_reconfigure/Reconfigure', ''))
        parts = ['%s\n\nrosrun unit5 %s.py _PARAMETER:=VALUE   or   roslaunch unit5 %s.launch ARGUMENT:=VALUE'
                 % (purpose.strip(), name, self.launch or name)]
        for title, rows in (('Subscribes', self.subscribes), ('Publishes', publishes), ('Services', services),
                            ('Parameters' + ', * can be changed while it runs (dynamic_reconfigure)' * live,
                             parameter_rows(self.settings, '~', ' *'))):
            if rows:
                parts.append('%s:\n%s' % (title, table(rows)))
        return '\n\n'.join(parts)


CAMERA_TOPICS = [
    (CAMERA, 'sensor_msgs/Image', 'the frames: bgr8 rgb8 bgra8 rgba8 mono8 mono16 bayer_* yuv422'),
    (CAMERA + '/compressed', 'sensor_msgs/CompressedImage', 'JPEG or PNG instead, see ~image_transport')]
BESIDE_IMAGES = [
    ('~tags', 'unit5/TagArray', 'ids and corners of the tags in sight'),
    ('~annotations', KIND, 'tags, centers and area, as marks that Foxglove draws over ~image'),
    ('~camera_info', 'sensor_msgs/CameraInfo', 'the calibration of the camera, with the header of each frame')]
CAMERA_INFO = 'camera/rgb/camera_info'
FRAME_SERVICES = [('~snapshot', 'std_srvs/Trigger', 'saves a frame and what is made of it')]
COMMON = [('/diagnostics', 'diagnostic_msgs/DiagnosticArray', 'the status of the node, once a second')]
LIVE = [('~parameter_descriptions', 'dynamic_reconfigure/ConfigDescription', ''),
        ('~parameter_updates', 'dynamic_reconfigure/Config', '')]


def camera_manual(topics, settings, learns, subscribes=(), publishes=()):
    """The Manual of a CameraNode.

    ``topics``: private names of its images. ``settings``: the class of its parameters. ``learns``: whether it
    has the services ~reset and ~save_wall. ``subscribes``, ``publishes``: its further rows.
    """
    info = [(CAMERA_INFO, 'sensor_msgs/CameraInfo', 'the calibration of the camera')]
    of_wall = [('~reset', 'std_srvs/Trigger', 'forgets what was learned about the wall'),
               ('~save_wall', 'std_srvs/Trigger', 'writes what was learned about it into a file, for ~wall')]
    return Manual(
        CAMERA_TOPICS + info + list(subscribes),
        image_topics(topics) + BESIDE_IMAGES + list(publishes),
        FRAME_SERVICES + of_wall * learns, settings)


def image_topics(topics):
    """Rows for the image topics that a FrameNode publishes."""
    return [row for topic in topics for row in (
        ('~' + topic, 'sensor_msgs/Image', 'bgr8, with the header of the frame'),
        ('~%s/compressed' % topic, 'sensor_msgs/CompressedImage', 'the same as JPEG'))]


def parameter_rows(settings, prefix, live=''):
    """Rows of the parameters of a class of settings: name, default, and what it is for.

    ``prefix``: what is put before each name. ``live``: the mark appended to the default of each live parameter.
    """
    values = ros_values(settings())
    return [(prefix + name, '%s%s' % (values[name], live if parameter.live else ''), parameter.sentence)
            for name, parameter in parameters_of(settings).items()]


def table(rows):
    """Rows as text in three columns. A long text in the last column continues in further lines."""
    widths = [max(len(row[column]) for row in rows) for column in (0, 1)]
    indent = ' ' * (sum(widths) + 6)
    return '\n'.join(
        fill('  %-*s  %-*s  %s' % (widths[0], name, widths[1], kind, what),
             min(len(indent) + TEXT_WIDTH, WIDTH), subsequent_indent=indent, drop_whitespace=True)
        for name, kind, what in rows)
