"""The output of a bag in a folder: which of it is done, and putting it together from its pieces."""
import fcntl
import hashlib
import json
import os
import shutil
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Dict

import cv2
from aruco_ar.base.drafts import drafted
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import in_package
from aruco_ar.exercise import PICTURE
from aruco_ar.painting.video_writer import need_video

from .bag_reader import pieces_of
from .mcap_bag import MCAP_SUFFIX, join_mcaps, need_mcap
from .pieces import join_bags, join_tables, make_video
from .task import COLUMNS, annotate

HIDDEN = '.unit5'      # subfolder of the output folder: drafts, and notes on what is done
LOCK = '.lock'         # no bag can have this name
TABLE = 'tags.csv'
DONE = 'done.json'     # the files that are done, {name: size in bytes}
PACKAGES = Path(__file__).resolve().parent.parent
PARTS, CODE = ('aruco_ar', 'aruco_bags', 'aruco_node'), ('.py', '.c', '.h')


class Job:
    """A bag to process, and its output files in a folder.

    If the bag, the Task, the options or the code change, the notes of the Job get another folder, so it is done
    again.
    """

    def __init__(self, path, task, folder, video, mcap, seconds):
        """``video``: whether to write MP4s. ``mcap``: whether to write MCAP even if the bag is a usual one."""
        self.path, self._task, self._folder, self._video = path, task, folder, video
        self._seconds = seconds
        self.name, suffix = os.path.splitext(os.path.basename(path))
        self.is_mcap = mcap or suffix == MCAP_SUFFIX
        self.bag = os.path.join(folder, self.name + (MCAP_SUFFIX if self.is_mcap else '.bag'))
        wanted = [task.exercise.name, repr(task.settings), video, self.is_mcap, seconds, *_state(path),
                  _state_of_code(task)]
        if PICTURE in task.exercise.needs:
            wanted += _state(in_package(task.settings.picture))
        digest = hashlib.sha256(json.dumps(wanted).encode()).hexdigest()[:12]
        self._hidden = os.path.join(folder, HIDDEN, self.name, digest)
        self._drafts = os.path.join(self._hidden, 'drafts')

    def is_done(self):
        """Whether all output files exist, made from the bag as it is now, with the same Task and options."""
        return _is_whole(self._hidden, self._folder)

    def pieces(self):
        """The Pieces of the bag, and sentences: see pieces_of."""
        return pieces_of(self.path, self._seconds)

    def annotate(self, piece):
        """Process a Piece: see annotate in task.py."""
        return annotate(piece, self._task, self._folder_of(piece))

    def join(self, pieces):
        """Join the output of all Pieces to the output files. Raises InputError if a video cannot be written."""
        self._forget_others()
        pieces = sorted(pieces, key=lambda piece: (piece.number, piece.topic))
        parts = [os.path.join(self._folder_of(piece), '%06d' % piece.number) for piece in pieces]
        with drafted(self.bag, self._drafts) as draft:
            (join_mcaps if self.is_mcap else join_bags)([part + '.bag' for part in parts], draft)
        made = [self.bag]
        cameras = sorted({piece.camera for piece in pieces})
        for camera in cameras if self._video else []:
            name = self.name + ('' if len(cameras) == 1 else camera.replace('/', '.')) + '.mp4'
            exercise = self._task.exercise
            topic = '/%s/%s%s/compressed' % (exercise.name, exercise.topics[-1], camera)
            with drafted(os.path.join(self._folder, name), self._drafts) as draft:
                if make_video(self.bag, topic, draft, name):
                    made.append(os.path.join(self._folder, name))
        with drafted(os.path.join(self._hidden, TABLE), self._drafts) as draft:
            join_tables([part + '.csv' for part in parts], draft)
        with drafted(os.path.join(self._hidden, DONE), self._drafts) as draft, open(draft, 'w') as file:
            json.dump({os.path.basename(path): os.path.getsize(path) for path in made}, file)
        shutil.rmtree(self._drafts)

    def _forget_others(self):
        """Remove the notes on output of this bag with other options, since its files are replaced now."""
        others, own = os.path.split(self._hidden)
        for other in os.scandir(others):
            if other.is_dir() and other.name != own:
                shutil.rmtree(other.path)

    def _folder_of(self, piece):
        return os.path.join(self._drafts, hashlib.sha256(piece.topic.encode()).hexdigest()[:12])


