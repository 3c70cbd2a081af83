"""Calibrate a camera from a video or photos of a flat sheet of tags.

This program needs no roscore. Move the sheet, or the camera in front of it, so that
the tags are seen in all parts of the frame, near and far, and tilted. All tags
have the same size; where they are on the sheet need not be known. The result is
a YAML file as camera_info_manager reads it, for example by
roslaunch unit5 video_camera.launch info:=file:///full/path/of/camera.yaml
"""
import argparse
import os
import sys

import cv2
import PIL.Image
from aruco_ar import InputError
from aruco_ar.base.files import opened, write_whole
from aruco_ar.base.progress import progress
from aruco_ar.calibration.calibrate import calibrate
from aruco_ar.calibration.camera_file import camera_yaml
from aruco_ar.calibration.sheets import CharucoBoard, TagSheet, read_board
from aruco_ar.calibration.views import is_spread
from aruco_ar.hints.other_tags import OtherTags, Words
from aruco_ar.painting.picture_file import ORIENTATION
from aruco_ar.tags.tag import DICTIONARY_NAMES

CALLED = 'calibrate_camera.py'
MAX_FRAMES = 400   # of a video, evenly chosen
STILLS = 5         # number of frames, evenly chosen, in which tags are looked for that are not the sheet's
WORDS = Words('calibrate_camera', '--dictionary %s', None)
OTHER_SHEET = 'Is it the right dictionary (--dictionary NAME)? Are the tags large and sharp, and not mirrored?'
OTHER_BOARD = ('Are the dictionary (--dictionary NAME) and the squares right, those across first (--charuco '
               '6x8 is another board than 8x6)? Is the board sharp, and not mirrored?')


def board(text):
    """What read_board takes, for argparse."""
    try:
        return read_board(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            '"%s" is no board; write its squares and the side of a marker as a share of a square\'s, such as '
            '5x7:0.75' % text) from None


def parse(argv, called):
    parser = argparse.ArgumentParser(
        prog=called, description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog='dictionaries:\n  ' + '\n  '.join(DICTIONARY_NAMES))
    option = parser.add_argument
    option('files', nargs='+', metavar='FILE', help='a video or photos, all of the same size')
    option('--out', metavar='FILE', default='camera.yaml', help='the YAML file to write (default: camera.yaml)')
    option('--dictionary', default='DICT_6X6_250', help='one of those below (default: DICT_6X6_250)')
    option('--charuco', type=board, metavar='5x7:0.75',
           help="the sheet is a ChArUco board: its squares across and down, and after the colon the side of a "
                "marker, as a share of a square's")
    option('--fisheye', action='store_true', help='the lens is a fisheye')
    option('--name', default='camera', help='the name of the camera in the YAML file (default: camera)')
    return parser.parse_args(argv)


