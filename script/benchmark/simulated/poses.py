"""Poses of tags and of the camera against the truth, ours beside what others compute, on the same frames."""
from collections import defaultdict
from dataclasses import replace
from itertools import product
from multiprocessing import Pool

import cv2
import numpy as np
from aruco_ar import Detector, Lens, PoseEstimator, get_dictionary
from aruco_ar.base.progress import progress, tell
from aruco_ar.geometry.plane_pose import rotation_vector
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.tags.tag import square

from .drives import FRAMES_PER_S, WALL
from .speed import timed

FLIP = 10.0          # degrees: a rotation that is farther off is that of the tag's other pose
SIDE = 0.2           # meters, of each tag
ALONE = 4            # the tag that is seen alone: the one at about the camera's height, which is the hardest
LAPS = 1.0, 2.0, 3.0, 4.0, 5.0  # meters from that tag
LAP = 1000           # frames of each
SWEEP = np.radians(50)  # so far to both sides of it
TAGS_WALL = replace(WALL, tags=tuple(replace(tag, side=SIDE) for tag in WALL.tags))
LENSES = {'no distortion': [0.0] * 5, 'k1 = -0.3, k2 = 0.1': [-0.3, 0.1, 0, 0, 0]}
METHODS = {'IPPE_SQUARE': cv2.SOLVEPNP_IPPE_SQUARE, 'ITERATIVE': cv2.SOLVEPNP_ITERATIVE}
WHERE = {'1 m': (0.9, 1.1), '3 m': (2.7, 3.3), 'all': (0, np.inf)}


def past(meters, count=LAP, tag_id=ALONE):
    """Views (see wall_to_camera) of a drive past a tag at about that distance, there and back."""
    tag = next(tag for tag in TAGS_WALL.tags if tag.id == tag_id)
    for part in np.arange(count) / count:
        angle = SWEEP * np.sin(2 * np.pi * part)
        away = meters * (1 + 0.05 * np.sin(14 * np.pi * part))
        heading = -angle + 0.08 * np.sin(22 * np.pi * part)
        yield wall_to_camera(Pose(-away * np.cos(angle), -tag.x + away * np.sin(angle), heading))


def lens_of(camera):
    """The Lens of a simulated Camera."""
    return Lens(camera.width, camera.height, camera.matrix, np.float64(camera.distortion))


def true_pose(tag, rotation, translation):
    """(R, t) of a WallTag in the camera, from the wall's."""
    top_left, top_right, _, bottom_left = tag.corners
    right, up = (top_right - top_left) / tag.side, (top_left - bottom_left) / tag.side
    axes = np.stack([right, up, np.cross(right, up)], axis=1)
    return rotation @ axes, rotation @ [tag.x, tag.y, 0] + translation


def error_of(rotation, translation, truth):
    """(6,): how far off a pose is, meters and radians, as its covariance has it."""
    return np.concatenate([translation - truth[1], rotation_vector(rotation @ truth[0].T)])


class Others:
    """What aruco_ros and fiducials do: OpenCV's detector, then solvePnP for each tag of each frame."""

    def __init__(self):
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.ArucoDetector(get_dictionary(WALL.dictionary), parameters)

    def poses(self, frame, lens):
        """{method: {id: (R, t)}}, of the two poses of IPPE_SQUARE the one that fits better."""
        quads, ids, _ = self._detector.detectMarkers(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY))
        found = {method: {} for method in METHODS}
        for tag_id, quad in zip([] if ids is None else ids.ravel(), quads):
            for method, flag in METHODS.items():
                _, angles, shift = cv2.solvePnP(square([SIDE])[0], quad.reshape(4, 2), lens.matrix,
                                                lens.distortion, flags=flag)
                found[method][int(tag_id)] = cv2.Rodrigues(angles)[0], shift.ravel()
        return found


