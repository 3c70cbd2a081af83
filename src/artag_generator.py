#!/usr/bin/env python3
"""Exercise 5.1: generate tags, as pictures or as pages to print.

This program needs no roscore. Without arguments, it writes the tags that the
course asks for: ids 1 to 4 of DICT_6X6_250, 700 x 700 pixels, as image_1.jpg to
image_4.jpg in Tags/.
"""
import sys

import aruco_program  # noqa: F401  it prepares NumPy and OpenCV, so it comes first
import cv2
from aruco_ar import get_dictionary
from aruco_ar.tags.tag import add_margin
from aruco_program.tag_command import run


def draw_tags(options):
    """Draw the tags, and make a file of each: its name and its bytes."""
    # A dictionary lists patterns of black and white cells that are easy to tell apart. A pattern's place in
    # the list is the tag's id. DICT_6X6_250 has 250 patterns of 6 x 6 cells, with the ids 0 to 249.
    dictionary = get_dictionary(options.dictionary)

    for tag_id in options.ids:  # 1, 2, 3, 4
        # This draws the pattern and the black border around it. The side of the picture is the size, 700
        # pixels. The border is one cell wide on each side, so the picture is 6 + 2 cells wide.
        image = cv2.aruco.generateImageMarker(dictionary, tag_id, options.size, borderBits=options.border)

        # The detector looks for the step from black to white. On white paper, the tag needs no white margin
        # of its own, so the width of this margin, "quiet", is 0 cells.
        image = add_margin(image, dictionary.markerSize + 2 * options.border, options.quiet)

        # Make a file of it. With JPEG's default quality, faint gray lines would appear along a tag's edges.
        data = cv2.imencode('.' + options.format, image, [cv2.IMWRITE_JPEG_QUALITY, 98])[1]
        yield 'image_%d.%s' % (tag_id, options.format), data.tobytes()


if __name__ == '__main__':
    # Read the options, draw the tags, and write all files into the folder Tags.
    run(draw_tags, __doc__, sys.argv[1:])
