#!/usr/bin/env python3
"""Tags are drawn cell by cell, with a white margin, in colors."""
from pathlib import Path

import cv2
import numpy as np


def draw_tag(tag_id, size):
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
    bits = dictionary.getBitsFromByteList(dictionary.bytesList[tag_id:tag_id + 1], 6)
    cells = np.pad(np.pad(bits * 255, 1), 1, constant_values=255).astype(np.uint8)
    image = cv2.resize(cells, (size, size), interpolation=cv2.INTER_NEAREST)
    return cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)


def main():
    folder = Path(__file__).resolve().parents[1] / 'Tags'
    folder.mkdir(exist_ok=True)
    for tag_id in 1, 2, 3, 4:
        cv2.imwrite(str(folder / f'image_{tag_id}.jpg'), draw_tag(tag_id, 500))


if __name__ == '__main__':
    main()
