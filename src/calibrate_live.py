#!/usr/bin/env python3
"""Calibrates a camera while it runs, from a flat sheet of tags or a ChArUco board.

Move the sheet before the camera, or the camera before the sheet, and hold still
now and then. The image shows where in the frame the sheet has been seen, and the
node says what is missing. The service ~save then writes the calibration.
"""
import os
import threading
from concurrent.futures import ThreadPoolExecutor

import aruco_program  # noqa: F401  before all else
import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import write_whole
from aruco_ar.calibration.calibrate import MIN_VIEWS, calibrate
from aruco_ar.calibration.camera_file import camera_yaml
from aruco_ar.calibration.collection import Collection
from aruco_ar.calibration.sheets import CharucoBoard, TagSheet, read_board
from aruco_node.health.faults import fault_barrier, note_fault
from aruco_node.nodes.frame_node import Answer, FrameNode
from aruco_node.nodes.manual import CAMERA_TOPICS, FRAME_SERVICES, Manual, image_topics
from aruco_node.nodes.node import run_node
from aruco_node.parameters.settings import FISHEYE, CalibrationSettings
from aruco_node.process.memory import keep_memory
from std_srvs.srv import Trigger, TriggerResponse

SHOW = ('Show the sheet to the camera, in all parts of its image, tilted to all sides, and hold still now and '
        'then.')


class LiveCalibration(FrameNode):
    """Collects views, and calibrates in another thread whenever there are more."""

    def __init__(self):
        super().__init__(['image'], CalibrationSettings)
        dictionary, charuco = self.settings.dictionary, self.settings.charuco
        self._sheet = CharucoBoard(dictionary, *read_board(charuco)) if charuco else TagSheet(dictionary)
        self._solver = ThreadPoolExecutor(1, 'solver')
        self._lock = threading.Lock()
        self._begin((0, 0))

    def process(self, frame, header, stamp):
        collection, view = self._collection, self._sheet.view(frame)  # read once, since ~reset may change it
        if collection.size != frame.shape[1::-1]:
            collection = self._begin(frame.shape[1::-1])
        if collection.offer(view) and len(collection.views) >= MIN_VIEWS:
            self._solver.submit(self._solve, collection, len(collection.views))
        return Answer([collection.draw(frame, view)], lambda: None)

    def report(self):
        level, sentence, values = super().report()
        values['calibration'] = self._progress()
        return level, sentence, values

    def offer_services(self):
        super().offer_services()
        rospy.Service('~save', Trigger, self._on_save, error_handler=note_fault)
        rospy.Service('~reset', Trigger, self._on_reset, error_handler=note_fault)

    def _begin(self, size):
        """Begin anew, for frames of a size, (width, height). Returns the new Collection."""
        collection = Collection(size)
        with self._lock:
            self._collection, self._found, self._why, self._saved = collection, None, '', ''
        return collection

    @fault_barrier
    def _solve(self, collection, count):
        """Calibrate, unless there are more views by now, for which this will be called again."""
        if collection is not self._collection or count < len(collection.views):
            return
        found, why = None, ''
        try:
            found = calibrate(collection.views[:count], collection.size, self.settings.model == FISHEYE,
                              self._sheet.points)
        except InputError as error:
            why = str(error)
        with self._lock:
            if collection is self._collection:
                self._found, self._why, self._saved = found, why, ''

    def _progress(self):
        """What there is so far, and what to do, in sentences."""
        with self._lock:
            collection, found, why, saved = self._collection, self._found, self._why, self._saved
        if not collection.views:
            return SHOW
        count = len(collection.views)
        views = '%d view%s, %.0f %% of the image.' % (count, 's' * (count > 1), 100 * collection.coverage)
        if found is None:
            return '%s %s' % (views, why or SHOW)
        ready = '%s The focal length is %.1f px, and points are off by %.2f px (%.2f px in views held out).' % (
            views, found.lens.matrix[0, 0], found.rms, found.held_out)
        if saved:
            return '%s It is saved as %s.' % (ready, saved)
        return '%s %s' % (ready, found.lacks() or 'To save it: rosservice call ' + rospy.resolve_name('~save'))

    def _on_save(self, request):
        with self._lock:
            found, why, is_begun = self._found, self._why, bool(self._collection.views)
        if found is None:
            return TriggerResponse(False, 'Nothing is saved. %s' % (
                why or (SHOW if is_begun else self.report()[1])))
        path = os.path.expanduser(self.settings.file)
        try:
            os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
            write_whole(path, camera_yaml(found.lens, self.settings.camera_name).encode())
        except (InputError, OSError) as error:
            return TriggerResponse(False, 'Nothing is saved. %s' % error)
        with self._lock:
            if found is self._found:
                self._saved = path
        return TriggerResponse(True, self._progress())

    def _on_reset(self, request):
        self._begin((0, 0))
        return TriggerResponse(True, 'All views are forgotten.')


if __name__ == '__main__':
    keep_memory()
    run_node('calibrate_live', lambda: LiveCalibration().spin(), Manual(
        CAMERA_TOPICS, image_topics(['image']), [
            *FRAME_SERVICES, ('~save', 'std_srvs/Trigger', 'writes the calibration into ~file'),
            ('~reset', 'std_srvs/Trigger', 'forgets all views')], CalibrationSettings))
