#!/usr/bin/env python3
"""Exercise 5.1, as the course's text has it, in today's OpenCV."""
import os

import cv2
from cv2 import aruco

FOLDER = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), 'Tags')


def draw_tag(tag_id, size):
    aruco_dict = aruco.getPredefinedDictionary(aruco.DICT_6X6_250)
    return aruco.generateImageMarker(aruco_dict, tag_id, size)


def main():
    os.makedirs(FOLDER, exist_ok=True)
    for i in range(1, 5):
        size = 700
        img = draw_tag(i, size)
        cv2.imwrite(FOLDER + '/image_' + str(i) + '.jpg', img)


if __name__ == '__main__':
    main()
