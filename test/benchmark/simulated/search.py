"""The cost of each search of the detector, and the smallest width of the tags that it finds."""
import os
from math import cos, radians, sin
from multiprocessing import Pool

import cv2
import numpy as np
from aruco_ar import DICTIONARIES, Detector
from aruco_ar.base.progress import progress, tell
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import CAMERA_FORWARD_M, CAMERA_HEIGHT_M, Camera, Pose, wall_to_camera
from aruco_ar.tags.detector import SEARCHES
from aruco_ar.walls.wall import Wall, WallTag
from rig import PACKAGE
from rig.accuracy.drives import WIDE, drive

from benchmark.tags_file import tags_in

from .speed import timed

DICTIONARY = 'DICT_6X6_250'
DEFAULT = "OpenCV's default"
METHODS = (DEFAULT,) + SEARCHES
COST_SIZES = (640, 480), (1280, 720)
COST_FRAMES = 12
NOISE = 2.0
WIDTHS_PX = {0: range(7, 33), 60: range(13, 47)}  # to be tried, by the slant in degrees
FRAMES = 6               # for each width and slant
TAGS, SIDE_M = 5, 0.2    # in each frame; one above the other, so that all are equally far
MIN_FOUND = 0.95         # the share of the tags that must be found within reach
PHOTOS = os.path.join(PACKAGE, '..', 'shared', 'photos')
CROWDS = '33369213973_9d9bb4cc96_c', '34085369442_304b6bafd9_c'
CROWDS_DICTIONARY = 'DICT_APRILTAG_36h11'
SAME_CORNER_PX = 2.0     # a corner that is farther from AprilTag's is another one


def finder(method, dictionary=DICTIONARY):
    """A function that finds tags in a frame by a method. It returns a list of (id, (4, 2) corners)."""
    if method != DEFAULT:
        detector = Detector(dictionary, search=method)
        return lambda frame: [(tag.id, tag.corners) for tag in detector.detect(frame)]
    return opencv_finder(dictionary)


def opencv_finder(dictionary, **settings):
    """The same for OpenCV's detector. ``settings``: those of its parameters that are not the default."""
    parameters = cv2.aruco.DetectorParameters()
    for name, value in settings.items():
        setattr(parameters, name, value)
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(DICTIONARIES[dictionary]), parameters)

    def find(frame):
        corners, ids, _ = detector.detectMarkers(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY))
        return [] if ids is None else [(int(tag_id), quad[0]) for tag_id, quad in zip(ids.ravel(), corners)]
    return find


def cost(size):
    """{method: median milliseconds per frame} on one thread; the methods take turns on the same frames."""
    finders = {method: finder(method) for method in METHODS}
    times = [[timed(find, frame.image)[0] for find in finders.values()]
             for frame in drive(WIDE, COST_FRAMES + 1, noise=NOISE, light=0.3, size=size)]
    return dict(zip(METHODS, np.median(times[1:], axis=0)))


def column(ids, turns):
    """A Wall with tags one above the other, centered at the camera's height.

    ``turns``: the rotation of each tag in degrees.
    """
    heights = CAMERA_HEIGHT_M + 1.6 * SIDE_M * (np.arange(len(ids)) - (len(ids) - 1) / 2)
    tags = tuple(WallTag(tag_id, 0.0, height, SIDE_M, turn)
                 for tag_id, height, turn in zip(ids, heights, turns))
    return Wall(8.0, 3.0, (196, 200, 205), DICTIONARY, 1, tags, tuple(ids[:4]))


def views(width, slant):
    """Yield (frame, ids). The tags are ``width`` pixels high, and seen from ``slant`` degrees to the side."""
    random, camera = np.random.RandomState(1000 * slant + width), Camera()
    for _ in range(FRAMES):
        ids = [int(tag_id) for tag_id in random.choice(250, TAGS, replace=False)]
        wall = column(ids, random.uniform(0, 360, TAGS))
        far = CAMERA_FORWARD_M + camera.matrix[0, 0] * SIDE_M / (width + random.uniform(-0.5, 0.5))
        side = radians(slant)
        pose = Pose(-far * cos(side), -far * sin(side), side + random.uniform(-0.1, 0.1))
        renderer = WallRenderer(wall, camera, noise=NOISE, seed=random.randint(1 << 30))
        yield renderer.render(*wall_to_camera(pose)), ids


