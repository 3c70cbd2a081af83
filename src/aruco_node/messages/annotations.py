"""What is seen in a frame, as marks for a viewer to draw over the image: foxglove_msgs/ImageAnnotations.

Few systems have the package foxglove_msgs. Without it, its messages are made here, from the same definition:
that of its last release for ROS 1, 3.1.0.
"""
from functools import lru_cache
from types import SimpleNamespace

from aruco_ar.base.errors import InputError
from aruco_ar.painting.marks import BLACK, GREEN, PURPLE, RED, YELLOW
from genpy.dynamic import generate_dynamic

KIND = 'foxglove_msgs/ImageAnnotations'
DEFINITION = '''\
foxglove_msgs/CircleAnnotation[] circles
foxglove_msgs/PointsAnnotation[] points
foxglove_msgs/TextAnnotation[] texts
''' + ''.join('=' * 80 + '\nMSG: foxglove_msgs/' + part for part in ('''\
CircleAnnotation
time timestamp
foxglove_msgs/Point2 position
float64 diameter
float64 thickness
foxglove_msgs/Color fill_color
foxglove_msgs/Color outline_color
''', '''\
PointsAnnotation
time timestamp
uint8 UNKNOWN=0
uint8 POINTS=1
uint8 LINE_LOOP=2
uint8 LINE_STRIP=3
uint8 LINE_LIST=4
uint8 type
foxglove_msgs/Point2[] points
foxglove_msgs/Color outline_color
foxglove_msgs/Color[] outline_colors
foxglove_msgs/Color fill_color
float64 thickness
''', '''\
TextAnnotation
time timestamp
foxglove_msgs/Point2 position
string text
float64 font_size
foxglove_msgs/Color text_color
foxglove_msgs/Color background_color
''', '''\
Point2
float64 x
float64 y
''', '''\
Color
float64 r
float64 g
float64 b
float64 a
'''))

LINE_PX = 2.0
DOT_PX = 8.0
RIM_PX = 1.0
FONT_PX = 20.0
BEHIND_TEXT = 0.5  # how opaque the ground of an id is
MIDDLE_PX = 0.5    # a viewer counts from the corner of the first pixel, we from its middle


@lru_cache(maxsize=None)
def kinds():
    """The classes of the messages, by their names without the package.

    Raises InputError if there is no package foxglove_msgs, and no room for what Python makes instead.
    """
    try:
        from foxglove_msgs import msg
        if hasattr(msg, 'TextAnnotation'):  # releases before 2.2 do not have it
            return msg
    except ImportError:
        pass
    try:
        made = generate_dynamic(KIND, DEFINITION)
    except OSError as error:  # it writes a file, and imports it
        raise InputError('The messages %s cannot be made: %s. Make room for temporary files, or set TMPDIR to '
                         'another folder.' % (KIND, error)) from None
    return SimpleNamespace(**{name.rpartition('/')[2]: kind for name, kind in made.items()})


def annotations(tags, areas, stamp):
    """The ImageAnnotations of a frame with this stamp: marks as on the images of the exercises.

    ``tags``: each is outlined, with a dot on its first corner and one on its center, where its id begins.
    ``areas``: the Areas to outline. Raises InputError as kinds does.
    """
    return kinds().ImageAnnotations(
        circles=[_dot(point, color, stamp) for tag in tags
                 for point, color in ((tag.corners[0], RED), (tag.center, YELLOW))],
        points=[_loop(tag.corners, GREEN, stamp) for tag in tags] +
               [_loop(area.outline(), PURPLE, stamp) for area in areas],
        texts=[kinds().TextAnnotation(
            timestamp=stamp, position=_point(tag.center), text=str(tag.id), font_size=FONT_PX,
            text_color=_color(YELLOW), background_color=_color(BLACK, BEHIND_TEXT)) for tag in tags])


def _dot(point, color, stamp):
    return kinds().CircleAnnotation(timestamp=stamp, position=_point(point), diameter=DOT_PX, thickness=RIM_PX,
                                    fill_color=_color(color), outline_color=_color(BLACK))


def _loop(points, color, stamp):
    kind = kinds().PointsAnnotation
    return kind(timestamp=stamp, type=kind.LINE_LOOP, points=[_point(point) for point in points],
                outline_color=_color(color), thickness=LINE_PX)


def _point(point):
    return kinds().Point2(float(point[0]) + MIDDLE_PX, float(point[1]) + MIDDLE_PX)


@lru_cache(maxsize=None)
def _color(color, alpha=1.0):
    """A color, (blue, green, red), as a foxglove_msgs/Color."""
    blue, green, red = (value / 255 for value in color)
    return kinds().Color(red, green, blue, alpha)
