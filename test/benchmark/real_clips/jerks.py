"""A real clip in which the camera jerks now and then: it turns within two frames, and slowly back.

The two frames are smeared: each is the mean of what is seen while it is exposed. The tags, the paper and the
light are real, and the truth is known.
"""
import cv2
import numpy as np

EVERY, FIRST = 16, 4    # a jerk begins in frame FIRST, and every so many frames after that
RISE, FALL = 2, 10      # how many frames it takes, there and back
WIDTHS, ROLL = 0.047, 0.01  # how far the camera turns: widths of the frame, and rad about its axis
EXPOSURE, VIEWS = 0.5, 13   # the time of exposure, in frames, and how many views of it are averaged
SMEARED_PX = 8          # a frame in which a pixel moves farther than this is smeared


def _swing(time):
    """How far the camera has turned, 0 to 1, at a time in frames."""
    passed = time % EVERY - FIRST
    if passed < 0:
        return 0.0
    if passed < RISE:
        return passed / RISE
    return 0.5 + 0.5 * np.cos(np.pi * min((passed - RISE) / FALL, 1))


def _homography(time, width, height, directions):
    """(3, 3): where the camera then sees the pixels of the frame."""
    far, direction = _swing(time), directions[int(time // EVERY)]
    turn = cv2.getRotationMatrix2D((width / 2, height / 2), np.degrees(ROLL * far), 1)
    turn[:, 2] += WIDTHS * width * far * np.array([np.cos(direction), np.sin(direction)])
    return np.vstack([turn, [0, 0, 1]])


def with_jerks(frames, truth):
    """(frames, truth, smeared): of a clip with jerks; the last is (n,) bool, the frames that are smeared.

    ``frames``: a list of (h, w, 3). ``truth``: (n, 4, 2) pixels, NaN where unknown.
    """
    height, width = frames[0].shape[:2]
    directions = np.random.RandomState(0).uniform(0, 2 * np.pi, len(frames) // EVERY + 2)
    jerked, corners, smeared = [], [], []
    for number, (frame, quad) in enumerate(zip(frames, truth)):
        views = [_homography(number + passed, width, height, directions)
                 for passed in np.linspace(0, EXPOSURE, VIEWS)]
        moved = np.abs(views[-1][:2, 2] - views[0][:2, 2]).max()
        if moved < 0.05:
            views = views[:1]
        mean = np.mean([cv2.warpPerspective(frame, view, (width, height), borderMode=cv2.BORDER_REPLICATE)
                        for view in views], axis=0, dtype=np.float32)
        jerked.append(np.round(mean).astype(np.uint8))
        corners.append(np.mean([cv2.perspectiveTransform(quad[None], view)[0] for view in views], axis=0))
        smeared.append(moved > SMEARED_PX)
    return jerked, np.array(corners), np.array(smeared)
