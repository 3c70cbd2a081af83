"""How exercise 5.5 is presented and judged: the mask is white in the area, and the image is black there."""
from __future__ import annotations

from dataclasses import replace
from typing import Sequence

import cv2
import numpy as np
from aruco_ar.base.arrays import Booleans, Image

from aruco_course.check import Check, Fault, Shown
from aruco_course.judge.area_challenges import area_challenges, untouched
from aruco_course.judge.areas import (
    Sight,
    changed,
    fill,
    is_outline,
    likeness,
    sight_of,
    where,
    why_not,
)
from aruco_course.judge.drawing import as_bgr, brightest, darkest, place_of
from aruco_course.judge.views import area_views

WHITE, BLACK = 250, 5  # gray levels from which on, and up to which, a pixel is
WRONG = 0.005          # share of the area's size that may be wrong
TOUCHED = 0.0005       # share of the frame that may be changed outside of the area
MOST = 0.95            # share of the pixels of a part that tells what the part looks like

TASK = (
    "Make a mask: an image as large as the camera's that is white in the area between the four tags, and black "
    "elsewhere. Subtract it from the camera's image, so that the area becomes black. Return both, the mask "
    'first. Without four tags, the mask is black, and the image stays as it is.')

HINTS = (
    ('The mask begins black: np.zeros_like(image). The polygon of exercise 5.4, filled with white, is drawn on '
     'the mask. The image is not drawn on.'),
    ('cv2.fillConvexPoly(mask, points, (255, 255, 255)) fills a polygon whose points are in order; they are '
     'integers of np.int32. White minus 255 is black, and a pixel minus 0 is what it was. cv2.subtract stops '
     "at 0, while NumPy's minus begins again at 255."),
    ('With the centers in order, there are two lines left: cv2.fillConvexPoly(mask, ordered.astype(np.int32), '
     '(255, 255, 255)) and image = cv2.subtract(image, mask).'),
)


def judge(shown: Sequence[Shown]) -> Fault | None:
    """The first Fault in masks and images of Views with four tags each."""
    before: list[Sight] = []
    for one in shown:
        sight = sight_of(one)
        fault = (_sizes_fault(one, sight) or _exchange_fault(one, sight) or _mask_fault(one, sight, before)
                 or _image_fault(one, sight, before))
        if fault is not None:
            return fault
        before.append(sight)
    return None


def judge_none(shown: Sequence[Shown]) -> Fault | None:
    """The first Fault in masks and images of Views without an area: they are black, and the frame."""
    for one in shown:
        mask = as_bgr(one.images[0])
        if np.any(mask > BLACK):
            return Fault('There is no area, since there are not four different tags. So nothing of the mask is '
                         'white.',
                         place_of(one), replace(one, images=(one.images[0],)), np.zeros_like(mask),
                         brightest(mask) > BLACK)
    return untouched(shown)


def _sizes_fault(shown: Shown, sight: Sight) -> Fault | None:
    mask, image = shown.images
    if mask.shape[:2] != image.shape[:2]:
        (mask_height, mask_width), (height, width) = mask.shape[:2], image.shape[:2]
        return Fault('Your mask is %d pixels wide and %d high, but your image is %d wide and %d high. Both '
                     'have the same size. If you shrink the image, make the mask after that: '
                     'np.zeros_like(image).' % (mask_width, mask_height, width, height), place_of(shown))
    fault = sight.drawing.fault
    return fault if fault is not None and 'wide' in fault.what else None


def _exchange_fault(shown: Shown, sight: Sight) -> Fault | None:
    """The Fault that the two outputs are returned in the other order."""
    first, last = (as_bgr(image) for image in shown.images)
    if likeness(_white(last), fill(sight.shape, sight.area) > 0) > 0.8 and likeness(
            _white(first), fill(sight.shape, sight.area) > 0) < 0.5 and np.mean(brightest(last) <= BLACK) > 0.3:
        return Fault('You return the image first, and the mask last: it is the other way '
                     'around.', place_of(shown),
                     shown)
    return None