def jobs_of(paths, task, folder, video, mcap, seconds):
    """Jobs for the bags with these paths, with all output in one folder.

    ``video``, ``mcap``: see Job. ``seconds``: the length of a piece. Raises InputError if two output files
    would have the same name, if one would replace a bag, or if MP4s or MCAP files cannot be written.
    """
    if video:
        need_video('leave out --video')
    folder = os.path.realpath(folder)
    names: Dict[str, str] = {}
    for path in map(os.path.realpath, paths):
        name = os.path.splitext(os.path.basename(path))[0]
        if names.setdefault(name, path) != path:
            raise InputError('The output of "%s" and of "%s" would have the same name. Run the command for '
                             'each of them, with its own --out.' % (names[name], path))
        if os.path.dirname(path) == folder:
            raise InputError('The bag "%s" is in the output folder. Give another --out.' % path)
    jobs = [Job(path, task, folder, video, mcap, seconds) for path in names.values()]
    given = ['--mcap'] * mcap + ['the MCAP files'] * any(path.endswith(MCAP_SUFFIX) for path in names.values())
    if given:
        need_mcap('leave out ' + ' and '.join(given))
    return jobs


@contextmanager
def locked(folder):
    """A context manager that makes a folder if it does not exist, and locks it against other processes.

    Raises InputError if the folder cannot be written, or if another process has locked it.
    """
    with ExitStack() as stack:
        try:
            os.makedirs(os.path.join(folder, HIDDEN), exist_ok=True)
            lock = stack.enter_context(open(os.path.join(folder, HIDDEN, LOCK), 'w'))
        except OSError as error:
            raise InputError('The folder "%s" cannot be written: %s. Give another --out.'
                             % (folder, error.strerror)) from None
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError('Another annotate_bags works in the folder "%s". Wait for it, or give another '
                             '--out.' % folder) from None
        for left in os.scandir(os.path.join(folder, HIDDEN)):
            if left.name != LOCK and left.is_file():  # a draft of a process that was killed
                os.unlink(left.path)
        yield


def write_table(folder):
    """Write the table of all bags whose output is in a folder. Raises InputError if it cannot be written."""
    hidden = os.path.join(folder, HIDDEN)
    made = [str(note.parent) for note in sorted(Path(hidden).glob('*/*/' + DONE))]
    try:
        with drafted(os.path.join(folder, TABLE), hidden) as draft:
            join_tables([os.path.join(each, TABLE) for each in made if _is_whole(each, folder)], draft, COLUMNS)
    except OSError as error:
        raise InputError('%s cannot be written: %s. Give another --out.' % (TABLE, error.strerror)) from None


def _is_whole(hidden, folder):
    """Whether all files that are noted as done exist, with the size that was noted."""
    try:
        with open(os.path.join(hidden, DONE)) as file:
            return all(os.path.getsize(os.path.join(folder, name)) == size
                       for name, size in json.load(file).items())
    except (FileNotFoundError, ValueError):  # a note may be empty after a loss of power
        return False


def _state_of_code(task):
    """A text that changes with the code: this package's, that beside the exercise's file, and OpenCV's."""
    files = [path for part in PARTS for path in PACKAGES.joinpath(part).glob('**/*') if path.suffix in CODE]
    return _digest(*sorted(files), *sorted(Path(task.folder).glob('*.py'))) + cv2.__version__


@lru_cache(None)
def _digest(*paths):
    """The digest of the contents of files, which are read once."""
    whole = hashlib.sha256()
    for path in paths:
        whole.update(hashlib.sha256(path.read_bytes()).digest())
    return whole.hexdigest()


def _state(path):
    """Size and time of a file, which show whether it has changed."""
    if not os.path.exists(path):  # an error is raised when it is read
        return []
    return [os.stat(path).st_size, os.stat(path).st_mtime_ns]
