"""All that nodes do with a picture, and checks of the results."""
import time
import traceback
from io import BytesIO

import numpy as np
from aruco_ar import (
    Detector,
    Lens,
    PoseEstimator,
    Tracker,
    area_mask,
    fill_polygon,
    find_area,
    get_dictionary,
    mark_centers,
    mark_tags,
    order_coordinates,
    overlay,
    subtract,
)
from aruco_ar.geometry.ordering import is_quadrilateral
from aruco_ar.painting.marks import mark_poses
from aruco_ar.poses.wall_watch import WallWatch
from aruco_ar.settings.settings import FITS
from aruco_ar.tags.detector import SEARCHES
from aruco_ar.walls.wall import Wall, WallTag
from aruco_node.messages import pose_messages
from aruco_node.messages.images import polygon_from_pixels, tags_from_pixels
from rospy import Time
from std_msgs.msg import Header

from .scenes import DICTIONARIES, FOCAL, FOUR_SIDE, SQUARE
from .sequences import sequence

PICTURES_EACH = 20       # pictures in a sequence
BIG_EVERY = 250          # every 250th sequence has a few large pictures
SEARCH_SHARES = 0.25, 0.7, 0.05
# The tags may show an area's corner that is out of view. Beyond this many times the frame's longer side,
# an error of a thousandth of a tag's side moves the corner by a whole frame.
MAX_AREA = 30.0
MAX_TAG = 1.0            # a tag's corner may be this far outside of the frame, in units of its longer side
SURE_PX = 1.5            # this far from its sides a pixel is clearly inside or outside of the area
INK = (201, 13, 77)      # the color of the plain pictures
PICTURES = [np.full((8, 12, 3), INK, np.uint8), np.full((1, 4096, 3), INK, np.uint8),
            np.full((64, 1, 3), INK, np.uint8),
            np.random.RandomState(1).randint(0, 256, (48, 64, 4)).astype(np.uint8)]
PLAIN = 3                # the first PICTURES, which have one color
MODELS = {               # {name: (distortion, is_fisheye)} of lenses
    'none': ([], False), 'some': ([-0.3, 0.1, 0.001, -0.001, 0.0], False), 'folding': ([-0.8, 0, 0, 0], False),
    'pincushion': ([1.0, 0.5, 0, 0, 0], False),
    'rational': ([0.5, -0.2, 0.001, -0.001, 0.01, 0.8, -0.1, 0.02], False),
    'tilted': ([-0.2, 0.1, 0, 0, 0, 0, 0, 0, 0.01, 0.002, -0.01, 0.001, 0.1, -0.2], False),
    'fisheye': ([0.1, 0.02, -0.01, 0.003], True), 'strong fisheye': ([-1.0, 0.8, 0.5, 0.3], True),
    'wild': (None, None)}