def _white(image: Image) -> Booleans:
    return darkest(image) >= WHITE


def _mask_fault(shown: Shown, sight: Sight, before: Sequence[Sight]) -> Fault | None:
    mask = as_bgr(shown.images[0])
    expected = cv2.cvtColor(fill(sight.shape, sight.area), cv2.COLOR_GRAY2BGR)
    not_white, not_black = ~_white(mask) & sight.inside, (brightest(mask) > BLACK) & sight.outside
    if np.count_nonzero(not_white | not_black) <= WRONG * np.count_nonzero(sight.inside):
        return None

    def fault(what: str) -> Fault:
        return Fault(what, place_of(shown), replace(shown, images=(shown.images[0],)), expected,
                     not_white | not_black)

    lit = brightest(mask) > BLACK
    if not mask.any():
        return fault('Your mask is black all over. Fill the area in it with white, (255, 255, 255).')
    if np.all(mask <= 1):
        return fault('Your mask is 1 where it is white. White is 255: 1 is as good as black, and so is what is '
                     'subtracted.')
    if np.mean(_white(mask)) > 0.99:
        return fault('Your mask is white all over. Only the area is white, and everything else is black.')
    if np.mean(changed(mask, sight.drawing.frame)[sight.outside]) < 0.1 or np.mean(
            changed(mask, _resized(shown.view.frame, mask))[sight.outside]) < 0.1:
        return fault("Your mask shows the camera's image. Draw the area on an image of its own, which begins "
                     'black: np.zeros_like(image).')
    if likeness(~lit, fill(sight.shape, sight.area) > 0) > 0.9:
        return fault('Your mask is the wrong way around: it is black in the area, and white elsewhere.')
    if is_outline(lit, sight):
        return fault('Only the outline of the area is drawn in your mask. Fill it, as cv2.fillConvexPoly does, '
                     'or cv2.drawContours with a thickness of -1.')
    why = '' if likeness(lit, fill(sight.shape, sight.area) > 0) > 0.97 else why_not(lit, sight, before)
    if why:
        return fault('The area in your mask is not the right one. Its rim %s' % why)
    color = np.median(mask[lit & sight.inside], axis=0) if np.any(lit & sight.inside) else np.zeros(3)
    if (color.min() < WHITE and np.mean(lit[sight.inside]) > MOST
            and np.mean(not_black[sight.outside]) <= WRONG):
        return fault('The area in your mask has the color (%d, %d, %d). White is (255, 255, 255): only what is '
                     'subtracted of all three makes black.' % tuple(color))
    if np.mean(lit) < 0.01:
        return fault('Hardly anything of your mask is white: fill the whole polygon through the four centers. '
                     'cv2.fillPoly and cv2.drawContours take a list of polygons: [points].')
    if np.count_nonzero(not_black) > np.count_nonzero(not_white):
        return fault('Your mask is also white outside of the area, %s of it.' % where(not_black, sight))
    return fault('Your mask is not white in all of the area: something is missing '
                 '%s.' % where(not_white, sight))


def _resized(frame: Image, like: Image) -> Image:
    return frame if frame.shape == like.shape else cv2.resize(frame, like.shape[1::-1],
                                                              interpolation=cv2.INTER_AREA)


