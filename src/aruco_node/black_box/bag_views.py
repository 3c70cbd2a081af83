"""Frames of a bag with the truth about them."""
from aruco_ar.base.errors import InputError
from aruco_bags.bag_reader import decoder_of, messages, pieces_of
from aruco_course.judge.recordings import agreed_views

from .graph import COMPRESSED, IMAGE

LEAST_S = 0.2  # from one frame to the next one that is looked at


def views_of_bag(path, topic):
    """Views of a bag's frames with four tags, spread over its length.

    ``topic``: that of the camera's raw images, if the bag has images of several. Raises InputError if the bag
    cannot be read, or has no such frame.
    """
    try:
        pieces, _ = pieces_of(path)
    except InputError as error:
        raise InputError('The bag "%s" cannot be used: %s' % (path, error)) from None
    cameras = sorted({piece.camera for piece in pieces})
    chosen = [piece for piece in pieces if piece.camera == topic or len(cameras) == 1]
    if not chosen:
        raise InputError('The bag "%s" has the images %s, but not %s; give camera:=TOPIC.'
                         % (path, ', '.join(cameras), topic))
    return agreed_views(_frames(chosen), path)


def _frames(pieces):
    last = None
    for piece in pieces:
        decode = decoder_of(piece)
        for message, time, is_in_piece in messages(piece):
            if is_in_piece and message._type in (IMAGE, COMPRESSED) \
                    and (last is None or (time - last).to_sec() >= LEAST_S):
                last = time
                yield decode(message)