class Pipeline:
    """A detector, a tracker and a pose estimator that get one picture after the other.

    A RandomState chooses all their settings.
    """

    def __init__(self, random):
        self._random = random
        self.dictionary = str(random.choice(DICTIONARIES))
        self._count = len(get_dictionary(self.dictionary).bytesList)
        ids = random.choice([0] * 5 + [4])
        finds = {'ids': range(ids), 'search': str(random.choice(SEARCHES, p=SEARCH_SHARES)),
                 'correction': random.choice([1.0, 0.5]), 'confidence': random.choice([0.2, 0.2, 0.2, 0.0]),
                 'min_side': int(random.choice([0, 0, 0, 20]))}
        self._detector = Detector(self.dictionary, **finds)
        self._tracker = Tracker(self.dictionary, hold=random.choice([0, 0.3, 60.0]),
                                upright=str(random.choice(['tags', 'image'])), **finds)
        wall = self._wall()
        self._watch = WallWatch(wall, 'some.yaml')
        size = random.choice([0.001, FOUR_SIDE, FOUR_SIDE, 10.0])
        self._estimator = PoseEstimator(size, {3: 0.05} if random.rand() < 0.3 else None, wall)
        usual = random.rand() < 0.5
        self._model = 'none' if usual else str(random.choice(list(MODELS)))
        self._wild = random.normal(0, 1, int(random.choice([4, 5, 8, 12, 14]))) * 10**random.uniform(-2, 8)
        self._focal = FOCAL if usual else random.choice([FOCAL, FOCAL, 10**random.uniform(-3, 3)])
        self._middle = 0.5 if usual else random.choice([0.5, 0.5, random.uniform(-5, 5)])
        self.found = np.zeros(4, int)  # tags, areas, poses, poses of the camera

    def _wall(self):
        """A Wall on which the tags of a scene may hang or not, or None."""
        if self._random.rand() < 0.5:
            return None
        places = SQUARE * [0.9, -0.9] + (0 if self._random.rand() < 0.7 else self._random.normal(0, 1, (4, 2)))
        tags = tuple(WallTag(number, *place, FOUR_SIDE) for number, place in enumerate(places.tolist()))
        return Wall(8.0, 3.0, (200, 200, 200), self.dictionary, 1, tags, (0, 1, 2, 3))

    def _lens(self, size):
        width, height = size
        distortion, fisheye = MODELS[self._model]
        if distortion is None:
            distortion, fisheye = self._wild, len(self._wild) == 4 and self._focal == FOCAL
        matrix = np.array([[self._focal * width, 0, self._middle * (width - 1)],
                           [0, self._focal * width, self._middle * (height - 1)], [0, 0, 1]])
        return Lens(width, height, matrix, np.array(distortion, np.float64), fisheye)

    def faults(self, picture):
        """Process a Picture; returns sentences about wrong results."""
        try:
            with np.errstate(divide='raise', invalid='raise', over='raise'):
                return list(self._faults(picture))
        except Exception as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            own = [at for at in traceback.extract_tb(error.__traceback__) if 'aruco_' in at.filename][-1:]
            return ['%s: %s, at %s' % (type(error).__name__, ' '.join(str(error).split())[:200], ' <- '.join(
                '%s:%d' % (at.filename.rsplit('/', 1)[-1], at.lineno) for at in [place] + own))]

    def _faults(self, picture):
        frame, before = picture.frame, picture.frame.copy()
        shape, size = frame.shape, frame.shape[1::-1]
        longer = max(size)
        tags = self._detector.detect(frame)
        area = self._tracker.update(frame, picture.stamp)
        for tag in [*tags, *self._tracker.tags]:
            yield from self._faults_of_tag(tag, size)
        found = find_area(tags)
        if found is not None:
            yield from _faults_of_area(found, size, 0.05 * longer + 2)
            order_coordinates(found.corners)
            yield from faults_of_paint(frame, found, self._random)
        if area is not None:
            yield from _faults_of_area(area, size, MAX_AREA * longer)
            yield from faults_of_paint(frame, area, self._random)
            polygon_from_pixels(area.corners, _header()).serialize(BytesIO())
        centers = [tag.center for tag in tags]
        images = [mark_tags(frame, tags), mark_centers(fill_polygon(frame, centers), centers)]

        lens = self._lens(size)
        poses = self._estimator.update(tags, lens, picture.stamp)
        for pose in poses:
            yield from _faults_of_pose(pose, 'tag')
            if not (0 <= pose.ambiguity <= 0.5 and pose.translation[2] > 0):
                yield 'a tag with an ambiguity of %g, %g m ahead' % (pose.ambiguity, pose.translation[2])
        camera = self._estimator.camera()
        areas = (found is not None) + (area is not None)
        self.found = self.found + [len(tags), areas, len(poses), camera is not None]
        if camera is not None:
            yield from _faults_of_pose(camera, 'camera')
            yield from _faults_of_pose(camera.carry(np.eye(3)[[1, 2, 0]], np.array([0.1, 0.2, -0.3])), 'robot')
        on_wall = None if area is None else self._estimator.area(area, lens)
        if on_wall is not None:
            yield from _faults_of_pose(on_wall, 'area')
            sides = on_wall.width, on_wall.height
            if not (np.isfinite(on_wall.points).all() and np.isfinite(sides).all() and min(sides) > 0):
                yield 'an area of %g x %g m' % sides
        self._watch.check(poses, camera, picture.stamp)
        yield from _faults_of_messages(tags, poses, camera, on_wall, lens)
        images.append(mark_poses(frame, tags, poses, lens, area))
        for image in images:
            if image.shape != shape or image.dtype != np.uint8:
                yield 'an image of shape %s, %s' % (image.shape, image.dtype)
        if np.any(frame != before):
            yield 'the frame was changed by what should only read it'

    def _faults_of_tag(self, tag, size):
        corners = np.asarray(tag.corners)
        if corners.shape != (4, 2) or corners.dtype != np.float32 or not np.isfinite(corners).all():
            yield 'a tag with corners %s' % corners
        elif not 0 <= tag.id < self._count:
            yield 'a tag with the id %s' % tag.id
        elif np.any(np.abs(corners - np.array(size) / 2) > np.array(size) / 2 + MAX_TAG * max(size)):
            yield 'a tag beyond the frame: %s' % corners.tolist()
        elif np.any(tag.center < corners.min(axis=0) - 0.01) or np.any(tag.center > corners.max(axis=0) + 0.01):
            yield 'a tag whose center is outside it: %s' % corners.tolist()


def _header():
    return Header(stamp=Time(1), frame_id='camera')


