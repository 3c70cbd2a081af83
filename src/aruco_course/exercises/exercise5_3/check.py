"""How exercise 5.3 is presented and judged."""
from aruco_course.check import Challenge, Check
from aruco_course.judge.challenges import judge_no_polygon, no_tag_views, twice_views
from aruco_course.judge.polygon_judge import judge_centers
from aruco_course.judge.views import area_views

TASK = '''\
Find the centers of the four tags, and draw the polygon through them. Its corners may come as the tags were
found. The ids and the places of the tags differ from frame to frame. Without four tags, draw what you like,
or nothing.'''

HINTS = (
    ('The center of a tag is the mean of its four corners: the mean of their x, and the mean of their y. '
     'NumPy takes both at once: the mean over the axis of the four corners.'),
    ('For each tag, quad[0] has the shape (4, 2), so quad[0].mean(axis=0) is its center (x, y). Put the '
     'four centers into one array, of shape (4, 2). For drawing, it must be of int32.'),
    ('centers = np.array([quad[0].mean(axis=0) for quad in corners]), then cv2.drawContours(image, '
     '[centers.astype(np.int32)], -1, (255, 0, 150), -1). Mind the brackets around the polygon: it is a '
     'list of one.'))

CHALLENGES = (
    Challenge('no tag in sight',
              'Without a tag, the ids are None. "for i in range(len(ids))", as in the course, then ends with '
              'an exception, and the node shows nothing until it sees a tag again.',
              no_tag_views, judge_no_polygon),
    Challenge('one id twice',
              'Two tags may have the same id, such as two prints of one page. Code that keeps the centers by '
              'id, in a dict, loses one of them.',
              twice_views, judge_centers))

CHECK = Check('5.3', 'Find the centers', 15, 'extract_centers', TASK, HINTS, area_views, judge_centers,
              CHALLENGES)
