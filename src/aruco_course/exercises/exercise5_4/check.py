"""How exercise 5.4 is presented and judged."""
from aruco_course.check import Challenge, Check
from aruco_course.judge.challenges import (
    five_views,
    judge_five,
    judge_no_polygon,
    judge_twice,
    no_tag_views,
    rolled_views,
    three_views,
    twice_views,
)
from aruco_course.judge.polygon_judge import judge_order
from aruco_course.judge.views import area_views

TASK = '''\
Put the four centers in order, so that the polygon through them goes around and does not cross itself.
The tags are found in an order that says nothing, and their ids differ from frame to frame. If there are not
four tags, leave the frame as it is.'''

HINTS = (
    ('In an image, x grows to the right, and y grows down. So at the top left both are small, and at the '
     'bottom right both are large. At which corner is x + y least, and at which is it greatest?'),
    ('At the top right, x is large and y is small, so y - x is least there. At the bottom left it is '
     'greatest. np.argmin and np.argmax tell the place of the least and of the greatest number in an array.'),
    ('total = centers[:, 0] + centers[:, 1], difference = centers[:, 1] - centers[:, 0]. The order is '
     '[np.argmin(total), np.argmin(difference), np.argmax(total), np.argmax(difference)], and '
     'centers[order] are the centers in that order.'))

CHALLENGES = (
    Challenge('no tag in sight',
              'Without a tag, the ids are None. "for i in range(len(ids))", as in the course, then ends with '
              'an exception, and the node shows nothing until it sees a tag again.',
              no_tag_views, judge_no_polygon),
    Challenge('three tags',
              'The course draws the polygon once before it looks whether there are four centers.',
              three_views, judge_no_polygon),
    Challenge('five tags',
              'The course takes all centers before it sorts them. What is drawn with five is a polygon of five '
              'corners. Leave such a frame as it is, or take the four that are farthest outside.',
              five_views, judge_five),
    Challenge('one id twice',
              'Two tags may have the same id, such as two prints of one page. Code that keeps the centers by '
              'id, in a dict, loses one of them.',
              twice_views, judge_twice),
    Challenge('a camera that rolls',
              'If the area stands on a corner, two centers have nearly the same x + y, and two nearly the same '
              "y - x. The course's rule then chooses one center twice and another never. The angle of each "
              'center around their middle, np.arctan2, gives an order that always goes around.',
              rolled_views, judge_order))

CHECK = Check('5.4', 'Put the centers in order', 20, 'order_centers', TASK, HINTS, area_views, judge_order,
              CHALLENGES)
