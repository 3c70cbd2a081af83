"""Saving what a node sees and shows, when somebody asks for it."""
import os
import threading
from datetime import datetime

import cv2
import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import write_whole
from std_srvs.srv import Trigger, TriggerResponse

from .faults import note_fault

WAIT_S = 5.0


class Snapshot:
    """The service ~snapshot: the next frame and what is made of it, as PNG."""

    def __init__(self, wake):
        """``wake`` is called when a frame is wanted."""
        self._wake = wake
        self._asking = threading.Lock()  # one at a time
        self._frame = None
        self._taken = threading.Event()
        self.wanted = False

    def serve(self, folder, why):
        """Offer the service; ``folder`` to save into and ``why`` no frame came are asked when it is called."""
        self._folder, self._why = folder, why
        rospy.Service('~snapshot', Trigger, self._answer, error_handler=note_fault)

    def before(self, frame):
        """A frame, before anybody paints into it."""
        self._frame = frame.copy() if self.wanted else None

    def after(self, images):
        """What was made of it: {name: (h, w, 3) BGR uint8}."""
        if self.wanted and self._frame is not None:
            self._images, self.wanted = dict(images, frame=self._frame), False
            self._taken.set()

    def _answer(self, request):
        with self._asking:
            self._taken.clear()
            self.wanted = True
            self._wake()
            if not self._taken.wait(WAIT_S):
                self.wanted = False
                return TriggerResponse(False, 'No frame came within %d s. %s' % (WAIT_S, self._why()))
            try:
                return TriggerResponse(True, 'Wrote ' + ', '.join(self._write()))
            except InputError as error:
                return TriggerResponse(False, str(error))

    def _write(self):
        """Write the files, all or none; their paths."""
        folder = os.path.abspath(os.path.expanduser(self._folder()))
        # Not the frame's own time, which comes again where a bag is played over and over.
        start = '%s_%s' % (rospy.get_name()[1:].replace('/', '_'),
                           datetime.now().strftime('%Y-%m-%d_%H-%M-%S.%f')[:-3])
        paths = []
        try:
            for name, image in sorted(self._images.items()):
                path = os.path.join(folder, '%s_%s.png' % (start, name))
                write_whole(path, cv2.imencode('.png', image)[1].tobytes())
                paths.append(path)
        except InputError:
            for path in paths:
                os.unlink(path)
            raise
        return paths
