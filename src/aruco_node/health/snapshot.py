"""The service that saves a frame, and what the node makes of it."""
import os
import threading
from datetime import datetime

import cv2
import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import path_of, write_whole
from std_srvs.srv import Trigger, TriggerResponse

from .faults import note_fault

WAIT_S = 5.0  # a call of the service waits this long for a frame


def new_path(folder, ending):
    """The full path of a file to write into a folder. Its name begins with the node's name and the time."""
    # Not the time of a frame, which recurs while a bag is played in a loop.
    return os.path.join(os.path.abspath(path_of(folder)), '%s_%s_%s' % (
        rospy.get_name()[1:].replace('/', '_'), datetime.now().strftime('%Y-%m-%d_%H-%M-%S.%f')[:-3], ending))


class SnapshotService:
    """The service ~snapshot: saves the next frame, and what the node makes of it, as PNG."""

    def __init__(self, wake):
        """``wake`` is called when a frame is wanted."""
        self._wake = wake
        self._calling = threading.Lock()  # calls of the service take turns
        self._frame = None
        self._is_taken = threading.Event()
        self.is_waiting = False  # whether somebody has called the service and waits for a frame

    def offer(self, folder, why_silent):
        """Advertise the service. When it is called, ``folder()`` is the path of the folder to save into.

        ``why_silent()``: a sentence that says why no frame arrived.
        """
        self._folder, self._why_silent = folder, why_silent
        rospy.Service('~snapshot', Trigger, self._on_call, error_handler=note_fault)

    def keep_frame(self, frame):
        """Keep a copy of a frame, before anything is drawn on it, if it is wanted."""
        self._frame = frame.copy() if self.is_waiting else None

    def keep_images(self, images):
        """Keep what was made of that frame, {name: (h, w, 3) BGR uint8}, if it is wanted."""
        if self.is_waiting and self._frame is not None:
            self._images, self.is_waiting = dict(images, frame=self._frame), False
            self._is_taken.set()

    def _on_call(self, request):
        with self._calling:
            self._is_taken.clear()
            self.is_waiting = True
            self._wake()
            if not self._is_taken.wait(WAIT_S):
                self.is_waiting = False
                return TriggerResponse(False, 'No frame arrived within %d s. %s' % (WAIT_S, self._why_silent()))
            try:
                return TriggerResponse(True, 'Wrote ' + ', '.join(self._write()))
            except InputError as error:
                return TriggerResponse(False, str(error))

    def _write(self):
        """Write the files, all or none. Returns their paths. Raises InputError if they cannot be written."""
        start, paths = new_path(self._folder(), ''), []
        try:
            for name, image in sorted(self._images.items()):
                path = '%s%s.png' % (start, name)
                write_whole(path, cv2.imencode('.png', image)[1].tobytes())
                paths.append(path)
        except InputError:
            for path in paths:
                os.unlink(path)
            raise
        return paths