def _faults_of_area(area, size, most):
    """``most``: pixels: the corners may be this far outside of the frame."""
    corners = np.asarray(area.corners)
    if corners.shape != (4, 2) or corners.dtype != np.float32 or not np.isfinite(corners).all():
        yield 'an area with corners %s' % corners
    elif not is_quadrilateral(corners):
        yield 'an area that is flat or not convex: %s' % corners.tolist()
    elif np.any(np.abs(corners - np.array(size) / 2) > np.array(size) / 2 + most):
        yield 'an area far beyond the frame of %d x %d: %s' % (*size, corners.tolist())
    if area.ratio is not None and not 0 < area.ratio < np.inf:
        yield 'an area with the ratio %s' % area.ratio


def _cover(area, shape):
    """(h, w) pixels: how far each pixel is inside the area, negative outside of it."""
    corners = np.float64(area.corners)
    along = np.roll(corners, -1, axis=0) - corners
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    if along[0, 0] * along[1, 1] < along[0, 1] * along[1, 0]:
        along = -along
    x, y = np.arange(shape[1])[None, :], np.arange(shape[0])[:, None]
    return np.minimum.reduce([way[0] * (y - at[1]) - way[1] * (x - at[0]) for at, way in zip(corners, along)])


def faults_of_paint(frame, area, random):
    """Yields sentences about what is wrong with the area's mask, and with a picture painted into the area."""
    inside = _cover(area, frame.shape)
    inside, outside = inside > SURE_PX, inside < -SURE_PX
    mask = area_mask(frame, area)
    cut = subtract(frame, mask)
    if mask[outside].any() or (mask[inside] < 255).any() or cut[inside].any() or \
            np.any(cut[outside] != frame[outside]):
        yield 'a mask that is not where the area is: %s' % area.corners.tolist()
    which, fit, opacity = random.randint(len(PICTURES)), str(random.choice(FITS)), random.choice([0, 0.4, 1, 1])
    painted = overlay(frame, PICTURES[which], area, fit=fit, opacity=opacity)
    if painted.shape != frame.shape or painted.dtype != np.uint8:
        yield 'a painted image of shape %s, %s' % (painted.shape, painted.dtype)
    elif np.any(painted[outside] != frame[outside]):
        yield 'paint outside the area: %s' % area.corners.tolist()
    elif which < PLAIN and opacity == 1 and fit != 'contain' and np.any(painted[inside] != np.uint8(INK)):
        yield 'no paint within the area: %s' % area.corners.tolist()


def _faults_of_pose(pose, name):
    spread = pose.covariance
    if not all(np.isfinite(part).all() for part in (pose.rotation, pose.translation, spread)):
        yield 'a pose of a %s that is not finite' % name
        return
    if np.abs(pose.rotation @ pose.rotation.T - np.eye(3)).max() > 1e-6 or np.linalg.det(pose.rotation) < 0:
        yield 'a pose of a %s without a rotation matrix' % name
    scale = np.sqrt(spread.diagonal().clip(1e-300))
    if np.abs(spread - spread.T).max() > 1e-6 * np.abs(spread).max() or \
            np.linalg.eigvalsh((spread + spread.T) / 2 / np.outer(scale, scale)).min() < -1e-6:
        yield 'an invalid covariance of a %s: %s' % (name, spread.tolist())


def _faults_of_messages(tags, poses, camera, on_wall, lens):
    messages = [tags_from_pixels(tags, _header()),
                pose_messages.tag_poses(poses, lens, _header()),
                pose_messages.markers(poses, on_wall, _header())]
    if on_wall is not None:
        messages.append(pose_messages.area_pose(on_wall, lens, _header()))
    messages += [pose_messages.transform(pose, Time(1), 'camera', 'tag') for pose in poses]
    if camera is not None:
        messages.append(pose_messages.stamped(camera, Time(1), 'wall'))
    for message in messages:
        message.serialize(BytesIO())
        bad = sorted(set(_not_finite(message)))
        if bad:
            yield 'a %s whose %s is not finite' % (message._type, ', '.join(bad))


def _not_finite(message, name=''):
    """Yields the names of all fields of a message, at any depth, that are NaN or infinite."""
    if isinstance(message, float):
        if not np.isfinite(message):
            yield name
    elif isinstance(message, (list, tuple)):
        for each in message:
            yield from _not_finite(each, name)
    elif hasattr(message, '__slots__'):
        for slot in message.__slots__:
            yield from _not_finite(getattr(message, slot), slot)


def watch(seed, number):
    """Process the sequence of hostile pictures with this number.

    Yields for each picture its kind, the numbers of (tags, areas, poses, camera
    poses) found, the CPU seconds, and sentences about wrong results.
    """
    random = np.random.RandomState([seed, number])
    pipeline = Pipeline(random)
    big = number % BIG_EVERY == BIG_EVERY - 1
    size = (1920, 1080) if big else (int(random.randint(96, 320)), int(random.randint(80, 240)))
    for picture in sequence(random, pipeline.dictionary, 4 if big else PICTURES_EACH, size):
        before, began = pipeline.found, time.process_time()
        faults = pipeline.faults(picture)
        yield picture.kind, pipeline.found - before, time.process_time() - began, faults
