"""Photos and clips with known tags, if they are beside the package: we find what OpenCV finds."""
import os

import cv2
import numpy as np
import pytest
from aruco_ar import DICTIONARIES, Detector
from rig import PACKAGE

SHARED = os.path.join(PACKAGE, '..', 'shared')
STEP = 12  # of the frames of a clip, every twelfth is searched
PUSHED = tuple(range(0, 72, 4))
CASES = {
    'photos/singlemarkersoriginal.jpg': ('DICT_6X6_250', (23, 40, 62, 98, 124, 203)),
    'photos/tag_245-246_d7_14cm.png': ('DICT_5X5_1000', (245, 246)),
    'photos/33369213973_9d9bb4cc96_c.jpg': ('DICT_APRILTAG_36h11', (0,)),
    'photos/34085369442_304b6bafd9_c.jpg': ('DICT_APRILTAG_36h11', (0,)),
    'photos/steep_60.png': ('DICT_APRILTAG_36h11', (76,)),
    'photos/street.png': ('DICT_APRILTAG_36h11', (22, 24, 58, 85, 144, 198)),
    'videos/board.mp4': ('DICT_5X5_100', tuple(range(48))),
    'videos/dark.mp4': ('DICT_4X4_50', tuple(range(12))),
    'videos/pushed.mp4': ('DICT_ARUCO_ORIGINAL', PUSHED),
    'videos/turned.avi': ('DICT_4X4_50', tuple(range(10)))}
OTHERS = 'DICT_4X4_1000', 'DICT_5X5_1000', 'DICT_6X6_250'  # dictionaries that are not in the photos and clips


def frames_of(name):
    """The photo, or a sample of the frames of the clip: (h, w, 3) BGR uint8 each."""
    path = os.path.join(SHARED, name)
    if not os.path.isfile(path):
        pytest.skip('the file %s is missing' % os.path.normpath(path))
    if name.startswith('photos'):
        return [cv2.imread(path)]
    video, frames = cv2.VideoCapture(path), []
    good, frame = video.read()
    while good:
        frames.append(frame)
        good, frame = video.read()
    return frames[::STEP]


def by_opencv(dictionary, frame):
    """[(id, center)] of the tags that OpenCV finds with its defaults."""
    table = cv2.aruco.getPredefinedDictionary(DICTIONARIES[dictionary])
    corners, ids, _ = cv2.aruco.ArucoDetector(table, cv2.aruco.DetectorParameters()).detectMarkers(frame)
    ids = [] if ids is None else ids.ravel()
    return [(int(tag_id), quad[0].mean(axis=0)) for tag_id, quad in zip(ids, corners)]


def ours(detector, frame):
    """[(id, center)] of the tags that we find."""
    return [(tag.id, tag.corners.mean(axis=0)) for tag in detector.detect(frame)]


def split(found, true_ids):
    """Those with one of these ids, and the others."""
    return [tag for tag in found if tag[0] in true_ids], [tag for tag in found if tag[0] not in true_ids]


@pytest.mark.clips
@pytest.mark.parametrize('name', sorted(CASES))
def test_no_true_tag_is_missed_that_opencv_finds_and_no_more_false_ones_are_found(name):
    dictionary, true_ids = CASES[name]
    detector, counts, missed = Detector(dictionary), np.zeros(4, int), []
    for number, frame in enumerate(frames_of(name)):
        theirs, their_false = split(by_opencv(dictionary, frame), true_ids)
        found, false = split(ours(detector, frame), true_ids)
        counts += len(theirs), len(their_false), len(found), len(false)
        missed += [(number, tag_id) for tag_id, center in theirs
                   if not any(tag_id == other and np.abs(center - place).max() < 5 for other, place in found)]
    assert counts[2] >= counts[0] and counts[3] <= counts[1], counts
    assert len(missed) <= 0.005 * counts[0], missed


@pytest.mark.clips
def test_white_tags_are_found_as_black_ones_are():
    """A real board that was printed white on black: in the clip, its colors are negated."""
    dictionary, true_ids = CASES['videos/turned.avi']
    detector, black, white = Detector(dictionary), 0, 0
    for frame in frames_of('videos/turned.avi'):
        black += len(split(ours(detector, frame), true_ids)[0])
        found, false = split(ours(detector, 255 - frame), true_ids)
        white += len(found)
        assert not false
    assert white >= 0.95 * black > 40


@pytest.mark.clips
def test_with_another_dictionary_fewer_things_are_mistaken_for_tags_than_by_opencv():
    theirs = false = 0
    for name, (own, _) in CASES.items():
        frames = frames_of(name)
        for dictionary in OTHERS:
            if dictionary[:8] == own[:8]:
                continue
            detector = Detector(dictionary)
            theirs += sum(len(by_opencv(dictionary, frame)) for frame in frames)
            false += sum(len(ours(detector, frame)) for frame in frames)
    assert false < 0.6 * theirs
