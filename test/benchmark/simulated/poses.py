"""Poses of tags and of the camera compared with the truth: ours and those of OpenCV, on the same frames."""
from collections import defaultdict
from itertools import product
from multiprocessing import Pool

import cv2
import numpy as np
from aruco_ar import Detector, PoseEstimator, get_dictionary
from aruco_ar.base.progress import progress, tell
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.tags.tag import square
from rig.accuracy.drives import FRAMES_PER_S, WALL
from rig.accuracy.poses import SIDE, TAGS_WALL, error_of, lens_of, true_pose

from .speed import timed

FLIP = 10.0          # degrees: a rotation that is farther off belongs to the tag's other possible pose
ALONE = 4            # id of the tag that is also seen alone, near the camera's height, which is hardest
DISTANCES = 1.0, 2.0, 3.0, 4.0, 5.0  # meters from that tag, one for each lap
LAP_FRAMES = 1000
SWEEP = np.radians(50)  # radians to each side of that tag
LENSES = {'no distortion': [0.0] * 5, 'k1 = -0.3, k2 = 0.1': [-0.3, 0.1, 0, 0, 0]}
METHODS = {'IPPE_SQUARE': cv2.SOLVEPNP_IPPE_SQUARE, 'ITERATIVE': cv2.SOLVEPNP_ITERATIVE}
# The rows of the table for each method: the distances, in meters, from and to.
RANGES = {'1 m': (0.9, 1.1), '3 m': (2.7, 3.3), 'all': (0, np.inf)}


def past(meters, count=LAP_FRAMES, tag_id=ALONE):
    """Yield the views (see wall_to_camera) of a drive past a tag at about that distance, there and back."""
    tag = next(tag for tag in TAGS_WALL.tags if tag.id == tag_id)
    for part in np.arange(count) / count:
        angle = SWEEP * np.sin(2 * np.pi * part)
        away = meters * (1 + 0.05 * np.sin(14 * np.pi * part))
        heading = -angle + 0.08 * np.sin(22 * np.pi * part)
        yield wall_to_camera(Pose(-away * np.cos(angle), -tag.x + away * np.sin(angle), heading))


class Others:
    """The method of aruco_ros and fiducials: OpenCV's detector, then solvePnP for each tag in each frame."""

    def __init__(self):
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.ArucoDetector(get_dictionary(WALL.dictionary), parameters)

    def poses(self, frame, lens):
        """{method: {id: (R, t)}}. Of the two poses of IPPE_SQUARE this is the one that fits better."""
        quads, ids, _ = self._detector.detectMarkers(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY))
        found = {method: {} for method in METHODS}
        for tag_id, quad in zip([] if ids is None else ids.ravel(), quads):
            for method, flag in METHODS.items():
                _, angles, shift = cv2.solvePnP(square([SIDE])[0], quad.reshape(4, 2), lens.matrix,
                                                lens.distortion, flags=flag)
                found[method][int(tag_id)] = cv2.Rodrigues(angles)[0], shift.ravel()
        return found


