"""Whether a learner's file is right: what it is judged by, and the picture that shows it."""
from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Iterator, Sequence

import cv2
import numpy as np
from aruco_ar import InputError
from aruco_ar.base.arrays import Image

from .check import Challenge, Check, Exercise, Fault, ProgramCheck, Shown, View, Written
from .judge.recordings import recorded_views
from .judge.tag_files import image_files
from .judge.verdict_picture import verdict_picture
from .trial import Trial, fault_of_plumbing, fault_of_source, fault_of_speed, run_function, run_program

MAX_PRINTED = 2000  # characters
MOST_FILES, FILE_PX, GAP_PX, WHITE = 4, 240, 20, (255, 255, 255)  # of a picture of files


@dataclass
class Verdict:
    """What is to be said of a learner's file.

    ``fault``: the first thing that is wrong; None if nothing is. ``picture``: (h, w, 3) BGR uint8, what is
    expected beside what the code shows; what it shows alone if that is right; None if it shows nothing.
    ``printed``: what the code printed, or the beginning. ``seconds``: how long the verdict took.
    ``challenges``: what else was tried, and what went wrong there; see ``try_challenges``.
    """

    check: Exercise
    fault: Fault | None
    picture: Image | None = None
    printed: str = ''
    seconds: float = 0.0
    challenges: list[tuple[Challenge, Fault | None]] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether it is right. Challenges are not asked for."""
        return self.fault is None


def judge_exercise(check: Exercise, folder: str, with_challenges: bool = True) -> Verdict:
    """Judge the file of an exercise in a learner's package. It runs in a process of its own, with limits."""
    began = time.monotonic()
    path = Path(folder, 'src', check.name + '.py')
    fault = fault_of_source(str(path), check)
    if fault is not None:
        verdict = Verdict(check, fault)
    elif isinstance(check, ProgramCheck):
        verdict = _judge_program(check, path)
    else:
        assert isinstance(check, Check)
        verdict = _judge_function(check, path)
    verdict.seconds = time.monotonic() - began
    if with_challenges and verdict.passed:
        verdict.challenges = list(try_challenges(check, folder))
    return verdict


def try_challenges(check: Exercise, folder: str) -> Iterator[tuple[Challenge, Fault | None]]:
    """What of an exercise's challenges the learner's code does not survive, one after the other."""
    challenges = getattr(check, 'challenges', ())
    if not challenges:
        return
    assert isinstance(check, Check)
    path = Path(folder, 'src', check.name + '.py')
    left = list(challenges)
    while left:
        # One run for all that are left: starting a process takes longest. If the code fails at one of them,
        # the run ends there, and another is made for those after it.
        views = [list(challenge.views()) for challenge in left]
        trial = _run(check, path, [view for each in views for view in each])
        done = 0
        for challenge, own in zip(list(left), views):
            images = trial.images[done:done + len(own)]
            done += len(own)
            left.remove(challenge)
            if len(images) < len(own):
                yield challenge, trial.fault or Fault('it returned nothing')
                break
            yield challenge, challenge.judge(_shown(own, images))


def _judge_function(check: Check, path: Path) -> Verdict:
    views = check.views()
    trial = _run(check, path, views)
    shown = _shown(views, trial.images)
    fault = trial.fault or check.judge(shown) or fault_of_plumbing(str(path), check, trial.images[0]) \
        or fault_of_speed(trial)
    picture = verdict_picture(fault, shown[0] if shown else None)
    return Verdict(check, fault, picture, trial.printed[:MAX_PRINTED])


def judge_recording(check: Exercise, folder: str, recording: str) -> Verdict:
    """Judge the function of an exercise by recorded frames: a video, a picture, or a folder of pictures.

    Raises InputError if the exercise has no frames, or if no frame of the recording can be used.
    """
    if not isinstance(check, Check):
        raise InputError('Exercise %s looks at no frames.' % check.number)
    picture = check.views()[0].picture
    views = [replace(view, picture=picture) for view in recorded_views(recording)]
    trial = _run(check, Path(folder, 'src', check.name + '.py'), views)
    shown = _shown(views, trial.images)
    fault = trial.fault or check.judge(shown)
    return Verdict(check, fault, verdict_picture(fault, shown[0] if shown else None))


def _judge_program(check: ProgramCheck, path: Path) -> Verdict:
    """Run the program where it is, but from an empty folder, as one may start it from anywhere."""
    folder = path.parent.parent
    with tempfile.TemporaryDirectory() as name:
        elsewhere = Path(name)
        before = image_files(folder)
        trial = run_program(str(path), cwd=name)
        after = {**image_files(folder), **image_files(elsewhere)}
        # Older files are not taken for what it writes: one of the same content has another time.
        written = sorted((each for each in after if after[each] != before.get(each)), key=after.__getitem__)
        # If nothing calls main, this says more than that nothing was written.
        fault = trial.fault or fault_of_plumbing(str(path), check) \
            or check.judge(Written(folder, tuple(written), tuple(map(Path, trial.refused)),
                                   tuple(path for path in map(Path, trial.written) if path.parent != elsewhere
                                         and folder not in path.parents)))
        picture = _side_by_side(written)
    return Verdict(check, fault, picture, trial.printed[:MAX_PRINTED])


def _run(check: Check, path: Path, views: Sequence[View]) -> Trial:
    return run_function(str(path), check.function, [view.arguments for view in views], outputs=check.outputs)


def _side_by_side(paths: Sequence[Path]) -> Image | None:
    """The first images that the program wrote, small, in a row; None if there are none."""
    images = [cv2.imread(str(path)) for path in paths[:MOST_FILES]]
    small = [cv2.copyMakeBorder(cv2.resize(image, (FILE_PX, FILE_PX), interpolation=cv2.INTER_AREA),
                                GAP_PX, GAP_PX, GAP_PX, GAP_PX, cv2.BORDER_CONSTANT, value=WHITE)
             for image in images if image is not None]
    return np.hstack(small) if small else None


def _shown(views: Sequence[View], images: Sequence[tuple[Image, ...]]) -> list[Shown]:
    return [Shown(number, view, each) for number, (view, each) in enumerate(zip(views, images), start=1)]
