#!/usr/bin/env python3
"""Exercise 5.1: draw four tags, and write each into a file.

This is a plain program, without ROS. Once the files are printed, the camera can
see the tags.
"""
import os

import cv2
import numpy as np

# The package's folder Tags, wherever the program is started from.
TAGS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), 'Tags')
DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)


def draw_tag(tag_id, size):
    """The image of a tag: an array of size x size numbers, 0 for black and 255 for white."""
    image = np.full((size, size), 255, np.uint8)  # white paper
    # Task 1: Draw the tag with that id, from the dictionary above. Which function of cv2.aruco makes an image
    # of a tag?
    ### BEGIN SOLUTION
    image = cv2.aruco.generateImageMarker(DICTIONARY, tag_id, size)
    ### END SOLUTION
    return image


def main():
    """Write the tags into the folder Tags."""
    # Task 2: Draw the tags with the ids 1, 2, 3 and 4, each 700 pixels wide, and write them into the folder
    # TAGS, as image_1.jpg to image_4.jpg.
    ### BEGIN SOLUTION
    os.makedirs(TAGS, exist_ok=True)
    for tag_id in range(1, 5):
        cv2.imwrite(os.path.join(TAGS, 'image_%d.jpg' % tag_id), draw_tag(tag_id, 700))
    ### END SOLUTION


if __name__ == '__main__':
    main()