class FrameFile:
    """The frames of a video or a photo; of a long video, MAX_FRAMES evenly chosen ones.

    They are as the camera stored them, so that one lens fits those of a phone that was held upright or not.
    ``is_turned``: whether the file asks programs to turn them.
    """

    def __init__(self, path):
        """Raises InputError if there is no such file, or if it may not be read."""
        if os.path.isdir(path):
            raise InputError('"%s" is a folder. Give the video or the photos in it: %s.'
                             % (path, os.path.join(path, '*')))
        if not os.path.exists(path):
            raise InputError('There is no file "%s".' % path)
        with opened(path):
            pass
        self._path, self._photo = path, cv2.imread(path, cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
        self._video, count = None, 1
        if self._photo is None:
            self._video = cv2.VideoCapture(path)
            self._video.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
            count = int(self._video.get(cv2.CAP_PROP_FRAME_COUNT))
        self.is_turned = _is_turned_photo(path) if self._video is None else \
            self._video.get(cv2.CAP_PROP_ORIENTATION_META) % 360 != 0
        self._step = max(1, -(-count // MAX_FRAMES))  # rounded up
        self._count = -(-count // self._step)

    def __length_hint__(self):
        return max(self._count, 0)

    def __iter__(self):
        """Yield (h, w, 3) BGR uint8. Raises InputError if there is none."""
        if self._photo is not None:
            yield self._photo
            return
        number, found = 0, False
        while self._video.grab():
            if number % self._step == 0:
                is_read, frame = self._video.retrieve()
                if is_read:
                    found = True
                    yield frame
            number += 1
        if not found:
            raise InputError('The file "%s" is neither a video nor a photo that OpenCV can read.' % self._path)


def _is_turned_photo(path):
    try:
        with PIL.Image.open(path) as photo:
            return photo.getexif().get(ORIENTATION, 1) != 1
    except Exception:  # Pillow raises many kinds, also for formats that only OpenCV reads
        return False


def look(files, sheet):
    """((width, height), [View of each frame], [paths of files that ask to be turned]). Raises InputError."""
    size, views, turned = None, [], []
    for path in files:
        file = FrameFile(path)
        turned += [path] * file.is_turned
        for frame in progress(file, os.path.basename(path)):
            if size not in (None, frame.shape[1::-1]):
                raise InputError(
                    '"%s" has frames of %d x %d pixels, and those before it have %d x %d. Give files of one '
                    'camera at one size%s.' % (path, *frame.shape[1::-1], *size, (
                        ', as the camera made them: a program has turned some of these'
                        if frame.shape[:2] == size else '')))
            size = frame.shape[1::-1]
            views.append(sheet.view(frame))
    return size, views, turned


def hint_at_other_tags(files, count, dictionary):
    """A sentence about tags of another kind in some of the ``count`` frames of the files, or None."""
    chosen = {(2 * number + 1) * count // (2 * STILLS) for number in range(STILLS)}
    others = OtherTags(dictionary, (), words=WORDS)
    for number, frame in enumerate(frame for path in files for frame in FrameFile(path)):
        if number in chosen:
            others.look_at(frame)
    return others.hint


def main(argv, called=CALLED):
    """Do what the command line says, or end with a sentence. ``called``: how this program is started."""
    args = parse(argv, called)
    try:
        sheet = CharucoBoard(args.dictionary, *args.charuco) if args.charuco else TagSheet(args.dictionary)
        size, views, turned = look(args.files, sheet)
        if not any(is_spread(view, sheet.points) for view in views):
            of_others = None if any(view.points for view in views) else \
                hint_at_other_tags(args.files, len(views), args.dictionary)
            raise InputError('None of %d frames shows %s. %s' % (
                len(views), sheet.needs, of_others or (OTHER_BOARD if args.charuco else OTHER_SHEET)))
        print('%d frames of %d x %d pixels' % (len(views), *size))
        if turned:
            print('%d of the files, such as "%s", ask to be turned when they are shown. They are used as the '
                  'camera stored them, and the lens is for frames as stored' % (len(turned), turned[0]))
        found = calibrate(views, size, args.fisheye, sheet.points)
        write_whole(args.out, camera_yaml(found.lens, args.name).encode())
    except InputError as error:
        sys.exit('%s: %s' % (os.path.splitext(called)[0], error))
    matrix = found.lens.matrix
    print('focal length  %.1f, %.1f px' % (matrix[0, 0], matrix[1, 1]))
    print('center        %.1f, %.1f px' % (matrix[0, 2], matrix[1, 2]))
    print('distortion    %s' % ' '.join('%.4f' % value for value in found.lens.distortion))
    print('error         %.2f px in %d views; %.2f px in views that were held out'
          % (found.rms, found.views, found.held_out))
    print('coverage      %.0f %% of the frame' % (100 * found.coverage))
    print('corners       ' + ('within %.2f px, by lenses from two halves of the views' % found.corners
                              if found.corners < size[0] else 'not known: the views do not tell it'))
    if found.lacks():
        print(found.lacks())
    print('Wrote %s' % args.out)
