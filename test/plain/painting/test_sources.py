"""Pictures that move: what is shown at which time, and what happens if a file ends or breaks."""
import os

import cv2
import numpy as np
import pytest
from aruco_ar import InputError
from aruco_ar.painting import sources
from aruco_ar.painting.sources import open_source
from PIL import Image

RED, GREEN, BLUE = (0, 0, 255), (0, 255, 0), (255, 0, 0)


@pytest.fixture(autouse=True)
def in_time(monkeypatch):
    """Clips are decoded fast enough, however busy this machine is."""
    monkeypatch.setattr(sources, 'MAX_CATCH_UP_S', float('inf'))


def gif(path, colors, seconds, mode='RGB'):
    frames = [Image.new(mode, (64, 48), color[::-1] if mode == 'RGB' else color) for color in colors]
    frames[0].save(str(path), save_all=True, append_images=frames[1:], loop=0, disposal=2,
                   duration=[round(1000 * each) for each in seconds])
    return str(path)


def video(path, grays, fps, fourcc='MJPG', side=64):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*fourcc), fps, (side, side))
    for gray in grays:
        writer.write(np.full((side, side, 3), gray, np.uint8))
    writer.release()
    return str(path)


def colors_at(source, stamps):
    """The colors in the middle of the picture at those times."""
    return [tuple(int(value) for value in source.at(stamp)[24, 32, :3]) for stamp in stamps]


def test_a_still_picture_does_not_change(package):
    earth = open_source(package + '/images/earth.jpg')
    assert earth.at(0.0) is earth.at(1e9) and earth.at(0.0).shape == (640, 960, 3)


def test_a_gif_plays_at_its_own_rate_in_a_loop(tmp_path):
    clip = open_source(gif(tmp_path / 'a.gif', [RED, GREEN, BLUE], [0.1, 0.3, 0.6]))
    stamps = [100.0, 100.09, 100.11, 100.39, 100.41, 100.99, 101.01, 101.11]
    assert colors_at(clip, stamps) == [RED, RED, GREEN, GREEN, BLUE, BLUE, RED, GREEN]


@pytest.mark.parametrize('name, fourcc', [('a.avi', 'MJPG'), ('a.mp4', 'mp4v')])
def test_a_video_plays_at_its_own_rate_in_a_loop(tmp_path, name, fourcc):
    clip = open_source(video(tmp_path / name, range(0, 250, 25), 10, fourcc))
    for number in range(25):  # the camera's rate is not the video's
        gray = np.mean(colors_at(clip, [5.0 + number * 0.13])[0])
        assert abs(gray - 25 * (int(number * 1.3 + 1e-6) % 10)) < 9, number


def test_a_clip_that_is_decoded_too_slowly_plays_more_slowly(tmp_path, monkeypatch):
    clip = open_source(gif(tmp_path / 'a.gif', [RED, GREEN, BLUE], [0.1, 0.1, 0.1]))
    monkeypatch.setattr(sources, 'MAX_CATCH_UP_S', -1.0)
    assert colors_at(clip, [0.0, 0.25, 0.34, 0.36]) == [RED, GREEN, GREEN, BLUE]


def test_a_clip_continues_where_it_was_if_the_time_jumps(tmp_path):
    clip = open_source(gif(tmp_path / 'a.gif', [RED, GREEN, BLUE], [1, 1, 1]))
    assert colors_at(clip, [0.0, 0.5, 1.2]) == [RED, RED, GREEN]
    assert colors_at(clip, [5000.0, 5000.7, 5000.9]) == [GREEN, GREEN, BLUE]   # after a long pause
    assert colors_at(clip, [3.0, 3.8, 4.0]) == [BLUE, BLUE, RED]               # a bag starts again


def test_a_transparent_gif_stays_transparent(tmp_path):
    frames = [Image.new('RGBA', (64, 48), (255, 0, 0, 0)), Image.new('RGBA', (64, 48), (0, 255, 0, 255))]
    for frame in frames:
        frame.paste((0, 0, 255, 255), (0, 0, 20, 20))
    path = str(tmp_path / 'a.gif')
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=100, disposal=2)
    picture = open_source(path).at(0)
    assert picture.shape == (48, 64, 4)
    assert picture[40, 50, 3] == 0 and picture[5, 5].tolist() == [255, 0, 0, 255]


def test_a_clip_that_is_too_large_is_shrunk(tmp_path):
    frames = [Image.new('P', (5000, 10), color) for color in (1, 2)]
    frames[0].save(str(tmp_path / 'a.gif'), save_all=True, append_images=frames[1:])
    assert open_source(str(tmp_path / 'a.gif')).at(0).shape[:2] == (8, 4096)


def test_if_a_file_is_deleted_its_last_picture_stays(tmp_path):
    sentences = []
    path = video(tmp_path / 'a.avi', [0, 200], 10)
    clip = open_source(path, sentences.append)
    assert [np.mean(color) > 100 for color in colors_at(clip, [0.0, 0.1])] == [False, True]
    os.remove(path)
    assert [np.mean(color) > 100 for color in colors_at(clip, [0.2, 0.3, 1.0, 900.0, 901.0])] == [True] * 5
    assert len(sentences) == 1 and path in sentences[0] and 'last picture stays' in sentences[0]


def test_a_truncated_file_plays_as_far_as_possible(tmp_path):
    for path in (gif(tmp_path / 'a.gif', [RED, GREEN, BLUE, RED, GREEN], [0.1] * 5),
                 video(tmp_path / 'a.avi', range(0, 250, 25), 10, side=640)):
        with open(path, 'r+b') as file:
            file.truncate(os.path.getsize(path) * 2 // 3)
        clip = open_source(path)
        assert len({tuple(color) for color in colors_at(clip, np.arange(0, 3, 0.05))}) >= 2


@pytest.mark.parametrize('data', [b'', b'no video', b'GIF89a', b'RIFF\x00\x00\x00\x00AVI LIST'])
def test_a_file_that_is_neither_picture_nor_video_is_named(tmp_path, data):
    path = tmp_path / 'what.mp4'
    path.write_bytes(data)
    with pytest.raises(InputError, match='cannot be read as a picture|as a video') as error:
        open_source(str(path))
    assert str(path) in str(error.value)
    with pytest.raises(InputError, match='is not a file'):
        open_source(str(tmp_path))
