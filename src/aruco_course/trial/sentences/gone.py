"""What of OpenCV's API has another name today, or had one in an older OpenCV."""
from __future__ import annotations

# What the course's text uses, or what is found on the web, and what is written today.
TODAY = {
    'Dictionary_get': 'cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)',
    'Dictionary_create': 'cv2.aruco.extendDictionary(count, size)',
    'custom_dictionary': 'cv2.aruco.extendDictionary(count, size)',
    'DetectorParameters_create': 'cv2.aruco.DetectorParameters()',
    'detectMarkers': 'cv2.aruco.ArucoDetector(dictionary, cv2.aruco.DetectorParameters()).detectMarkers(gray)',
    'refineDetectedMarkers': 'cv2.aruco.ArucoDetector(…).refineDetectedMarkers(…)',
    'drawMarker': 'cv2.aruco.generateImageMarker(dictionary, tag_id, size)',
    'drawAxis': 'cv2.drawFrameAxes(image, matrix, distortion, rvec, tvec, length)',
    'estimatePoseSingleMarkers': 'cv2.solvePnP for each tag',
    'estimatePoseBoard': 'board.matchImagePoints(…) and cv2.solvePnP',
    'GridBoard_create': 'cv2.aruco.GridBoard((columns, rows), side, gap, dictionary)',
    'CharucoBoard_create': 'cv2.aruco.CharucoBoard((columns, rows), square, tag, dictionary)',
    'Board_create': 'cv2.aruco.Board(points, dictionary, ids)',
    'drawPlanarBoard': 'board.generateImage(size)',
    'interpolateCornersCharuco': 'cv2.aruco.CharucoDetector(board).detectBoard(gray)',
}
# What is written today, and what an OpenCV before 4.7 has instead.
BEFORE = {
    'ArucoDetector': 'cv2.aruco.detectMarkers(gray, dictionary)',
    'getPredefinedDictionary': 'cv2.aruco.Dictionary_get(cv2.aruco.DICT_6X6_250)',
    'generateImageMarker': 'cv2.aruco.drawMarker(dictionary, tag_id, size)',
    'DetectorParameters': 'cv2.aruco.DetectorParameters_create()',
}


def of_gone(name: str, opencv: str) -> str:
    """The sentence for a name that cv2.aruco does not have, or ''."""
    if name in TODAY:
        return 'OpenCV %s has no %s any more: it is %s now.' % (opencv, name, TODAY[name])
    if name in BEFORE:
        return 'your OpenCV, %s, is too old for %s: it has %s, or "pip install -U opencv-contrib-python".' % (
            opencv, name, BEFORE[name])
    return ''
