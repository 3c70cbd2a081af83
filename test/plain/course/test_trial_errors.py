"""For what usually goes wrong in a line of the exercises, a sentence says what helps."""
import numpy as np
import pytest
from aruco_course.trial import run_function

FRAME = np.full((48, 64, 3), 100, np.uint8)

# The lines of the function, and what must be in the sentence. The last line is the one that fails.
MISTAKES = [
    # OpenCV's API, as it was
    (['cv2.aruco.Dictionary_get(cv2.aruco.DICT_6X6_250)'], 'getPredefinedDictionary'),
    (['cv2.aruco.DetectorParameters_create()'], 'cv2.aruco.DetectorParameters()'),
    (['cv2.aruco.drawMarker(None, 1, 100)'], 'generateImageMarker'),
    (['cv2.aruco.drawAxis(image)'], 'drawFrameAxes'),
    (['from cv2.aruco import drawMarker'], 'generateImageMarker'),
    (['cv2.aruco.ArucoDetector.detectMarkers(image)'], 'made first'),
    (['cv2.fillPolly(image)'], 'Is fillPoly meant'),
    (['cv2.COLOR_BGR2GREY'], 'Is COLOR_BGR2GRAY meant'),
    # points
    (['points = np.float32([[1, 1], [9, 1], [9, 9]])',
      'cv2.drawContours(image, [points], -1, 255, -1)'], 'int32'),
    (['points = np.float32([[1, 1], [9, 1], [9, 9]])', 'cv2.fillPoly(image, [points], 255)'], 'int32'),
    (['points = [[1, 1], [9, 1], [9, 9]]', 'cv2.drawContours(image, points, -1, 255, -1)'], 'int32'),
    (['cv2.circle(image, (1.5, 2.5), 3, 255)'], 'int(x)'),
    (['cv2.putText(image, "1", np.float32([1, 2]), 0, 1, 255)'], 'int(x)'),
    (['cv2.resize(image, (32.5, 24))'], 'whole numbers'),
    # images that do not fit
    (['mask = np.zeros((48, 64), np.uint8)', 'cv2.subtract(image, mask)'], 'gray'),
    (['mask = np.zeros((64, 48, 3), np.uint8)', 'cv2.subtract(image, mask)'], 'Height and width are exchanged'),
    (['mask = np.zeros((48, 64, 3))', 'cv2.subtract(image, mask)'], 'float64'),
    (['mask = np.zeros((20, 20, 3), np.uint8)', 'image + mask'], 'do not have the same shape'),
    (['cv2.cvtColor(image[..., 0], cv2.COLOR_BGR2GRAY)'], 'gray already'),
    (['cv2.cvtColor(image[60:], cv2.COLOR_BGR2GRAY)'], 'empty image'),
    (['h, w = image.shape'], 'image.shape[:2]'),
    (['image[60, 50]'], 'image[y, x]'),
    # nothing was found
    (['ids = None', 'len(ids)'], 'ids is None'),
    (['ids = None', 'ids.flatten()'], 'ids is None'),
    (['ids = None', 'for one in ids: pass'], 'ids is None'),
    (['picture = cv2.imread("earth.jpg")', 'picture.shape'], 'no image at earth.jpg (line 4)'),
    (['picture = cv2.imread("earth.jpg")', 'cv2.resize(picture, (5, 5))'], 'no image at earth.jpg (line 4)'),
    (['picture = cv2.imread("earth.jpg")', 'picture.shape'], 'Leave it out'),
    (['corners = []', 'corners[0]'], 'as many tags'),
    (['np.argmin(np.zeros((0, 2)))'], 'no tag was found'),
    (['open("earth.txt")'], 'earth.txt'),
    # a homography
    (['cv2.findHomography(np.zeros((3, 2)), np.zeros((3, 2)))'], 'four each'),
    (['points = np.int32([[0, 0], [9, 0], [9, 9], [0, 9]])', 'cv2.getPerspectiveTransform(points, points)'],
     'float32'),
    (['points = np.float32([[0, 0], [9, 0], [9, 9], [0, 9]])', 'hom = cv2.findHomography(points, points)',
      'cv2.warpPerspective(image, hom, (64, 48))'], 'hom, status'),
    # Python and NumPy
    (['ids = np.zeros((4, 1))', 'if ids: pass'], 'ids is None'),
    (['corners = (1, 2)', 'corners[0] = 3'], 'cannot be changed'),
    (['[1, 2].shape'], 'np.array'),
    (['np.zeros(3).append(1)'], 'Collect in a list'),
    (['range(2.0)'], 'whole number'),
    (['"image_" + 1'], 'str('),
    (['corners, ids = 1, 2, 3'], 'more values'),
    (['a, b = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(0)).detectMarkers(image)'],
     'three values'),
    (['{1: 2}[3]'], 'no key 3'),
    (['os.path'], '"import os" is missing'),
    (['math.pi'], '"import math" is missing'),
    (['if False:', '    center = 1', 'center'], 'center has no value here yet'),
    (['print(TAGS)'], 'TAGS = os.path.join('),
    (['import opencv'], '"import cv2"'),
    (['import aruco'], 'from cv2 import aruco'),
    (['import rospy', 'rospy.get_param("~path")'], 'get_param'),
    (['raise RuntimeError("out of luck")'], 'RuntimeError: out of luck.'),
]
if np.lib.NumpyVersion(np.__version__) >= '1.24.0':  # older ones still have it
    MISTAKES.append((['np.int(3)'], 'np.int32'))


@pytest.mark.parametrize('lines, said', MISTAKES, ids=[lines[-1] for lines, _ in MISTAKES])
def test_the_sentence_helps(tmp_path, lines, said):
    path = tmp_path / 'exercise.py'
    path.write_text('\n'.join(['import cv2', 'import numpy as np', 'def draw(image):',
                               *('    ' + line for line in lines)]))
    fault = run_function(str(path), 'draw', [(FRAME,)]).fault
    assert said in fault.what
    assert fault.place == 'Line %d' % (3 + len(lines))


@pytest.mark.parametrize('below, said', [
    ('import numpy as np', 'Imports belong to the top of the file'),
    ('np = 1', 'exchange the two')])
def test_a_name_whose_value_comes_further_below_is_told(tmp_path, below, said):
    path = tmp_path / 'exercise.py'
    path.write_text('import numpy as np\ndef draw(image):\n    np.zeros(3)\n    %s\n' % below)
    fault = run_function(str(path), 'draw', [(FRAME,)]).fault
    assert fault.place == 'Line 3'
    assert 'further below, in line 4' in fault.what
    assert said in fault.what
