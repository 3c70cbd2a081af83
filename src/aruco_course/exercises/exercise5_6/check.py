"""How exercise 5.6 is presented and judged: the picture is in the area, the right way up."""
from __future__ import annotations

from dataclasses import replace
from typing import Sequence

from aruco_course.check import Check, Fault, Shown, View
from aruco_course.judge.area_challenges import area_challenges, untouched
from aruco_course.judge.areas import Sight, sight_of, turned_sight
from aruco_course.judge.pictures import is_painted, own_picture, picture_fault, with_pictures
from aruco_course.judge.views import area_views

TASK = (
    'Paint a picture into the area between the four tags. Each of its corners goes to the center at the same '
    'corner of the area, and the rest of the frame stays as it is. Without four tags, return the image as it '
    'is.')

HINTS = (
    ('A homography takes four points to four others. cv2.findHomography(from_points, to_points) finds it, and '
     "cv2.warpPerspective(picture, homography, (width, height)) applies it. The size is that of the camera's "
     'image, the width first.'),
    ("The picture's corners are [0, 0], [width, 0], [width, height], [0, height], if the centers come from the "
     'top left, clockwise. The warped picture is black outside of the area. So make the area black in the '
     'frame, as in exercise 5.5, and add the two: black is 0.'),
    ('homography, _ = cv2.findHomography(picture_corners, ordered), then warped = cv2.warpPerspective(picture, '
     'homography, (image.shape[1], image.shape[0])), and at last cv2.add(cv2.subtract(image, mask), warped).'),
)


def judge(shown: Sequence[Shown]) -> Fault | None:
    """The first Fault in images of Views with four tags and a picture."""
    before: list[Sight] = []
    for one in shown:
        sight = sight_of(one)
        fault = picture_fault(sight, before)
        if fault is not None:
            return fault
        before.append(sight)
    return None


def judge_turned(shown: Sequence[Shown]) -> Fault | None:
    """The same for frames that are turned so much that either of two corners is the area's top left one."""
    for one in shown:
        sight = sight_of(one)
        if not any(is_painted(turned_sight(sight, turned)) for turned in (0, 1, 3)):
            return picture_fault(sight, ())
    return None


def _views() -> tuple[View, ...]:
    return with_pictures(area_views())


def _with_picture(view: View) -> View:
    return replace(view, picture=own_picture())


CHECK = Check('5.6', 'Paint a picture into the area', 30, 'paint_picture', TASK, HINTS, _views, judge,
              area_challenges(judge, untouched, judge_turned, _with_picture))
