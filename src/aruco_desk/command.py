"""The command line: aruco-ar."""
from __future__ import annotations

import aruco_program  # noqa: F401  isort: skip  it prepares NumPy and OpenCV, so it comes first

import argparse
import os
import runpy
import sys
from functools import partial
from typing import Callable, Sequence

from aruco_ar.base.errors import MAX_SENTENCE, InputError, shorten
from aruco_ar.base.files import in_package, path_of
from aruco_ar.hints.which_dictionary import dictionary_in
from aruco_ar.settings.settings import LEARN, PictureSettings

from .footage import Footage, filmed
from .options import add_settings, settings_of
from .paint import own_name, paint

DESCRIPTION = ('Paint pictures and videos between four ArUco tags on a wall, so that they look nailed to it. '
               'First print the tags, and put them up: aruco-ar tags. Then film them: aruco-ar paint clip.mp4 '
               '--picture cat.png')
SHEET = 'wall.pdf'
PORT = 8080
STILLS = 6  # number of frames by which the dictionary of the tags is found
RIGHT, WRONG, USAGE = 0, 1, 2


def main(argv: Sequence[str] | None = None) -> int:
    """Do what the command line says. Returns 0, 1 if the picture is in no frame, or 2 if it cannot be done."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    parser = argparse.ArgumentParser(prog='aruco-ar', description=DESCRIPTION)
    commands = parser.add_subparsers(metavar='COMMAND', dest='command', required=True)
    painting = commands.add_parser('paint', help='paint a picture into a video, a photo, or what a camera sees')
    _add_paint(painting)
    for name, (_, text) in OTHERS.items():
        commands.add_parser(name, help=text, add_help=False)
    try:
        if arguments[:1] and arguments[0] in OTHERS:  # they have command lines of their own
            return OTHERS[arguments[0]][0](arguments[1:])
        return _paint(parser.parse_args(arguments))
    except InputError as error:
        print('aruco-ar: %s' % error, file=sys.stderr)
        return USAGE
    except KeyboardInterrupt:
        return 130


def _add_paint(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument('file', nargs='?', metavar='FILE', help='a video or a photo')
    source.add_argument('--camera', metavar='N', help='a webcam by its number, or the address of a camera; '
                                                      'without --out, it is shown live on a page')
    source.add_argument('--phone', action='store_true', help='the camera of the phone that opens the page')
    parser.add_argument('--out', metavar='FILE', help='the file to write: an MP4, or for a photo a PNG or JPEG '
                                                      '(default: NAME-painted, in this folder)')
    parser.add_argument('--port', type=_port, default=PORT, metavar='N',
                        help='of the page (default: %d)' % PORT)
    parser.add_argument('--calibration', metavar='FILE.yaml',
                        help='the calibration of the camera that filmed it: see aruco-ar calibrate')
    add_settings(parser, PictureSettings, {
        'dictionary': 'that of most tags in sight'})


def _port(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 65535:
        raise argparse.ArgumentTypeError('it is a number from 1 to 65535')
    return int(text)


def _paint(options: argparse.Namespace) -> int:
    for name in 'picture', 'wall':  # to a node, a relative path is one within the package
        if getattr(options, name) not in (None, LEARN):
            setattr(options, name, os.path.abspath(path_of(getattr(options, name))))
    if options.file is None and options.out is None:
        return _show(options)
    if options.phone:
        raise InputError('What a phone films is shown live on the page. Leave out --out.')
    footage = Footage.of_camera(options.camera) if options.file is None else Footage.of_file(options.file)
    if options.dictionary is None:
        options.dictionary = dictionary_in(footage.stills(STILLS), PictureSettings.dictionary)
        if options.file is not None:
            footage = Footage.of_file(options.file)
    settings = settings_of(options, PictureSettings)
    out = options.out or own_name(options.file or 'camera', footage.is_photo)
    if options.file is not None and os.path.exists(out) and os.path.samefile(out, options.file):
        raise InputError('"%s" would replace what is painted on. Give another --out.' % out)
    painted = paint(footage, settings, out, options.calibration)
    print(shorten('Wrote %s: the picture is in %d of %d frames, between tags of %s.' % (
        out, painted.shown, painted.frames, settings.dictionary), MAX_SENTENCE))
    if not painted.shown:
        print('aruco-ar: ' + painted.why_not, file=sys.stderr)
    return RIGHT if painted.shown else WRONG


def _show(options: argparse.Namespace) -> int:
    """Paint live, on a page in the browser, until Ctrl-C."""
    settings = settings_of(options, PictureSettings)
    from .page import serve
    from .phone import Phone
    from .studio import Studio
    phone = Phone() if options.phone else None
    film = partial(filmed, options.camera) if phone is None else lambda: phone
    serve(partial(Studio, film, settings, options.dictionary is not None, options.calibration), options.port,
          phone)
    return RIGHT


def _tags(arguments: list[str]) -> int:
    generator = runpy.run_path(in_package(os.path.join('src', 'artag_generator.py')))
    from aruco_program.tag_command import run
    run(generator['draw_tags'], generator['__doc__'], arguments or ['--sheet', SHEET, '--around-picture'],
        'aruco-ar tags')
    return RIGHT


def _calibrate(arguments: list[str]) -> int:
    from aruco_program.calibrate_command import main as calibrate
    calibrate(arguments, 'aruco-ar calibrate')
    return RIGHT


def _learn(arguments: list[str]) -> int:
    from aruco_course.command import main as learn
    return learn(arguments, 'aruco-ar learn')


OTHERS: dict[str, tuple[Callable[[list[str]], int], str]] = {
    'tags': (_tags, 'make tags to print: by default %s, one page to put up as it is' % SHEET),
    'calibrate': (_calibrate, 'calibrate a camera from a video or photos of a sheet of tags'),
    'learn': (_learn, 'write the exercises yourself, and be told whether they are right')}
