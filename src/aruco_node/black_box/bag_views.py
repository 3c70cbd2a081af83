"""Frames of a bag with the truth about them: those in which plain OpenCV finds the same tags as we do."""
import cv2
import numpy as np
from aruco_ar import Detector
from aruco_ar.base.errors import InputError
from aruco_bags.bag_reader import decoder_of, messages, pieces_of
from aruco_course.check import View

from .graph import COMPRESSED, IMAGE

DICTIONARY = 'DICT_6X6_250'
MOST = 10       # frames that are taken
APART_PX = 3.0  # corners that are at most so far apart are the same
LEAST_S = 0.2   # from one frame to the next one that is taken


def views_of_bag(path, topic, count=4):
    """Views of a bag's frames with ``count`` tags, spread over its length.

    ``topic``: that of the images, if the bag has several. Raises InputError if there are none.
    """
    pieces, _ = pieces_of(path)
    cameras = sorted({piece.camera for piece in pieces})
    chosen = [piece for piece in pieces if piece.camera == topic] or \
        [piece for piece in pieces if len(cameras) == 1]
    if not chosen:
        raise InputError('The bag has the images %s, but not %s; give camera:=TOPIC.'
                         % (', '.join(cameras), topic))
    detector, found, last = Detector(DICTIONARY), [], None
    for piece in chosen:
        decode = decoder_of(piece)
        for message, time, is_in_piece in messages(piece):
            if not is_in_piece or message._type not in (IMAGE, COMPRESSED) \
                    or (last is not None and (time - last).to_sec() < LEAST_S):
                continue
            frame = decode(message)
            tags = tuple(detector.detect(frame))
            if len(tags) == count and _finds_the_same(frame, tags):
                found.append(View(frame, tags))
                last = time
    if not found:
        raise InputError('In no frame of "%s" are there %d tags of %s that plain OpenCV finds as well.'
                         % (path, count, DICTIONARY))
    return [found[place] for place in np.linspace(0, len(found) - 1, min(MOST, len(found))).astype(int)]


def _finds_the_same(frame, tags):
    """Whether OpenCV's detector, with its defaults, finds these tags and no others at the same places."""
    finder = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250))
    quads, ids, _ = finder.detectMarkers(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY))
    if ids is None or sorted(ids.ravel().tolist()) != sorted(tag.id for tag in tags):
        return False
    places = {int(tag_id): quad[0] for tag_id, quad in zip(ids.ravel(), quads)}
    return all(np.abs(places[tag.id] - tag.corners).max() < APART_PX for tag in tags)
