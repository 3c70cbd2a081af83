"""Real clips, if they are beside the package: no hint is false, and one that is true names the remedy."""
import os

import cv2
import numpy as np
import pytest
from aruco_ar.hints.hints import Hints
from aruco_ar.settings.settings import AreaSettings
from aruco_ar.tracking.observer import Observer
from benchmark.real_clips import clips as real

WIDEST_PX, FRAMES_PER_S, LONG_S = 960, 10, 10


def shown(name, change, seconds=None, dictionary=None, any_ids=False):
    """All that is said of a clip, looped until ``seconds`` are over. Each search is done at once."""
    if not os.path.isdir(real.CLIPS):
        pytest.skip('the folder %s with clips is missing' % os.path.normpath(real.CLIPS))
    clip, = (clip for clip in real.clips_of(real.CLIPS) if os.path.basename(clip.path) == name)
    frames, rate = clip.frames()
    step = max(1, round(rate / FRAMES_PER_S))
    scale = min(1.0, WIDEST_PX / frames[0].shape[1])
    size = tuple(round(scale * side) for side in frames[0].shape[1::-1])
    frames = [np.ascontiguousarray(change(cv2.resize(frame, size, interpolation=cv2.INTER_AREA)))
              for frame in frames[::step]]
    detection = {'dictionary': dictionary or clip.dictionary, 'ids': () if any_ids else clip.ids}
    observer, hints, said = Observer([AreaSettings(**detection)]), Hints(detection, 'tags'), []
    for number in range(len(frames) if seconds is None else int(seconds * rate / step)):
        frame, stamp = frames[number % len(frames)], number * step / rate
        for search in hints.update(observer.look(frame, stamp)):
            search()
        if hints.warning and hints.warning not in said:
            said.append(hints.warning)
    return said


def as_it_is(frame):
    return frame


@pytest.mark.clips
@pytest.mark.parametrize('any_ids', [False, True], ids=['four ids', 'any ids'])
@pytest.mark.parametrize('name', ['board.mp4', 'dark.mp4', 'pushed.mp4', 'turned.avi'])
def test_nothing_is_said_where_the_parameters_are_right(name, any_ids):
    assert shown(name, as_it_is, any_ids=any_ids) == []


def mirrored(frame):
    return frame[:, ::-1]


@pytest.mark.clips
@pytest.mark.parametrize('name, change, dictionary, any_ids, part', [
    ('board.mp4', as_it_is, 'DICT_4X4_1000', True, 'Give dictionary:=DICT_5X5_50.'),
    ('dark.mp4', as_it_is, 'DICT_6X6_250', True, 'Give dictionary:=DICT_4X4_50.'),
    ('pushed.mp4', as_it_is, 'DICT_4X4_1000', True, 'Give dictionary:=DICT_ARUCO_ORIGINAL.'),
    ('turned.avi', as_it_is, 'DICT_5X5_1000', True, 'Give dictionary:=DICT_4X4_50.'),
    ('dark.mp4', mirrored, None, True, 'turn off this mirroring.'),
    ('pushed.mp4', mirrored, None, False, 'turn off this mirroring.')],
    ids=['board', 'dark', 'pushed', 'turned', 'mirrored', 'mirrored, of which all tags are others'])
def test_one_wrong_parameter_gives_the_one_true_hint(name, change, dictionary, any_ids, part):
    said = shown(name, change, LONG_S, dictionary, any_ids)
    assert said and all(sentence.endswith(part) for sentence in said)
