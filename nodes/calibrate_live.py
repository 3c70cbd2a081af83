#!/usr/bin/env python3
"""Calibrates a camera while it runs, from a flat sheet of tags or a ChArUco board.

Move the sheet in front of the camera, or the camera in front of the sheet, and
hold still now and then. The image shows where in the frame the sheet has been seen, and the
node says what is missing. The service ~save then writes the calibration.
"""
import os
import threading
from concurrent.futures import ThreadPoolExecutor

import aruco_program  # noqa: F401  before all else
import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import path_of, write_whole
from aruco_ar.calibration.calibrate import MIN_VIEWS
from aruco_ar.calibration.calibration_progress import SHOW, CalibrationProgress
from aruco_ar.calibration.camera_file import camera_yaml
from aruco_ar.calibration.sheets import CharucoBoard, TagSheet, read_board
from aruco_node.health.faults import fault_barrier, note_fault
from aruco_node.nodes.frame_node import Answer, FrameNode
from aruco_node.nodes.manual import CAMERA_TOPICS, FRAME_SERVICES, Manual, image_topics
from aruco_node.nodes.node import run_node
from aruco_node.parameters.settings import FISHEYE, CalibrationSettings
from aruco_node.process.memory import keep_memory
from std_srvs.srv import Trigger, TriggerResponse


class LiveCalibration(FrameNode):
    """Collects views, and calibrates in another thread whenever there are more."""

    def __init__(self):
        super().__init__(['image'], CalibrationSettings)
        dictionary, charuco = self.settings.dictionary, self.settings.charuco
        self._sheet = CharucoBoard(dictionary, *read_board(charuco)) if charuco else TagSheet(dictionary)
        self._saving = threading.Lock()  # of two calls of ~save, the later one writes the newer lens
        self._solver, self._searcher = ThreadPoolExecutor(1, 'solver'), ThreadPoolExecutor(1, 'hints')
        self._reset((0, 0))

    def process(self, frame, header, stamp):
        progress, view = self._progress, self._sheet.view(frame)
        if progress.collection.size != frame.shape[1::-1]:
            progress = self._reset(frame.shape[1::-1])
        views = progress.collection.views
        before = len(views)
        search = progress.update(frame, stamp, view)
        if search is not None:
            self._searcher.submit(fault_barrier(search))
        if len(views) > before and len(views) >= MIN_VIEWS:
            self._solver.submit(self._solve, progress, len(views))
        return Answer([progress.collection.draw(frame, view)], lambda: None)

    def forget_last_frames(self):
        self._progress.forget_last_frames()

    def report(self):
        level, sentence, values = super().report()
        values['calibration'] = self._text()
        return level, sentence, values

    def offer_services(self):
        super().offer_services()
        rospy.Service('~save', Trigger, self._on_save, error_handler=note_fault)
        rospy.Service('~reset', Trigger, self._on_reset, error_handler=note_fault)

    def _reset(self, size):
        """Forget all views. New frames have a size, (width, height). Returns the new CalibrationProgress."""
        self._progress = progress = CalibrationProgress(size, self._sheet)
        return progress

    @fault_barrier
    def _solve(self, progress, count):
        """Calibrate, unless there are more views by now, for which this will be called again."""
        if progress is self._progress and count == len(progress.collection.views):
            progress.solve(count, self.settings.model == FISHEYE)

    def _text(self):
        return self._progress.text(*('rosservice call ' + rospy.resolve_name(name)
                                     for name in ('~save', '~reset')))

    def _on_save(self, request):
        with self._saving:
            return self._save()

    def _save(self):
        progress = self._progress  # read once, since ~reset may change it
        found = progress.found
        if found is None:
            return TriggerResponse(False, 'Nothing is saved. %s' % (
                progress.why or (SHOW if progress.collection.views else self.report()[1])))
        path = path_of(self.settings.file)
        try:
            os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
            write_whole(path, camera_yaml(found.lens, self.settings.camera_name).encode())
        except (InputError, OSError) as error:
            return TriggerResponse(False, 'Nothing is saved. %s' % error)
        progress.note_saved(found, path)
        return TriggerResponse(True, 'It is saved as %s.' % path)

    def _on_reset(self, request):
        self.between_frames(lambda: self._reset((0, 0)))
        return TriggerResponse(True, 'All views are forgotten.')


if __name__ == '__main__':
    keep_memory()
    run_node('calibrate_live', lambda: LiveCalibration().spin(), Manual(
        CAMERA_TOPICS, image_topics(['image']), [
            *FRAME_SERVICES, ('~save', 'std_srvs/Trigger', 'writes the calibration into ~file'),
            ('~reset', 'std_srvs/Trigger', 'forgets all views')], CalibrationSettings))