def measure(task):
    """Measure one lap: (name of its lens, {method: rows}, milliseconds of each update with four tags).

    ``task``: the name of the lens, and the distance in meters. A row is the true
    range, the error, (6,), and the NEES: the squared error in units of the pose's
    covariance. The NEES is 6 on average if the covariance is honest.
    """
    cv2.setNumThreads(1)
    name, meters = task
    camera = Camera(distortion=LENSES[name])
    lens, renderer = lens_of(camera), WallRenderer(TAGS_WALL, camera, noise=2.0, seed=int(meters))
    detector, others = Detector(), Others()
    alone, learned, given = PoseEstimator(SIDE), PoseEstimator(SIDE), PoseEstimator(SIDE, wall=TAGS_WALL)
    rows, times = defaultdict(list), []
    first = None  # id of the tag whose axes are those of the learned wall
    for number, view in enumerate(past(meters)):
        frame, stamp = renderer.render(*view), number / FRAMES_PER_S
        truth = {tag.id: true_pose(tag, *view) for tag in TAGS_WALL.tags}

        def add_row(method, tag_id, rotation, translation, covariance=None):
            error = error_of(rotation, translation, truth[tag_id])
            rows[method].append((np.linalg.norm(truth[tag_id][1]), *error, _nees(error, covariance)))
        for method, poses in others.poses(frame, lens).items():
            for tag_id, pose in poses.items():
                add_row(method, tag_id, *pose)
                if tag_id == ALONE:
                    add_row(method + ', one tag', tag_id, *pose)
        tags = detector.detect(frame)
        for pose in alone.update([tag for tag in tags if tag.id == ALONE], lens, stamp):
            add_row('ours, one tag', pose.id, pose.rotation, pose.translation, pose.covariance)
        took, poses = timed(learned.update, tags, lens, stamp)
        if len(poses) == 4:
            times.append(took)
        for pose in poses:
            add_row('ours', pose.id, pose.rotation, pose.translation, pose.covariance)
        given.update(tags, lens, stamp)
        if first is None and learned.camera():
            first = min(learned.camera().ids)
        for method, found, (axes, origin) in (
                ('camera, wall learned', learned.camera(), truth.get(first, view)),
                ('camera, wall given', given.camera(), view)):
            if found:
                error = error_of(found.rotation, found.translation, (axes.T, -axes.T @ origin))
                rows[method].append((np.linalg.norm(view[1]), *error, _nees(error, found.covariance)))
    return name, rows, times


def _nees(error, covariance):
    return np.nan if covariance is None else error @ np.linalg.inv(covariance) @ error


def run():
    """Measure all laps, and print the tables."""
    print('\nPoses at 640 x 480, tags of %g m, noise 2, %d frames of driving past at %s m, up to %.0f\n'
          'degrees to both sides. Three numbers: median, 99th percentile, and maximum. A flip is a rotation\n'
          'off by more than %g degrees. The NEES is 6 if covariances are honest, less if they are too large.'
          % (SIDE, LAP_FRAMES * len(DISTANCES), ', '.join('%g' % meters for meters in DISTANCES),
             np.degrees(SWEEP), FLIP))
    rows_of, times = {name: defaultdict(list) for name in LENSES}, []
    with Pool() as pool:
        laps = list(product(LENSES, DISTANCES))
        for name, rows, took in progress(pool.imap_unordered(measure, laps), 'poses', len(laps)):
            for method, more in rows.items():
                rows_of[name][method].extend(more)
            times.extend(took)
    for name, methods in rows_of.items():
        tell('\n%-24s %-4s %6s %6s   %-20s %-20s %-18s %6s' % (
            name, '', 'poses', 'flips', 'place, mm', 'place, % of range', 'rotation, degrees', 'NEES'))
        for method in sorted(methods, key=lambda method: ('camera' in method, 'one tag' not in method, method)):
            rows = np.array(methods[method])
            for title, (near, far) in RANGES.items():
                some = rows[(rows[:, 0] >= near) & (rows[:, 0] < far)]
                if len(some):
                    tell(_line(method if title == '1 m' else '', title, some))
    print('\nupdate() with four tags: %.2f ms per frame (median), 99th percentile %.2f ms'
          % (np.median(times), np.percentile(times, 99)))


def _line(method, title, rows):
    place, turn = np.linalg.norm(rows[:, 1:4], axis=1), np.degrees(np.linalg.norm(rows[:, 4:7], axis=1))
    nees = '-' if np.isnan(rows[:, 7]).any() else '%.1f' % rows[:, 7].mean()
    return '%-24s %-4s %6d %6d   %-20s %-20s %-18s %6s' % (
        method, title, len(rows), np.sum(turn > FLIP), _quantiles(1000 * place, '%.1f'),
        _quantiles(100 * place / rows[:, 0], '%.2f'), _quantiles(turn, '%.2f'), nees)


def _quantiles(values, form):
    return ', '.join(form % value for value in (np.median(values), np.percentile(values, 99), values.max()))
