"""Paints a picture into footage, as the node exercise5_6 does."""
from __future__ import annotations

import os
import runpy
from contextlib import contextmanager
from typing import Callable, Iterator, NamedTuple

import cv2
from aruco_ar.base.arrays import Image
from aruco_ar.base.drafts import drafted
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import in_package, write_whole
from aruco_ar.base.progress import progress
from aruco_ar.calibration.camera_file import read_camera
from aruco_ar.exercise import Exercise
from aruco_ar.hints.other_tags import OtherTags, Words
from aruco_ar.painting.sources import open_source
from aruco_ar.painting.video_writer import need_video, video_writer
from aruco_ar.runner import Runner
from aruco_ar.settings.settings import PictureSettings

from .footage import Footage
from .options import with_options

PHOTO, VIDEO = '.png', '.mp4'  # what the result is called if its name is not given
LOOKS = 5                      # in so many frames without tags, other tags are looked for
WORDS = Words('aruco-ar', '--dictionary %s', '--border %d')


class Painted(NamedTuple):
    """``frames``: how many there were. ``shown``: in how many the picture is. ``why_not``: if it is in none."""

    frames: int
    shown: int
    why_not: str


def exercise(number: str) -> Exercise:
    """The Exercise of a number, such as 5.6, that its file declares."""
    path = in_package(os.path.join('src', 'exercise%s.py' % number.replace('.', '_')))
    found: Exercise = runpy.run_path(path, run_name='exercise')['EXERCISE']
    return found


def own_name(path: str, is_photo: bool) -> str:
    """What the result is called if nothing else is asked for: clip-painted.mp4, in the current folder."""
    return os.path.splitext(os.path.basename(path))[0] + '-painted' + (PHOTO if is_photo else VIDEO)


def paint(footage: Footage, settings: PictureSettings, out: str, calibration: str | None = None) -> Painted:
    """Paint a picture into each frame, and write them to a file. It appears only when it is complete.

    ``out``: the path of an MP4, or of a photo if the footage is one. ``calibration``: the path of a YAML file;
    see read_camera. Ctrl-C ends it earlier, with the frames until then. Raises InputError if a file cannot be
    read or written, or if there are no frames.
    """
    runner = Runner(exercise('5.6'), [settings], lambda picture: open_source(in_package(picture)))
    others = OtherTags(settings.dictionary, settings.ids, settings.border, WORDS)
    lens, frames, shown, looks, shortfall = None, 0, 0, 0, None
    with _writer(out, footage) as write:
        try:
            for stamp, frame in progress(footage, os.path.basename(out)):
                if calibration is not None and lens is None:
                    lens = read_camera(calibration, (frame.shape[1], frame.shape[0]))
                is_blank = looks < LOOKS and not shown
                sight, images = runner.run(frame, stamp, lens, keeps_frame=is_blank)
                seen = sight.areas[0]
                if is_blank and not seen.tags:
                    others.look_at(frame)
                    looks += 1
                write(images[-1])
                frames, shown = frames + 1, shown + (seen.area is not None)
                shortfall = seen.shortfall or shortfall
        except KeyboardInterrupt:
            if not frames:
                raise
    return Painted(frames, shown, with_options(shortfall or others.hint or (
        'No tag of %s was seen. Print some: aruco-ar tags. Or name the dictionary of yours: --dictionary NAME.'
        % settings.dictionary)))


@contextmanager
def _writer(out: str, footage: Footage) -> Iterator[Callable[[Image], None]]:
    """A function that writes a frame, for a ``with`` block."""
    if footage.is_photo:
        def write_photo(frame: Image) -> None:
            try:
                _, data = cv2.imencode(os.path.splitext(out)[1], frame)
            except cv2.error:
                raise InputError('A photo cannot be written to "%s". Name a file such as painted.png.'
                                 % out) from None
            write_whole(out, data.tobytes())
        yield write_photo
        return
    if os.path.splitext(out)[1].lower() != VIDEO:
        raise InputError('A video is written as MP4. Name a file such as painted.mp4, not "%s".' % out)
    need_video('give a photo in place of a video')
    folder = os.path.dirname(os.path.abspath(out))
    with drafted(out, folder) as draft, video_writer(draft, footage.rate, out) as write:
        yield write