def reach(case):
    """(width, slant, {method: [share of the tags found, number of wrong ids]}). ``case``: (width, slant)."""
    cv2.setNumThreads(1)
    width, slant = case
    finders = {method: finder(method) for method in METHODS}
    found = {method: [0, 0] for method in METHODS}
    for frame, ids in views(width, slant):
        for method, find in finders.items():
            seen = {tag_id for tag_id, _ in find(frame)}
            found[method][0] += len(seen & set(ids)) / (FRAMES * TAGS)
            found[method][1] += len(seen - set(ids))
    return width, slant, found


def smallest_width(shares):
    """From which width on at least MIN_FOUND of the tags are found, as text. ``shares``: {width: share}."""
    missed = [width for width, share in shares.items() if share < MIN_FOUND - 1e-9]
    return '%d px' % (max(missed) + 1) if missed else 'below %d px' % min(shares)


def crowd(name):
    """A photo, (h, w, 3) BGR uint8, and the corners, (n, 4, 2), of the tags that AprilTag 3 finds in it."""
    path = os.path.join(PHOTOS, name)
    return cv2.imread(path + '.jpg'), np.array([quad for _, quad in tags_in(path + '.txt')])


def apart(quad, other):
    """Pixels: the largest distance between corresponding corners of two quadrilaterals.

    They may begin with any corner, and go either way round.
    """
    return min(np.linalg.norm(quad - np.roll(turned, turn, axis=0), axis=1).max()
               for turned in (other, other[::-1]) for turn in range(4))


def run():
    """Print cost and reach, and the tags found in the photos, if they are there."""
    cv2.setNumThreads(1)
    print("\nSearches, %s. The cost is the median per frame on one thread, relative to OpenCV's default.\n"
          'The reach is the width in pixels from which on %.0f %% of the tags are found, at 640 x 480 with\n'
          'noise %g, head-on or slanted (then the width without the slant). The wrong ids are those in all\n'
          'these frames.\n'
          % (DICTIONARY, 100 * MIN_FOUND, NOISE))
    costs = [cost(size) for size in COST_SIZES]
    cases = [(width, slant) for slant in WIDTHS_PX for width in WIDTHS_PX[slant]]
    shares = {(method, slant): {} for method in METHODS for slant in WIDTHS_PX}
    wrong = dict.fromkeys(METHODS, 0)
    with Pool() as pool:
        for width, slant, found in progress(pool.imap(reach, cases), 'searches', len(cases)):
            for method in METHODS:
                shares[method, slant][width] = found[method][0]
                wrong[method] += found[method][1]
    print('%-17s' % '' + ''.join('%22s' % ('%d x %d' % size) for size in COST_SIZES)
          + ''.join('%14s' % ('%d degrees' % slant) for slant in WIDTHS_PX) + '%11s' % 'wrong ids')
    for method in METHODS:
        tell('%-17s' % method
             + ''.join('%22s' % ('%.2f ms = %.2fx' % (took[method], took[method] / took[DEFAULT]))
                       for took in costs)
             + ''.join('%14s' % smallest_width(shares[method, slant]) for slant in WIDTHS_PX)
             + '%11d' % wrong[method])
    if os.path.isdir(PHOTOS):
        run_crowds()


def run_crowds():
    """Print how many tags each method finds in the crowded photos."""
    print("\nCrowded photos, %s. A tag is found if all its corners are within %g px of AprilTag's.\n"
          'Further tags may be real, since AprilTag does not find all. No tag has another id than 0.\n'
          % (CROWDS_DICTIONARY, SAME_CORNER_PX))
    for method in METHODS:
        find, counts, further, wrong = finder(method, CROWDS_DICTIONARY), [], 0, 0
        for name in CROWDS:
            photo, truth = crowd(name)
            tags = find(photo)
            off = np.array([[apart(corners, quad) for quad in truth] for _, corners in tags])
            off = off.reshape(-1, len(truth))
            counts.append('%d of %d' % (np.sum((off < SAME_CORNER_PX).any(axis=0)), len(truth)))
            further += int(np.sum((off >= SAME_CORNER_PX).all(axis=1)))
            wrong += sum(tag_id != 0 for tag_id, _ in tags)
        tell('%-17s' % method + ''.join('%12s' % count for count in counts)
             + '   further %d   wrong ids %d' % (further, wrong))
