"""How exercise 5.2 is presented and judged."""
from aruco_course.check import Challenge, Check
from aruco_course.judge.challenges import no_tag_views, noisy_views, twice_views
from aruco_course.judge.outline_judge import judge_frame_kept, judge_outlines, judge_tags, tag_views

TASK = '''\
Find the tags in the camera's image. Outline each one along its four corners, and write its id beside it.
How many tags are in sight, and which, differs from frame to frame. All are of the dictionary DICT_6X6_250.'''

HINTS = (
    ('A detector works on a gray image: cv2.cvtColor(image, cv2.COLOR_BGR2GRAY). A cv2.aruco.ArucoDetector '
     'is made of a dictionary and of cv2.aruco.DetectorParameters(), and its method detectMarkers returns '
     'three things. Print their shapes.'),
    ('The corners of each tag are an array of shape (1, 4, 2), the ids together one of shape (n, 1). So '
     "quad[0] is a tag's four points, and ids.ravel() is a plain row of ids. cv2.polylines takes a list of "
     'polygons of whole numbers: [quad[0].astype(np.int32)]. Do not forget that it shall be closed.'),
    ('for quad, tag_id in zip(corners, ids.ravel()): draw with cv2.polylines(image, '
     '[quad[0].astype(np.int32)], True, (0, 255, 0), 2), then write with cv2.putText(image, str(tag_id), '
     'place, cv2.FONT_HERSHEY_SIMPLEX, 0.6, (0, 0, 255), 2), where place is two whole numbers. Or leave '
     'both to cv2.aruco.drawDetectedMarkers(image, corners, ids).'))

CHALLENGES = (
    Challenge('no tag in sight',
              'Without a tag, the ids are None. "for i in range(len(ids))", as in the course, then ends with '
              'an exception, and the node shows nothing until it sees a tag again.',
              no_tag_views, judge_frame_kept),
    Challenge('one id twice',
              'Two tags may have the same id, such as two prints of one page. Code that keeps the corners by '
              'id, in a dict, loses one of them.',
              twice_views, judge_outlines),
    Challenge('a noisy frame',
              'In the dark, a camera is noisy. OpenCV still finds the tags, but may put a corner ten pixels '
              'beside its place. cv2.GaussianBlur(gray, (5, 5), 0) before the search helps.',
              noisy_views, judge_outlines))

CHECK = Check('5.2', 'Detect the tags', 20, 'detect_tags', TASK, HINTS, tag_views, judge_tags, CHALLENGES)
