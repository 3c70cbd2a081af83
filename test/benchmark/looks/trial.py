"""Ten pictures of bare ground. In five of them a tag is hidden. Who can tell which?

Look at the pictures, and write down the five. Then compare with key.txt. Who guesses has 5 of 10 right.
"""
import argparse
import os

import cv2
import numpy as np

from benchmark.real_clips.clips import CLIPS

from .spots import CORNERS, SPOTS, hidden, with_tag

COUNT = 10
OFF = 0.15          # a tag is off the middle of its spot by up to this, in sides of the tag
TURN = 0.5          # and is turned by up to this, rad
SHOWN_PX, SIDES = 150, 2.2  # half of the width of a picture, at most, in pixels of the frame and in sides
OFF_PX = 40         # the middle of a picture is off the tag's by up to this
SIZE_PX = 900       # width of the pictures


def pictures(folder, seed):
    """Yield (picture, name of the spot, whether a tag is hidden in it)."""
    random = np.random.RandomState(seed)
    spots = [(spot, spot.frame(folder)) for spot in SPOTS]
    spots = [(spot, frame) for spot, frame in spots if frame is not None]
    has_tag = random.permutation(COUNT) < COUNT // 2
    for number, chosen in enumerate(random.permutation(len(spots))[:COUNT]):
        spot, frame = spots[chosen]
        middle = spot.middle + random.uniform(-OFF, OFF, 2) * spot.side
        cosine, sine = np.cos(turn := random.uniform(-TURN, TURN)), np.sin(turn)
        if has_tag[number]:
            tagged, tag, _ = with_tag(frame, middle, 0.9 * spot.side,
                                      corners=CORNERS @ [[cosine, sine], [-sine, cosine]])
            frame = hidden(tagged, tag)
        half = int(min(SHOWN_PX, SIDES * spot.side))
        shown = middle + random.uniform(-OFF_PX, OFF_PX, 2)
        x, y = np.clip(shown, half, np.array(frame.shape[1::-1]) - half).astype(int)
        part = frame[y - half:y + half, x - half:x + half]
        yield cv2.resize(part, (SIZE_PX, SIZE_PX), interpolation=cv2.INTER_CUBIC), spot.name, has_tag[number]


def main():
    parser = argparse.ArgumentParser(prog='python3 -m benchmark.looks.trial', description=__doc__)
    parser.add_argument('folder', help='the folder for the pictures, which is made')
    parser.add_argument('--clips', default=CLIPS, help='the folder of the clips (default: the shared one)')
    parser.add_argument('--seed', type=int, default=0, help='another number gives other pictures (default: 0)')
    args = parser.parse_args()
    os.makedirs(args.folder, exist_ok=True)
    with open(os.path.join(args.folder, 'key.txt'), 'w') as key:
        for number, (picture, name, has_tag) in enumerate(pictures(args.clips, args.seed)):
            cv2.imwrite(os.path.join(args.folder, '%d.png' % number), picture)
            key.write('%d %s: %s\n' % (number, name, 'a tag is hidden' if has_tag else 'bare'))


if __name__ == '__main__':
    main()
