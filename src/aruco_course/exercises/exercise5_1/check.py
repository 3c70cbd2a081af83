"""How exercise 5.1 is presented and judged: four files of tags."""
from __future__ import annotations

from aruco_course.check import ProgramCheck
from aruco_course.judge.tag_files import files_fault

TASK = (
    'Write a program that draws four tags of DICT_6X6_250, with the ids 1, 2, 3 and 4, and writes each into a '
    'file of its own, image_1.jpg to image_4.jpg, in the folder Tags of your package. It needs no ROS.')

HINTS = (
    ('There are two things to do: draw the image of one tag, and write four such images. OpenCV does both; its '
     'functions for tags are in cv2.aruco, and cv2.imwrite(path, image) writes a file.'),
    ('cv2.aruco.generateImageMarker(dictionary, tag_id, size) makes the image of a tag; in the course, with an '
     'older OpenCV, it is called drawMarker. The ids are those of range(1, 5). os.path.join(TAGS, name) is a '
     'path in the folder; cv2.imwrite returns False if there is no such folder, and says nothing.'),
    ("image = cv2.aruco.generateImageMarker(DICTIONARY, tag_id, size) in draw_tag, and in main, for each "
     "tag_id of range(1, 5): cv2.imwrite(os.path.join(TAGS, 'image_%d.jpg' % tag_id), draw_tag(tag_id, 700))."),
)

CHECK = ProgramCheck('5.1', 'Draw the tags', 10, '', TASK, HINTS, files_fault)
