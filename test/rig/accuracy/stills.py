"""Stills of a sheet with tags, four a second, while the camera goes round it: it moves far between two."""
import cv2
import numpy as np
from aruco_ar.tags.tag import draw_tag

SIZE = 1280, 720
FRAMES_PER_S = 4
CAMERA = np.array([[1100.0, 0, 640], [0, 1100, 360], [0, 0, 1]])
SHEET, TAG, STEP = (1400, 1000), 140, 197  # size; a tag's side; from tag to tag; millimeters
COLUMNS, ROWS = 7, 5
IDS = 0, 1, 2, 3  # of the tags in the corners of the sheet, clockwise
MARGIN = 6        # a tag is in full sight if it is at least MARGIN pixels inside the frame


def sheet(rim):
    """(image, {id: (4, 2) corners}): a sheet with tags in its corners; with ``rim``, also between these."""
    cells = [(0, 0), (COLUMNS - 1, 0), (COLUMNS - 1, ROWS - 1), (0, ROWS - 1)]
    if rim:
        cells += [(column, row) for row in range(ROWS) for column in range(COLUMNS)
                  if (row in (0, ROWS - 1) or column in (0, COLUMNS - 1)) and (column, row) not in cells]
    image, places = np.full(SHEET[::-1], 235, np.uint8), {}
    for tag_id, (column, row) in enumerate(cells):
        x, y = 40 + STEP * column, 40 + STEP * row
        image[y:y + TAG, x:x + TAG] = draw_tag('DICT_6X6_250', tag_id, TAG)
        places[tag_id] = np.array([[x, y], [x + TAG, y], [x + TAG, y + TAG], [x, y + TAG]]) - 0.5
    return cv2.cvtColor(image, cv2.COLOR_GRAY2BGR), places


def stills(rim, seed, count=40):
    """Yield (frame, stamp, (4, 2) true corners of the area, or None unless its four tags are in full sight)."""
    random, (image, places) = np.random.RandomState(seed), sheet(rim)
    quads = np.array([places[tag_id] for tag_id in IDS])
    noise = random.normal(0, 2, (SIZE[1], SIZE[0], 3))
    for number in range(count):
        tilt = cv2.Rodrigues(np.array([0.75 + 0.1 * np.sin(0.5 * number), 0, 0]))[0]
        around = tilt @ cv2.Rodrigues(np.array([0, 0, 0.16 * number]))[0]
        away = [random.normal(0, 60), random.normal(0, 45), 2600 + 200 * np.sin(0.7 * number)]
        homography = CAMERA @ np.column_stack([around[:, 0], around[:, 1], away]) \
            @ np.array([[1, 0, -SHEET[0] / 2], [0, 1, -SHEET[1] / 2], [0, 0, 1]])
        frame = cv2.warpPerspective(image, homography, SIZE, flags=cv2.INTER_AREA, borderValue=(90, 140, 170))
        frame = cv2.add(cv2.GaussianBlur(frame, (0, 0), 0.8), np.roll(noise, number, axis=0), dtype=cv2.CV_8U)
        seen = cv2.perspectiveTransform(quads.reshape(1, -1, 2), homography)[0]
        corners = cv2.perspectiveTransform(quads.mean(axis=1)[None], homography)[0]
        is_in_sight = np.all(seen > MARGIN) and np.all(seen < np.array(SIZE) - 1 - MARGIN)
        yield frame, number / FRAMES_PER_S, corners if is_in_sight else None
