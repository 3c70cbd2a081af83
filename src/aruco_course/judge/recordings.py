"""Frames that a camera recorded, with the tags in them: those in which OpenCV and our own detector agree."""
from __future__ import annotations

import os
from typing import Iterable, Sequence

import cv2
import numpy as np
from aruco_ar import Detector, InputError, load_picture
from aruco_ar.base.arrays import Image
from aruco_ar.tags.tag import Tag
from aruco_ar.walls.wall import DICTIONARY

from aruco_course.check import View

from .views import course_detect

MOST = 10        # frames that are taken
APART_PX = 3.0   # corners at most so far apart are the same
EVERY = 6        # of a video's frames, one of so many is looked at: those in between show nearly the same
PICTURES = '.jpg', '.jpeg', '.png', '.webp', '.bmp'


def recorded_views(path: str, count: int = 4) -> list[View]:
    """Views of a video, of a picture, or of the pictures in a folder, with ``count`` tags in each.

    Raises InputError if it cannot be read, or if no frame has that many tags.
    """
    if os.path.isdir(path):
        names = sorted(name for name in os.listdir(path) if name.lower().endswith(PICTURES))
        frames: Iterable[Image] = (_picture(os.path.join(path, name)) for name in names)
    elif path.lower().endswith(PICTURES):
        frames = [_picture(path)]
    else:
        frames = _frames_of_video(path)
    return agreed_views(frames, path, count)


def agreed_views(frames: Iterable[Image], name: str, count: int = 4) -> list[View]:
    """Views of those frames, (h, w, 3) BGR uint8, that show ``count`` tags for sure, spread over all of them.

    ``name``: of the file that they are from. Raises InputError if there are none.
    """
    detector = Detector(DICTIONARY)
    found: list[View] = []
    number, stride = -1, 1
    for frame in frames:
        tags = tuple(detector.detect(frame))
        if len(tags) == count and _are_found_by_opencv(tags, frame):
            number += 1
            if number % stride == 0:
                found.append(View(frame, tags))
            if len(found) > 2 * MOST:  # a long recording does not fit into memory
                found, stride = found[::2], 2 * stride
    if not found:
        raise InputError('In no frame of "%s" are %d tags of %s that OpenCV finds as well.'
                         % (name, count, DICTIONARY))
    return [found[place] for place in np.linspace(0, len(found) - 1, min(MOST, len(found))).astype(int)]


def _picture(path: str) -> Image:
    """A picture without its transparency."""
    return np.ascontiguousarray(load_picture(path)[..., :3])


def _are_found_by_opencv(tags: Sequence[Tag], frame: Image) -> bool:
    """Whether OpenCV, as the course uses it, finds these tags where they are, and no others."""
    corners, ids, _ = course_detect(frame)
    places = dict(zip(ids, corners))
    return sorted(ids) == sorted(tag.id for tag in tags) \
        and all(np.abs(places[tag.id] - tag.corners).max() < APART_PX for tag in tags)


def _frames_of_video(path: str) -> Iterable[Image]:
    if not os.path.isfile(path):
        raise InputError('There is no file "%s".' % path)
    video = cv2.VideoCapture(path)
    number = 0
    while video.grab():
        if number % EVERY == 0:
            done, frame = video.retrieve()
            if done:
                yield frame
        number += 1
    video.release()
    if not number:
        raise InputError('"%s" is no video that OpenCV can read.' % path)
