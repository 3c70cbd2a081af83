"""Runs an exercise on the frames of a piece of a bag."""
import csv
import os
from dataclasses import dataclass
from typing import Any, Dict

import cv2
import numpy as np
import rosbag
from aruco_ar import InputError, PoseEstimator, find_area
from aruco_ar.base.drafts import drafted
from aruco_ar.base.files import in_package
from aruco_ar.exercise import AREA, PICTURE, Exercise
from aruco_ar.painting.sources import Still, open_source
from aruco_ar.runner import Runner
from aruco_node.messages.annotations import annotations
from aruco_node.messages.camera_info import info_of_frames, lens_from_info
from aruco_node.messages.images import compressed_from_frame, tags_from_pixels
from aruco_node.messages.pose_messages import quaternion
from aruco_node.messages.topics import raw_topic
from aruco_node.nodes.camera_lens import is_rectified
from aruco_node.parameters.settings import TOPIC
from aruco_node.process.memory import keep_memory
from sensor_msgs.msg import CameraInfo

from .bag_reader import decoder_of, messages

CORNERS = [(number, axis) for number in range(4) for axis in 'xy']
COLUMNS = ['bag', 'topic', 'stamp', 'id', 'confidence', *('corner%d_%s' % corner for corner in CORNERS),
           'center_x', 'center_y', 'x', 'y', 'z', 'qx', 'qy', 'qz', 'qw',
           *('area%d_%s' % corner for corner in CORNERS)]


@dataclass(frozen=True)
class Task:
    """What to do with each bag: an Exercise of aruco_ar, BagSettings for it, and the folder of its file."""

    exercise: Exercise
    settings: Any
    folder: str


def check_picture(task):
    """Raises InputError if the picture of a Task cannot be painted into bags."""
    if PICTURE in task.exercise.needs:
        given = task.settings.picture
        if given.startswith(TOPIC) or not isinstance(open_source(in_package(given)), Still):
            raise InputError('The parameter ~picture is "%s", but only still pictures can be painted into '
                             'bags. Give a JPEG or PNG.' % given)


def annotate(piece, task, folder):
    """Run a Task on a Piece, and write NUMBER.bag and NUMBER.csv into a folder, unless they exist.

    Returns how many frames were processed, and a list of sentences about problems.
    """
    cv2.setNumThreads(1)  # the other cores work on other pieces
    keep_memory()  # Dask has its processes return every block to the kernel at once
    path = os.path.join(folder, '%06d' % piece.number)
    if os.path.exists(path + '.csv'):
        return 0, []
    os.makedirs(folder, exist_ok=True)
    with drafted(path + '.csv', folder) as table, drafted(path + '.bag', folder) as bag, \
            open(table, 'w', newline='') as rows, rosbag.Bag(bag, 'w') as output:
        return _Annotator(piece, task, csv.writer(rows), output).run()


class _Annotator:
    """Processes the frames of one Piece in order."""

    def __init__(self, piece, task, rows, output):
        exercise, settings = task.exercise, task.settings
        self._piece, self._exercise, self._rows, self._output = piece, exercise, rows, output
        self._runner = Runner(exercise, [settings], lambda picture: open_source(in_package(picture)))
        self._estimator = PoseEstimator(settings.tag_size, dict(settings.tag_sizes))
        self._rectified = is_rectified(settings, raw_topic(piece.topic))
        self._info = self._lens = self._size = None
        self._faults = {}  # {kind: sentence}

    def run(self):
        """Process all frames. Returns how many, and a list of sentences about problems."""
        decode, frames = decoder_of(self._piece), 0
        for message, time, is_in_piece in messages(self._piece):
            if message._type == CameraInfo._type:
                message.header = None  # the stamp would make every message look like a new calibration
                if message != self._info:
                    self._info, self._size = message, None
                continue
            try:
                frame = decode(message)
            except InputError as error:
                self._faults.setdefault(
                    error.kind, 'frames on %s are skipped: %s' % (self._piece.topic, error))
                continue
            for kind, note in decode.notes.items():
                self._faults.setdefault(kind, '%s: %s' % (self._piece.topic, note))
            stamp = message.header.stamp or time
            found = self._process(frame, stamp.to_sec())
            if is_in_piece:
                self._write(message.header, time, stamp, *found)
                frames += 1
        return frames, list(self._faults.values())

    def _update_lens(self, size):
        """Make the lens for frames of this size, (width, height) pixels, if the calibration is known."""
        if self._info is None or size == self._size:
            return
        self._lens, self._size = None, size
        notes: Dict[str, str] = {}
        try:
            self._lens = lens_from_info(self._info, size, self._rectified, notes=notes)
        except InputError as error:
            self._faults.setdefault(
                error.kind, 'there are no poses for %s, since its camera_info cannot be used: %s'
                % (self._piece.topic, error))
        for kind, note in notes.items():
            self._faults.setdefault(kind, 'the camera_info of %s: %s' % (self._piece.topic, note))

    def _process(self, frame, stamp):
        """(images, tags, {id: TagPose}, area) of a frame."""
        self._update_lens(frame.shape[1::-1])
        sight, images = self._runner.run(frame, stamp, self._lens)
        area = sight.areas[0].area if AREA in self._exercise.needs else find_area(sight.tags)
        poses = {}
        if self._lens is not None:
            poses = {pose.id: pose for pose in self._estimator.update(sight.tags, self._lens, stamp)}
        return images, sight.tags, poses, area

    def _write(self, header, time, stamp, images, tags, poses, area):
        for topic, image in zip(self._exercise.topics, images):
            self._output.write('/%s/%s%s/compressed' % (self._exercise.name, topic, self._piece.camera),
                               compressed_from_frame(image, header), time)
        tracked = [area] if area is not None and AREA in self._exercise.needs else []
        beside = {'tags': tags_from_pixels(tags, header),
                  'annotations': annotations(tags, tracked, header.stamp)}
        if self._lens is not None:
            beside['camera_info'] = info_of_frames(self._info, images[0].shape[1::-1], header)
        for topic, message in beside.items():
            self._output.write('/%s/%s%s' % (self._exercise.name, topic, self._piece.camera), message, time)
        place = [''] * len(CORNERS) if area is None else _pixels(area.corners)
        name = os.path.basename(self._piece.bag)
        for tag in tags:
            self._rows.writerow([
                name, self._piece.topic, '%d.%09d' % (stamp.secs, stamp.nsecs), tag.id, '%.3f' % tag.confidence,
                *_pixels(tag.corners), *_pixels(tag.center), *_numbers(poses.get(tag.id)), *place])


def _pixels(values):
    """Pixels, an array, as texts."""
    return ['%.3f' % number for number in np.ravel(values).tolist()]


def _numbers(pose):
    """Position and orientation of a TagPose as 7 texts, which are empty for None."""
    if pose is None:
        return [''] * 7
    turn = quaternion(pose.rotation)
    return ['%.6f' % number for number in [*pose.translation.tolist(), turn.x, turn.y, turn.z, turn.w]]
