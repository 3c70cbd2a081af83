"""Reads from the source whether the encodings that cv_bridge is given fit together."""
from __future__ import annotations

import ast
import difflib
from typing import Sequence

from aruco_ar.base.arrays import Image

from aruco_course.check import Fault

from .names import called, text_of

COLORED = 'bgr8', 'rgb8'
KNOWN = frozenset([*COLORED, 'rgba8', 'bgra8', 'rgb16', 'bgr16', 'rgba16', 'bgra16', 'mono8', 'mono16',
                   'passthrough', 'yuv422', 'yuv422_yuy2',
                   *('bayer_%s%d' % (order, bits) for order in ('rggb', 'bggr', 'gbrg', 'grbg')
                     for bits in (8, 16)),
                   *('%s%s' % (kind, channels) for kind in ('8U', '8S', '16U', '16S', '32S', '32F', '64F')
                     for channels in ('C1', 'C2', 'C3', 'C4'))])


def fault_of_encodings(tree: ast.AST, calls: Sequence[ast.Call], outputs: Sequence[str], images: Sequence[Image]
                       ) -> Fault | None:
    """The first encoding that is none or does not fit; None if all may be right."""
    taken = [call for call in calls if called(call) in ('imgmsg_to_cv2', 'compressed_imgmsg_to_cv2')]
    given = [call for call in calls if called(call) == 'cv2_to_imgmsg']
    for call in [*taken, *given]:
        encoding = encoding_of(call)
        if encoding is not None and encoding not in KNOWN:
            near = difflib.get_close_matches(encoding.lower(), ['bgr8', 'rgb8', 'mono8'], 1, 0.5)
            return Fault('cv_bridge knows no encoding "%s". A colored image of OpenCV is "bgr8", a gray one '
                         '"mono8"%s.' % (
                encoding, '; is "%s" meant?' % near[0] if near else ''), at(call))
    return of_taken(tree, taken, given) or of_given(given, outputs, images)


def of_taken(tree: ast.AST, taken: Sequence[ast.Call], given: Sequence[ast.Call]) -> Fault | None:
    """A frame that the function gets in another encoding than it is judged with."""
    if not taken:
        return None
    encodings = {encoding_of(call, 'passthrough') for call in taken}
    converts = any('RGB' in name and 'BGR' in name for name in (
        one.attr if isinstance(one, ast.Attribute) else getattr(one, 'id', '') for one in ast.walk(tree)))
    out = {encoding_of(call) for call in given}
    if encodings == {'mono8'}:
        return Fault('the callback asks cv_bridge for a gray frame ("mono8"), but the function gets a colored '
                     'one when it is judged: "bgr8".', at(taken[0]))
    if converts:
        return None
    if (encodings == {'rgb8'} and 'bgr8' in out) or (encodings == {'bgr8'} and 'rgb8' in out):
        return Fault('the frame comes in as "%s" and goes out as "%s", so red and blue are exchanged. Take '
                     '"bgr8" for both.' % ((*encodings, *(out & set(COLORED)))[:2]), at(taken[0]))
    if encodings == {'passthrough'} and 'bgr8' in out:
        return Fault('imgmsg_to_cv2 is not told an encoding, so the frame comes as the camera '
                     'sends it, mostly with red first, and goes out as "bgr8": red and blue are '
                     'exchanged. Give it "bgr8".', at(taken[0]))
    return None


def of_given(given: Sequence[ast.Call], outputs: Sequence[str], images: Sequence[Image]) -> Fault | None:
    """An image that has not as many channels as the encoding it is published with."""
    for name, image in zip(outputs, images):
        alone = len(given) == 1 and len({each.ndim for each in images}) == 1  # such as one call in a loop
        of_name = [call for call in given if alone or (
            call.args and isinstance(call.args[0], ast.Name) and call.args[0].id == name)]
        for call in of_name:
            encoding = encoding_of(call)
            if image.ndim == 2 and encoding in COLORED:
                return Fault('your %s is gray, height x width, but it is published as "%s", and cv_bridge '
                             'refuses that. Draw on the colored image, or publish it as "mono8".'
                             % (name, encoding), at(call))
            if image.ndim == 3 and encoding == 'mono8':
                return Fault('your %s has three channels, but it is published as "mono8", and cv_bridge '
                             'refuses that: "bgr8".' % name, at(call))
    return None


def encoding_of(call: ast.Call, without: str | None = None) -> str | None:
    """The encoding that is written in a call, or None. ``without``: what it is if none is given."""
    if len(call.args) > 1:
        return text_of(call.args[1])
    for keyword in call.keywords:
        if keyword.arg in ('desired_encoding', 'encoding'):
            return text_of(keyword.value)
        if keyword.arg is None:
            return None
    return without


def at(call: ast.Call) -> str:
    """The place of a call."""
    return 'Line %d' % call.lineno
