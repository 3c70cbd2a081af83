"""The file beside a photo that lists the tags in it."""
import re

import numpy as np
from aruco_ar import InputError


def tags_in(path):
    """[(id, (4, 2) pixels)]: the tags that a file lists, one a line: id, then four corners, in any order.

    A line may have the id alone; its corners are then None. Raises InputError for any other line.
    """
    tags = []
    with open(path, encoding='utf-8') as file:
        for number, line in enumerate(file, start=1):
            numbers = re.findall(r'-?\d+(?:\.\d+)?', line)
            if len(numbers) not in (0, 1, 9) or not all(map(str.isdecimal, numbers[:1])) or \
                    re.search('[^-0-9.,()\\s]', line):
                raise InputError('Line %d of "%s" is not a tag; give its id, or its id and four corners, as in '
                                 '"7, (10 10), (50 10), (50 50), (10 50)".' % (number, path))
            if numbers:
                corners = np.float64(numbers[1:]).reshape(4, 2) if len(numbers) == 9 else None
                tags.append((int(numbers[0]), corners))
    return tags
