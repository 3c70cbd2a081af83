"""The QR code in the terminal."""
import re

import cv2
import numpy as np
from aruco_desk.qr import BLOCKS, qr_code

ADDRESS = 'https://192.168.1.20:8080'
LIGHT = {block: [not is_dark for is_dark in pair] for pair, block in BLOCKS.items()}


def test_a_phone_reads_what_the_terminal_shows():
    lines = [re.sub('\x1b[^m]*m', '', line) for line in qr_code(ADDRESS).splitlines()]
    rows = np.array([np.array([LIGHT[block] for block in line]).T for line in lines])
    image = np.uint8(rows.reshape(-1, len(lines[0]))) * 255
    text, _, _ = cv2.QRCodeDetector().detectAndDecode(image.repeat(8, 0).repeat(8, 1))
    assert text == ADDRESS