def measure(task):
    """Of one lap: its lens, {method: rows}, milliseconds a frame.

    A row is the true range, the error (6,), and NEES: the error's square, in
    units of the covariance that comes with the pose, 6 on average if that is honest.
    """
    cv2.setNumThreads(1)
    name, meters = task
    camera = Camera(distortion=LENSES[name])
    lens, renderer = lens_of(camera), WallRenderer(TAGS_WALL, camera, noise=2.0, seed=int(meters))
    detector, others = Detector(), Others()
    alone, learned, given = PoseEstimator(SIDE), PoseEstimator(SIDE), PoseEstimator(SIDE, wall=TAGS_WALL)
    rows, times = defaultdict(list), []
    first = None  # id of the tag in whose axes the learned wall is
    for number, view in enumerate(past(meters)):
        frame, stamp = renderer.render(*view), number / FRAMES_PER_S
        truth = {tag.id: true_pose(tag, *view) for tag in TAGS_WALL.tags}

        def note(method, tag_id, rotation, translation, covariance=None):
            error = error_of(rotation, translation, truth[tag_id])
            rows[method].append((np.linalg.norm(truth[tag_id][1]), *error, _nees(error, covariance)))
        for method, poses in others.poses(frame, lens).items():
            for tag_id, pose in poses.items():
                note(method, tag_id, *pose)
                if tag_id == ALONE:
                    note(method + ', one tag', tag_id, *pose)
        tags = detector.detect(frame)
        for pose in alone.update([tag for tag in tags if tag.id == ALONE], lens, stamp):
            note('ours, one tag', pose.id, pose.rotation, pose.translation, pose.covariance)
        took, poses = timed(learned.update, tags, lens, stamp)
        if len(poses) == 4:
            times.append(took)
        for pose in poses:
            note('ours', pose.id, pose.rotation, pose.translation, pose.covariance)
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
    """Measure all laps and print the tables."""
    print('\nPoses, 640 x 480, tags of %g m, noise 2, %d frames of driving past at %s m, from %.0f degrees to\n'
          'both sides. Each: median, 99 %% below, max. A flip is a rotation off by more than %g degrees.\n'
          'NEES is 6 where covariances are honest, less where they are too large.'
          % (SIDE, LAP * len(LAPS), ', '.join('%g' % lap for lap in LAPS), np.degrees(SWEEP), FLIP))
    found, times = {name: defaultdict(list) for name in LENSES}, []
    with Pool() as pool:
        for name, rows, took in progress(pool.imap_unordered(measure, list(product(LENSES, LAPS))), 'poses',
                                         len(LENSES) * len(LAPS)):
            for method, more in rows.items():
                found[name][method].extend(more)
            times.extend(took)
    for name, methods in found.items():
        tell('\n%-24s %-4s %6s %6s   %-20s %-20s %-18s %6s' % (
            name, '', 'poses', 'flips', 'place, mm', 'place, % of range', 'rotation, degrees', 'NEES'))
        for method in sorted(methods, key=lambda method: ('camera' in method, 'one tag' not in method, method)):
            rows = np.array(methods[method])
            for where, (near, far) in WHERE.items():
                some = rows[(rows[:, 0] >= near) & (rows[:, 0] < far)]
                if len(some):
                    tell(_line(method if where == '1 m' else '', where, some))
    print('\nupdate() with four tags: %.2f ms a frame (median), 99 %% below %.2f ms'
          % (np.median(times), np.percentile(times, 99)))


def _line(method, where, rows):
    place, turn = np.linalg.norm(rows[:, 1:4], axis=1), np.degrees(np.linalg.norm(rows[:, 4:7], axis=1))
    nees = '-' if np.isnan(rows[:, 7]).any() else '%.1f' % rows[:, 7].mean()
    return '%-24s %-4s %6d %6d   %-20s %-20s %-18s %6s' % (
        method, where, len(rows), np.sum(turn > FLIP), _three(1000 * place, '%.1f'),
        _three(100 * place / rows[:, 0], '%.2f'), _three(turn, '%.2f'), nees)


def _three(values, form):
    return ', '.join(form % value for value in (np.median(values), np.percentile(values, 99), values.max()))
