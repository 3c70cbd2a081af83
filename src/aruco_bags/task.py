"""An exercise on the frames of a piece of a bag."""
import csv
import os
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import rosbag
from aruco_ar import InputError, PoseEstimator, find_area
from aruco_ar.base.files import in_package
from aruco_ar.exercise import PICTURE, TRACKER, Exercise, Stage
from aruco_ar.painting.sources import Still, open_source
from aruco_node.messages.images import compressed_from_frame, tags_from_pixels
from aruco_node.messages.pose_messages import pose_message
from aruco_node.messages.topics import raw_topic
from aruco_node.nodes.calibration import is_rectified, lens_from_info
from aruco_node.parameters.settings import TOPIC
from sensor_msgs.msg import CameraInfo

from .bag_reader import messages, to_frame

CORNERS = [(number, axis) for number in range(4) for axis in 'xy']
COLUMNS = ['bag', 'topic', 'stamp', 'id', *('corner%d_%s' % corner for corner in CORNERS),
           'center_x', 'center_y', 'x', 'y', 'z', 'qx', 'qy', 'qz', 'qw',
           *('area%d_%s' % corner for corner in CORNERS)]


@dataclass(frozen=True)
class Task:
    """An Exercise of aruco_ar, with the BagSettings to do it with."""

    exercise: Exercise
    settings: Any


def check(task):
    """Raises InputError if the picture of a Task cannot be painted into bags."""
    if PICTURE in task.exercise.needs:
        given = task.settings.picture
        if given.startswith(TOPIC) or not isinstance(open_source(in_package(given)), Still):
            raise InputError('The parameter ~picture is "%s"; into bags pictures are painted that stand still: '
                             'give a JPEG or PNG.' % given)


def annotate(piece, task, folder):
    """Write what a Task makes of a Piece into a folder, NUMBER.bag and NUMBER.csv, unless it is there.

    Returns how many frames were looked at, and sentences about what could not be.
    """
    cv2.setNumThreads(1)  # the other cores have pieces of their own
    path = os.path.join(folder, '%06d' % piece.number)
    if os.path.exists(path + '.csv'):
        return 0, []
    os.makedirs(folder, exist_ok=True)
    with drafted(path + '.csv', folder) as table, drafted(path + '.bag', folder) as bag, \
            open(table, 'w', newline='') as rows, rosbag.Bag(bag, 'w') as output:
        return _Annotator(piece, task, csv.writer(rows), output).run()


class _Annotator:
    """Follows the frames of one camera through a Piece."""

    def __init__(self, piece, task, rows, output):
        exercise, settings = task.exercise, task.settings
        self._piece, self._exercise, self._rows, self._output = piece, exercise, rows, output
        self._stage = Stage(exercise.needs, settings, lambda picture: open_source(in_package(picture)))
        self._estimator = PoseEstimator(settings.tag_size, dict(settings.tag_sizes))
        self._rectified = is_rectified(settings, raw_topic(piece.topic))
        self._info = self._lens = self._size = None
        self._faults = {}  # kind: sentence

    def run(self):
        decode, frames = to_frame(self._piece), 0
        for message, time, counts in messages(self._piece):
            if message._type == CameraInfo._type:
                message.header = None  # else each is another
                if message != self._info:
                    self._info, self._size = message, None
                continue
            try:
                frame = decode(message)
            except InputError as error:
                self._faults.setdefault(
                    error.kind, 'frames on %s are passed over: %s' % (self._piece.topic, error))
                continue
            stamp = message.header.stamp or time
            found = self._look(frame, stamp.to_sec())
            if counts:
                self._write(message.header, time, stamp, *found)
                frames += 1
        return frames, list(self._faults.values())

    def _fit(self, size):
        """Have the lens be that of frames of that size, as far as it is known."""
        if self._info is None or size == self._size:
            return
        self._lens, self._size = None, size
        try:
            self._lens = lens_from_info(self._info, size, self._rectified)
        except InputError as error:
            self._faults.setdefault(
                error.kind, 'there are no poses on %s, for its camera_info cannot be used: %s'
                % (self._piece.topic, error))

    def _look(self, frame, stamp):
        self._fit(frame.shape[1::-1])
        result = self._exercise.step(self._stage.scene(frame, frame, stamp))
        area = result.area if TRACKER in self._exercise.needs else find_area(result.tags)
        poses = {}
        if self._lens is not None:
            poses = {pose.id: pose for pose in self._estimator.update(result.tags, self._lens, stamp)}
        return result.images, result.tags, poses, area

    def _write(self, header, time, stamp, images, tags, poses, area):
        for topic, image in zip(self._exercise.topics, images):
            self._output.write('/%s/%s%s/compressed' % (self._exercise.name, topic, self._piece.camera),
                               compressed_from_frame(image, header), time)
        self._output.write('/%s/tags%s' % (self._exercise.name, self._piece.camera),
                           tags_from_pixels([(tag.id, tag.corners) for tag in tags], header), time)
        place = [''] * len(CORNERS) if area is None else ['%.3f' % number for number in np.ravel(area.corners)]
        name = os.path.basename(self._piece.bag)
        for tag in tags:
            self._rows.writerow([
                name, self._piece.topic, '%d.%09d' % (stamp.secs, stamp.nsecs), tag.id,
                *('%.3f' % number for number in [*np.ravel(tag.corners), *tag.center]),
                *_numbers(poses.get(tag.id)), *place])


def _numbers(pose):
    """Place and turn of a TagPose, or None, as text."""
    if pose is None:
        return [''] * 7
    message = pose_message(pose)
    return ['%.6f' % number for part in (message.position, message.orientation)
            for number in (getattr(part, name) for name in part.__slots__)]


@contextmanager
def drafted(path, folder):
    """The path of a draft in a folder; what the block has written there becomes that file, unless it fails.

    It is nobody else's: where a cluster has lost a worker, another may do the same while the first goes on.
    """
    draft = os.path.join(folder, os.urandom(8).hex() + os.path.splitext(path)[1])
    try:
        yield draft
        if os.path.exists(draft):
            os.replace(draft, path)
    finally:
        with suppress(FileNotFoundError):
            os.unlink(draft)
