"""What the check of an exercise consists of. Each exercise's check.py makes one."""
from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Sequence

from aruco_ar.base.arrays import Booleans, Image
from aruco_ar.tags.tag import Tag


@dataclass(frozen=True)
class View:
    """A frame, (h, w, 3) BGR uint8, and the tags that are truly in it.

    ``picture``: where one is to be painted, that picture, (h, w, 3) BGR uint8. The function gets it after the
    frame.
    """

    frame: Image
    tags: tuple[Tag, ...]
    picture: Image | None = None

    @property
    def arguments(self) -> tuple[Image, ...]:
        """What the learner's function is called with."""
        return (self.frame,) if self.picture is None else (self.frame, self.picture)


@dataclass(frozen=True)
class Shown:
    """What the learner's code made of a View: an image for each of the check's outputs.

    ``number``: that of the frame, from 1. The images are as the code returned them: gray ones are (h, w), and
    all may be smaller than the frame, since the course shrinks it to 0.7.
    """

    number: int
    view: View
    images: tuple[Image, ...]

    @property
    def image(self) -> Image:
        """The last image: the frame with what was drawn."""
        return self.images[-1]


@dataclass(frozen=True)
class Fault:
    """The first thing that is wrong: a sentence or two, and where.

    ``place``: such as "Frame 12" or "Line 34", or nothing. ``shown``: the output that is wrong, if it is one.
    ``expected``: the image that would have been right, of the same size. ``marked``: (h, w) bool, where they
    differ.
    """

    what: str
    place: str = ''
    shown: Shown | None = None
    expected: Image | None = None
    marked: Booleans | None = None

    def __str__(self) -> str:
        first = self.what.split(' ', 1)[0]
        if re.search('.[A-Z]|[_.]', first):  # a name, such as OpenCV, cv2.imread and detect_tags
            what = self.what
        else:
            what = (self.what[:1].lower() if self.place else self.what[:1].upper()) + self.what[1:]
        return '%s: %s' % (self.place, what) if self.place else what


@dataclass(frozen=True)
class Written:
    """The image files that a learner's program wrote.

    ``folder``: that of the learner's package. ``paths``: the files, in the order in which they were written.
    ``refused``: the paths for which ``cv2.imwrite`` returned False, which nobody notices.
    ``elsewhere``: those that it wrote outside of this folder, and of that from which it was started.
    """

    folder: Path
    paths: tuple[Path, ...]
    refused: tuple[Path, ...] = ()
    elsewhere: tuple[Path, ...] = ()


Judge = Callable[[Sequence[Shown]], 'Fault | None']


@dataclass(frozen=True)
class Challenge:
    """What a right solution need not survive, but a good one does.

    ``name``: such as "no tag in sight". ``why``: why the course's own code fails there. ``views`` and
    ``judge``: as those of a Check.
    """

    name: str
    why: str
    views: Callable[[], Sequence[View]]
    judge: Judge


@dataclass(frozen=True)
class Exercise:
    """How an exercise is presented.

    ``number``: such as "5.4". ``minutes``: how long it takes. ``function``: the name of the learner's function
    of an image, or nothing if a program is asked for. ``task``: what is to be done, in a few sentences.
    ``hints``: three, each of which tells more.
    """

    number: str
    title: str
    minutes: int
    function: str
    task: str
    hints: tuple[str, str, str]

    @property
    def name(self) -> str:
        """That of the exercise's files, such as exercise5_4."""
        return 'exercise' + self.number.replace('.', '_')


@dataclass(frozen=True)
class Check(Exercise):
    """An exercise that asks for a function of an image, and how what it returns is judged.

    ``views``: makes the frames it is judged by. ``judge``: finds the first Fault in what was made of them.
    ``outputs``: the names of the images that the function returns, and of the topics on which its node
    publishes them; the frame with what was drawn is the last.
    """

    views: Callable[[], Sequence[View]]
    judge: Judge
    challenges: tuple[Challenge, ...] = ()
    outputs: tuple[str, ...] = ('image',)


@dataclass(frozen=True)
class ProgramCheck(Exercise):
    """An exercise that asks for a program, and how the files that it writes are judged.

    ``judge``: finds the first Fault in them.
    """

    judge: Callable[[Written], Fault | None]
