"""The frames on which detectors are compared, simulated and real, and what is known of them."""
import glob
import os
from dataclasses import dataclass
from itertools import groupby
from math import cos, radians, sin
from operator import itemgetter

import cv2
import numpy as np
from aruco_ar import InputError
from aruco_ar.base.files import yaml_entries
from aruco_ar.simulation.render import WallRenderer, project
from aruco_ar.simulation.robot import CAMERA_HEIGHT_M, Camera, Pose, wall_to_camera
from aruco_ar.walls.wall import Wall, WallTag

from benchmark.real_clips.clips import CLIP_ENDINGS, Clip, clip_from, description_of
from benchmark.real_clips.truth import tags_of
from benchmark.tags_file import tags_in

PHOTO_ENDINGS = '.jpg', '.jpeg', '.png'
WITH_CORNERS, WITH_IDS, WITHOUT = 'corners known', 'ids known', 'without truth'
OF_EACH = 60                # at most so many frames of a clip, evenly spread over it
DICTIONARIES = 'DICT_6X6_250', 'DICT_APRILTAG_36h11', 'DICT_APRILTAG_25h9', 'DICT_APRILTAG_16h5'
RENDERED = 60               # frames of each dictionary
NOISE, BLUR_PX = 2.0, 0.7
COLUMNS, ROWS, SIDE_M, STEP_M = 5, 4, 0.15, 0.28
FAR_M = 1.6, 7.0            # from the camera to the wall
SLANT, TURN = 60, 0.1       # degrees to both sides, and how far the camera looks past the tags, radians


@dataclass(frozen=True)
class Truth:
    """What is known of a frame.

    ``tags``: a list of (id, (4, 2) corners in pixels, or None where only the id is known), perhaps of some that
    are out of view; None if no places are known. ``ids``: of all tags that there can be; None if not known.
    """

    tags: object = None
    ids: object = None


@dataclass(frozen=True)
class Scene:
    """Frames with tags of one dictionary.

    ``frames``: an iterable of (frame, (h, w, 3) BGR, and its Truth). ``exact``: whether errors of corners can
    be told, since none of the detectors gave the truth. ``plane``: whether the tags stay where they are in one
    plane, in the same order in each Truth.
    """

    name: str
    dictionary: str
    frames: object
    exact: bool
    plane: bool = False


def rendered(dictionary, count=RENDERED):
    """A Scene of a simulated wall, seen from near and far, head-on and slanted."""
    random, camera = np.random.RandomState(0), Camera()
    places = [(STEP_M * (column - (COLUMNS - 1) / 2), CAMERA_HEIGHT_M + STEP_M * (row - (ROWS - 1) / 2))
              for row in range(ROWS) for column in range(COLUMNS)]
    tags = tuple(WallTag(number, x, y, SIDE_M, random.uniform(0, 360)) for number, (x, y) in enumerate(places))
    wall = Wall(8.0, 3.0, (196, 200, 205), dictionary, 1, tags, (0, 1, 2, 3))
    renderer = WallRenderer(wall, camera, noise=NOISE, blur=BLUR_PX)

    def frames():
        for far in np.geomspace(*FAR_M, count):
            side = radians(random.uniform(-SLANT, SLANT))
            view = wall_to_camera(Pose(-far * cos(side), -far * sin(side), side + random.uniform(-TURN, TURN)))
            truth = [(tag.id, project(tag.corners, *view, camera)[0]) for tag in tags]
            yield renderer.render(*view), Truth(truth, set(range(len(tags))))
    return Scene('simulated, %d frames, %s' % (count, WITH_CORNERS), dictionary, frames(), True)


def scenes_in(folder, dictionary):
    """Yield the Scenes of a folder: its clips, and its photos of each dictionary together.

    Its NAME.yaml, see description_of, gives the dictionary of NAME.mp4 or NAME.jpg, and ``all_ids``.
    ``dictionary`` is that of the others. NAME.txt beside a photo lists its tags, see tags_in. The tags
    of a clip of which all ids are known are in one plane. Raises InputError.
    """
    if not os.path.isdir(folder):
        raise InputError('There is no folder "%s" with photos and clips.' % folder)
    paths = sorted(glob.glob(os.path.join(glob.escape(folder), '*')))
    clips = [path for path in paths if path.lower().endswith(CLIP_ENDINGS)]
    photos = [_photo(path, dictionary) for path in paths if path.lower().endswith(PHOTO_ENDINGS)]
    if not clips and not photos:
        raise InputError('The folder "%s" has no photo and no clip (%s).'
                         % (folder, ', '.join(PHOTO_ENDINGS + CLIP_ENDINGS)))
    for (kind, of_these), group in groupby(sorted(photos, key=itemgetter(0, 1)), itemgetter(0, 1)):
        frames = [(photo, truth) for _, _, photo, truth in group]
        yield Scene('%d photo%s, %s' % (len(frames), 's' * (len(frames) > 1), kind), of_these, frames,
                    kind == WITH_CORNERS)
    for path in clips:
        yield _clip(path, dictionary)


def _described(path, dictionary):
    """What the NAME.yaml of a photo or clip says: a Clip, and whose corners those of the truth are, or None."""
    description = description_of(path)
    if description is None:
        return Clip(path, dictionary, ()), None
    with yaml_entries(description) as entries:
        return clip_from(path, entries, entries.get('ids', ())), entries.get('corners_by')


def _photo(path, dictionary):
    """(what is known of it, its dictionary, the photo, its Truth)."""
    about, corners_by = _described(path, dictionary)
    photo = cv2.imread(path)
    if photo is None:
        raise InputError('OpenCV cannot read "%s" as a photo.' % path)
    listed = os.path.splitext(path)[0] + '.txt'
    tags = tags_in(listed) if os.path.isfile(listed) else [(tag_id, None) for tag_id in about.all_ids] or None
    if tags is None:
        kind, truth = WITHOUT, Truth()
    else:
        kind = WITH_IDS if any(corners is None for _, corners in tags) else \
            'corners by %s' % corners_by if corners_by else WITH_CORNERS
        truth = Truth(tags, {tag_id for tag_id, _ in tags})
    return kind, about.dictionary, photo, truth


def _clip(path, dictionary):
    clip, _ = _described(path, dictionary)
    frames, _ = clip.frames()
    step = -(-len(frames) // OF_EACH)
    truths = [Truth()] * len(frames)
    ids = set(clip.all_ids)
    if ids:
        height, width = frames[0].shape[:2]
        truths = [Truth(list(tags.items()) if tags else None, ids)
                  for tags in tags_of(frames, clip.dictionary, ids, clip.lens((width, height)))]
    name = '%s, %d frames, %s' % (os.path.basename(path), len(frames[::step]), WITH_CORNERS if ids else WITHOUT)
    return Scene(name, clip.dictionary, list(zip(frames, truths))[::step], True, True)