def _image_fault(shown: Shown, sight: Sight, before: Sequence[Sight]) -> Fault | None:
    image, frame = sight.drawing.image, sight.drawing.frame
    expected = np.where(fill(sight.shape, sight.area)[..., None] > 0, 0, frame).astype(np.uint8)
    free = sight.near_tags
    dark = brightest(image) <= 3 * BLACK
    not_black = ~dark & sight.inside & ~free
    touched = changed(image, frame) & sight.outside & ~free
    inside_wrong = np.count_nonzero(not_black) > WRONG * np.count_nonzero(sight.inside)
    if not inside_wrong and np.count_nonzero(touched) <= TOUCHED * touched.size:
        return None

    def fault(what: str) -> Fault:
        return Fault(what, place_of(shown), shown, expected, not_black | touched)

    area, rest = sight.inside & ~free, sight.outside & ~free
    inside = _look(image, frame, area)
    outside = 'same' if np.mean(touched[rest]) < 1 - MOST else _look(image, frame, rest)
    if inside == 'black' and outside == 'black':
        return fault('Your image is black all over. Only the area should be.')
    if outside == 'black' and inside == 'same':
        return fault('Only the area is left of your image, and the rest is black. It is the other way around: '
                     'cv2.subtract(image, mask).')
    if inside == 'inverted' and outside in ('black', 'inverted', 'wrapped down'):
        return fault('You subtract the image from the mask. Subtract the mask from the image: '
                     'cv2.subtract(image, mask).')
    if outside == 'inverted':
        return fault('Your image is a negative outside of the area, where it should stay as it is.')
    if outside == 'same':
        sentence = {
            'wrapped': "The area is hardly changed, since NumPy's minus begins again at 255 if the result is "
                       'below 0. cv2.subtract(image, mask) stops at 0.',
            'same': 'The area is not black in your image: nothing is subtracted there. Is it what cv2.subtract '
                    'returns that you return?',
            'white': 'The area is white in your image: the mask was added. Subtract it.',
            'inverted': 'The area is a negative in your image, as from cv2.absdiff. cv2.subtract stops at 0, '
                        'which is black.',
            'channels': 'The area is not black in your image, since not all of blue, green and red are '
                        'subtracted.',
            'color': 'The area has a color in your image. Subtract the mask, and draw nothing on the image: '
                     'then it is black.',
            'darker': 'The area is only darker in your image. Subtract 255 of each pixel to make it black.',
        }.get(inside, '')
        if sentence:
            return fault(sentence)
    if sight.drawing.fault is not None:
        return sight.drawing.fault
    black = dark & ~(brightest(frame) <= 3 * BLACK)
    if outside != 'same' or inside_wrong:
        closed = cv2.morphologyEx(black.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
        why = why_not(closed > 0, sight, before)
        if why:
            return fault('The area that is black in your image is not that of your mask. Its rim %s' % why)
    if inside_wrong and np.count_nonzero(not_black) >= np.count_nonzero(touched):
        return fault('The area is not black everywhere in your image: something is left '
                     '%s.' % where(not_black, sight))
    return fault('Your image is changed outside of the area, too, %s of it. Only the area becomes black.'
                 % where(touched, sight))


def _look(image: Image, frame: Image, part: Booleans) -> str:
    """What a part, (h, w), of the image looks like, compared with the frame."""
    seen, was = image[part].astype(int), frame[part].astype(int)

    def most(right: Booleans) -> bool:
        return bool(np.mean(right) > MOST)

    if most(seen.max(axis=1) <= 3 * BLACK):
        return 'black'
    if most(seen.min(axis=1) >= WHITE):
        return 'white'
    if most(np.all(seen == (was + 1) % 256, axis=1)):
        return 'wrapped'
    if most(np.all(np.abs(seen - (-was) % 256) <= 1, axis=1)):
        return 'inverted'
    if most(~changed(image, frame)[part]):
        return 'same'
    if all(most(np.abs(now - then) <= 1) or most(now <= 3 * BLACK) for now, then in zip(seen.T, was.T)):
        return 'channels'
    if most(np.all(np.abs(seen - np.median(seen, axis=0)) <= 3, axis=1)):
        return 'color'
    if most(np.all(seen <= was + 3, axis=1)) and np.mean(seen <= 3 * BLACK) < 0.2:
        return 'darker'
    return ''


CHECK = Check('5.5', 'Subtract the area', 20, 'subtract_area', TASK, HINTS, area_views, judge,
              area_challenges(judge, judge_none, judge), ('mask', 'image'))
