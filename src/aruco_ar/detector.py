"""Finding tags in a frame."""
import cv2

from .tags import Tag, get_dictionary


class Detector:
    """Finds the tags of one dictionary.

    ``dictionary`` is a name such as ``DICT_6X6_250``. With ``ids``, tags of
    other ids are passed over. Raises InputError for an unknown dictionary.
    """

    def __init__(self, dictionary='DICT_6X6_250', ids=()):
        parameters = cv2.aruco.DetectorParameters()
        # Without refinement corners are whole pixels, and what is painted trembles.
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.ArucoDetector(get_dictionary(dictionary), parameters)
        self._ids = frozenset(ids)

    def detect(self, frame):
        """The tags in a frame, a list of Tag in the order in which they were found.

        ``frame``: (h, w, 3) BGR or (h, w) gray, uint8.
        """
        gray = frame if frame.ndim == 2 else cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
        corners, ids, _ = self._detector.detectMarkers(gray)
        if ids is None:
            return []
        return [Tag(int(tag_id), quad.reshape(4, 2))
                for tag_id, quad in zip(ids.ravel(), corners)
                if not self._ids or int(tag_id) in self._ids]
