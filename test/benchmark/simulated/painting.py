"""How exactly a picture is warped into its area, how it shimmers, and what that costs beside OpenCV's warp."""
import glob
import os

import cv2
import numpy as np
from aruco_ar import Area, area_mask
from aruco_ar.base.progress import progress
from aruco_ar.painting.paint import warp
from aruco_ar.painting.picture import Picture
from aruco_ar.painting.place import find_place
from rig import PACKAGE

from .speed import timed

PHOTOS = 'street.png', '33369213973_9d9bb4cc96_c.jpg'  # of the folder beside the package, if it is there
WIDTH, HEIGHT = 960, 720
AREAS = {
    'head-on': [[120, 80], [840, 80], [840, 600], [120, 600]],
    'small': [[400, 300], [580, 300], [580, 420], [400, 420]],
    'larger than the frame': [[-400, -300], [1400, -300], [1400, 1040], [-400, 1040]],
    'slanted': [[200, 60], [460, 220], [460, 440], [200, 640]],
    'very slanted': [[200, 60], [300, 220], [300, 440], [200, 640]],
    'on the floor': [[360, 300], [600, 300], [880, 460], [80, 460]],
    'tilted': [[320, 80], [800, 300], [600, 660], [120, 420]],
    'turned, slanted': [[300, 120], [520, 300], [660, 600], [400, 400]],
    'on a corner': [[480, 80], [760, 360], [480, 640], [200, 360]]}
SHIFT_PX = 0.3
SQUARE = 8   # the exact mean of a pixel is that of this many samples each way
RIM_PX = 3
TURNS = 15


def run():
    """Print the table."""
    cv2.setNumThreads(1)
    print('Against the exact mean of what each pixel covers, in dB; how much pixels change, in gray levels,\n'
          'when the area moves by %.1f px (shimmer); and the time of cv2.warpPerspective on the same window\n'
          'that ours takes.\n'
          % SHIFT_PX)
    print('%-9s %-22s %9s %9s   %9s %9s %9s   %9s' % (
        'picture', 'area', 'OpenCV dB', 'ours dB', 'shimmer', 'OpenCV', 'ours', 'time'))
    cases = [(name, picture, area) for name, picture in pictures() for area in AREAS]
    rows = [(name, area, measure(picture, np.float64(AREAS[area])))
            for name, picture, area in progress(cases, 'painting')]
    for name, area, row in rows:
        print('%-9s %-22s %9.1f %9.1f   %9.2f %9.2f %9.2f   %9.2f' % (name, area, *row))
    mean = np.mean([row for _, _, row in rows], axis=0)
    print('%-9s %-22s %9.1f %9.1f   %9.2f %9.2f %9.2f   %9.2f' % ('mean', '', *mean))


def pictures():
    """(name, picture) for each of them."""
    yield 'Earth', cv2.imread(os.path.join(PACKAGE, 'images', 'earth.jpg'))
    yield 'text', text()
    for name in PHOTOS:
        for path in glob.glob(os.path.join(PACKAGE, '..', 'shared', 'photos', name)):
            yield ('street' if name == PHOTOS[0] else 'photo'), cv2.imread(path)


def text():
    """A page of small print."""
    page, random, foot = np.full((800, 1200, 3), 255, np.uint8), np.random.RandomState(1), 20
    while foot < len(page):
        size = random.choice([0.4, 0.6, 0.9])
        line = ''.join(map(chr, random.randint(48, 122, 120)))
        cv2.putText(page, line, (5, foot), 0, size, (int(random.randint(90)),) * 3, 1, cv2.LINE_AA)
        foot += int(30 * size) + 4
    return page


def measure(picture, area):
    """dB of OpenCV's warp and of ours; shimmer of the exact mean, OpenCV's and ours; our share of its time."""
    moved, white = area + (SHIFT_PX, 0), np.full((HEIGHT, WIDTH), 255, np.uint8)
    inside = cv2.erode(area_mask(white, Area(np.float32(area))), np.ones((2 * RIM_PX + 1,) * 2)) == 255
    kept, ways = Picture(picture), [homography(picture, each) for each in (area, moved)]
    exact = [exact_mean(picture, way, inside) for way in ways]
    plain = [np.asarray(opencv(picture, way)[inside], float) for way in ways]
    ours = [np.asarray(warp(kept, way, white)[inside], float) for way in ways]
    errors = [10 * np.log10(255**2 / ((each[0] - exact[0])**2).mean()) for each in (plain, ours)]
    shimmer = [np.abs(each[1] - each[0]).mean() for each in (exact, plain, ours)]
    return (*errors, *shimmer, cost(picture, area))


def homography(picture, area):
    height, width = picture.shape[:2]
    return Area(np.float32(area)).homography(width, height)


def opencv(picture, to_frame, size=(WIDTH, HEIGHT)):
    return cv2.warpPerspective(picture, to_frame, size, borderMode=cv2.BORDER_REPLICATE)


def exact_mean(picture, to_frame, inside):
    """(n, 3) float, for each pixel inside the mean of SQUARE x SQUARE samples of what it covers."""
    to_picture, total = np.linalg.inv(to_frame), 0
    row, column = np.nonzero(inside)
    steps = (np.arange(SQUARE) + 0.5) / SQUARE - 0.5
    for right in steps:
        for down in steps:
            u, v, scale = to_picture @ [column + right, row + down, np.ones(len(row))]
            # OpenCV's maps have at most 32767 rows.
            places = np.zeros((-(-len(row) // WIDTH), WIDTH, 2), np.float32)
            places.reshape(-1, 2)[:len(row)] = np.stack([u / scale, v / scale], axis=1)
            total = total + np.float64(cv2.remap(picture, places, None, cv2.INTER_LINEAR,
                                                 borderMode=cv2.BORDER_REPLICATE)).reshape(-1, 3)[:len(row)]
    return total / SQUARE**2


def cost(picture, area):
    """The median time of our warp, as a share of that of OpenCV's into the same window; they take turns."""
    place = find_place(np.zeros((HEIGHT, WIDTH, 3), np.uint8), Area(np.float32(area)), picture)
    kept, size = Picture(picture), place.mask.shape[1::-1]
    times = [(timed(warp, kept, place.homography, place.mask)[0],
              timed(opencv, picture, place.homography, size)[0]) for _ in range(TURNS + 1)]
    ours, plain = np.median(times[1:], axis=0)
    return ours / plain
