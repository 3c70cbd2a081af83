"""What to say of what the learner's function returned, if it is not what it should be."""
from __future__ import annotations

import ast
from typing import Any, Sequence

import numpy as np
from aruco_ar.base.arrays import Image

from aruco_course.check import Fault
from aruco_course.trial.names import read_tree, top_functions

ROUNDING = 1.5  # pixels by which a side may differ from that of a frame shrunk with the same proportions


def fault_of_value(what: dict[str, Any], names: Sequence[str], number: int, path: str, function: str) -> Fault:
    """Of what is no image, or not as many as there should be. ``what``: as in inside/describe.py."""
    kind = str(what['type'])
    place = 'Frame %d' % number
    wanted = 'return %s' % ', '.join(names)
    if kind == 'NoneType':
        definition = top_functions(read_tree(path)).get(function)
        if definition and not any(isinstance(node, ast.Return) and node.value for node in ast.walk(definition)):
            return Fault('%s returns nothing: it lacks the line "%s" at its end, with the names that the '
                         'result has in your code.' % (function, wanted), 'Line %d' % definition.lineno)
        return Fault('%s returned None here. Each way through the function must end with '
                     '"%s".' % (function, wanted),
                     place)
    if kind in ('generator', 'coroutine'):
        return Fault('%s returns a %s, since %s. It must return the image itself.' % (
            function, kind, 'there is a yield in it' if kind == 'generator' else 'it is an async function'),
                         place)
    items = what.get('items')
    if items is None or (len(names) == 1 and kind == 'list' and len(items) != 1):
        if len(names) > 1 and kind == 'ndarray':
            return Fault('%s returned one image, but there should be %d: "%s".'
                         % (function, len(names), wanted), place)
        return Fault('%s returned %s' % (function, of_one(what)), place)
    if len(names) == 1:
        if len(items) == 1 and items[0]['type'] == 'ndarray':
            return Fault('%s returned the image in a %s. Is there a comma, or a bracket, too many after return?'
                         % (function, kind), place)
        return Fault('%s returned %d values, but there should be one: "%s".'
                     % (function, what['length'], wanted), place)
    if what['length'] != len(names):
        return Fault('%s returned %d values, but there should be %d: "%s".' % (
            function, what['length'], len(names), wanted), place)
    for name, item in zip(names, items):
        if not is_fine(item):
            return Fault('%s returned as %s %s' % (function, name, of_one(item)), place)
    return Fault('%s returned what is no image.' % function, place)


def is_fine(what: dict[str, Any]) -> bool:
    """Whether it is an image as it should be."""
    shape = what.get('shape', ())
    return what.get('dtype') == 'uint8' and min(shape, default=0) > 0 and (
        len(shape) == 2 or (len(shape) == 3 and shape[2] in (1, 3)))


def of_one(what: dict[str, Any]) -> str:
    """What one value is that is no image, and what helps."""
    kind = str(what['type'])
    if kind != 'ndarray':
        return of_other(what, kind)
    shape = what['shape']
    dtype = str(what['dtype'])
    if len(shape) not in (2, 3) or not min(shape):
        if len(shape) == 2 or len(shape) == 3 or not shape:
            if not shape:
                return 'a single number, not an image.'
            return 'an empty array, of the shape %s.' % (tuple(shape),)
        return 'an array of the shape %s, which is no image: that is height x width x 3.' % (tuple(shape),)
    if shape[-1] == 2 or (len(shape) == 2 and shape[0] <= 4 and shape[1] <= 4):
        return ('an array of the shape %s, which looks like points or a matrix, not like an image.'
                % (tuple(shape),))
    if len(shape) == 3 and shape[2] == 4:
        return 'an image of four channels. Leave out the last, the opacity: image[:, :, :3].'
    if len(shape) == 3 and shape[2] not in (1, 3):
        return 'an array of the shape %s. An image is height x width x 3, or height x width.' % (tuple(shape),)
    if dtype == 'bool':
        return 'an image of True and False. Make it one of 0 and 255: image.astype(np.uint8) * 255.'
    if dtype.startswith('float'):
        low, high = what.get('low', 0), what.get('high', 0)
        times = ' * 255' if low >= 0 and high <= 1 else ''
        return ('an image of %s, with numbers from %.3g to %.3g. It must be one of uint8, from 0 to 255: '
                '%s.astype(np.uint8).' % (dtype, low, high, '(image%s)' % times if times else 'image'))
    if dtype != 'uint8':
        return 'an image of %s. It must be one of uint8: image.astype(np.uint8).' % dtype
    return 'an image of %d x %d pixels, which is far too large.' % (shape[1], shape[0])


def of_other(what: dict[str, Any], kind: str) -> str:
    """What a value is that is no array."""
    if kind == 'UMat':
        return 'a cv2.UMat, not an array: image.get() makes one of it.'
    if str(what['module']).startswith('PIL'):
        return 'an image of Pillow, not an array: np.array(image) makes one of it, with red first.'
    if kind == 'NoneType':
        return 'None, not an image.'
    if 'length' in what:
        return 'a %s of %d things, not an image.' % (kind, what['length'])
    if 'value' in what:
        return '%s, not an image.' % what['value']
    return 'a thing of the type %s, not an image.' % kind


def fault_of_images(images: Sequence[Image], names: Sequence[str], frame: tuple[int, ...] | None, number: int
                    ) -> Fault | None:
    """What is wrong with the sizes of images, and with their order. ``frame``: the frame's shape, if any."""
    place = 'Frame %d' % number
    for name, image in zip(names, images):
        what = of_size(image.shape[:2], frame[:2]) if frame else ''
        if frame and what:
            return Fault('your %s is %d x %d pixels, and the frame is %d x %d: %s' % (
                name, image.shape[1], image.shape[0], frame[1], frame[0], what), place)
    if len(images) > 1 and len({image.shape[:2] for image in images}) > 1:
        return Fault('your %s differ in size: %s. If the image is resized, make the other one after that, such '
                     'as np.zeros_like(image).' % (' and '.join(names), ' and '.join(
                         '%d x %d pixels' % image.shape[1::-1] for image in images)), place)
    if len(images) == 2 and names[0] == 'mask' and is_black_or_white(images[1]) \
            and not is_black_or_white(images[0]):
        return Fault('mask and image are returned in the wrong order: "return %s".' % ', '.join(names), place)
    return None


def of_size(size: Sequence[int], frame: Sequence[int]) -> str:
    """Why a size is none of a frame that was only shrunk or enlarged, or ''. Both: height, width."""
    height, width = size
    if (abs(width - height * frame[1] / frame[0]) <= ROUNDING
            or abs(height - width * frame[0] / frame[1]) <= ROUNDING):
        return ''
    if (abs(height - width * frame[1] / frame[0]) <= ROUNDING
            or abs(width - height * frame[0] / frame[1]) <= ROUNDING):
        return ("width and height are exchanged. An array's shape is height first, but cv2.resize and "
                'cv2.warpPerspective take the width first.')
    if width == frame[1] or height == frame[0]:
        return 'a part of it is missing, or something was added to it.'
    return 'the proportions are not those of the frame.'


def is_black_or_white(image: Image) -> bool:
    """Whether nearly all of an image is either black or white, and it has both."""
    black, white = np.count_nonzero(image == 0), np.count_nonzero(image == 255)
    return bool(black and white and black + white >= 0.98 * image.size)
