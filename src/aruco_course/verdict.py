"""Whether a learner's file is right: what it is judged by, and the picture that shows it."""
from __future__ import annotations

import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Iterator, Sequence

from aruco_ar.base.arrays import Image

from .check import Challenge, Check, Exercise, Fault, ProgramCheck, Shown, View, Written
from .learner.package import HIDDEN
from .judge.verdict_picture import verdict_picture
from .trial import Trial, fault_of_plumbing, fault_of_source, run_function, run_program

CAMERA_S = 1 / 30     # between two frames of the robot's camera
MUCH_SLOWER = 5       # times as long as OpenCV needs to find the tags: then it is not the machine that is slow
MAX_PRINTED = 2000    # characters
ENDINGS = '.jpg', '.jpeg', '.png', '.bmp', '.gif', '.tif', '.tiff', '.webp', '.ppm', '.pgm'


@dataclass
class Verdict:
    """What is to be said of a learner's file.

    ``fault``: the first thing that is wrong; None if nothing is. ``picture``: (h, w, 3) BGR uint8, what is
    expected beside what the code shows; what it shows alone if that is right; None if it shows nothing.
    ``printed``: what the code printed, or the beginning. ``seconds``: how long the verdict took. ``notes``:
    sentences on what is right, but could be better. ``challenges``: what else was tried, and what went wrong
    there; see ``try_challenges``.
    """

    check: Exercise
    fault: Fault | None
    picture: Image | None = None
    printed: str = ''
    seconds: float = 0.0
    notes: list[str] = field(default_factory=list)
    challenges: list[tuple[Challenge, Fault | None]] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether it is right. Challenges are not asked for."""
        return self.fault is None


def judge_exercise(check: Exercise, folder: str, with_challenges: bool = True) -> Verdict:
    """Judge the file of an exercise in a learner's package. It runs in a process of its own, with limits."""
    began = time.monotonic()
    path = Path(folder, 'src', check.name + '.py')
    fault = fault_of_source(path, check)
    if fault is not None:
        verdict = Verdict(check, fault)
    elif isinstance(check, ProgramCheck):
        verdict = _judge_program(check, path)
    else:
        assert isinstance(check, Check)
        verdict = _judge_function(check, path)
    if verdict.passed:
        verdict.fault = fault_of_plumbing(path, check)
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
    fault = trial.fault or check.judge(shown)
    verdict = Verdict(check, fault, _picture(check, fault, shown), trial.printed[:MAX_PRINTED])
    if fault is None:
        verdict.notes += _slowness(trial)
    return verdict


def _judge_program(check: ProgramCheck, path: Path) -> Verdict:
    """Run the program where it is, but from an empty folder, as one may start it from anywhere."""
    folder = path.parent.parent
    with tempfile.TemporaryDirectory() as name:
        elsewhere = Path(name)
        before = _image_files(folder)
        trial = run_program(str(path), cwd=name)
        after = {**_image_files(folder), **_image_files(elsewhere)}
        # Older files are not taken for what it writes: one of the same content has another time.
        written = sorted((each for each in after if after[each] != before.get(each)), key=lambda each: after[each])
        fault = trial.fault or check.judge(Written(folder, tuple(written)))
        picture = _picture(check, fault, [])
    return Verdict(check, fault, picture, trial.printed[:MAX_PRINTED])


def _image_files(folder: Path) -> dict[Path, tuple[int, int, int]]:
    """The image files in a folder and those below it, with what changes when they are written."""
    found = {}
    for path in folder.rglob('*'):
        if path.suffix.lower() in ENDINGS and HIDDEN not in path.parts:
            with suppress(OSError):  # it is gone
                status = path.stat()
                found[path] = status.st_mtime_ns, status.st_ctime_ns, status.st_ino
    return found


def _run(check: Check, path: Path, views: Sequence[View]) -> Trial:
    return run_function(path, check.function, [view.arguments for view in views], outputs=len(check.outputs))


def _shown(views: Sequence[View], images: Sequence[tuple[Image, ...]]) -> list[Shown]:
    return [Shown(number, view, each) for number, (view, each) in enumerate(zip(views, images), start=1)]


def _slowness(trial: Trial) -> list[str]:
    """A sentence if the code cannot keep up with the camera, and finding the tags is not what takes the time."""
    if not trial.seconds:
        return []
    usual = sorted(trial.seconds)[len(trial.seconds) // 2]
    if usual < CAMERA_S or usual * len(trial.seconds) < MUCH_SLOWER * trial.baseline_seconds:
        return []
    return ['It takes %.0f ms for a frame, but the camera sends one every %.0f ms, so your node will skip frames. '
            'What can be done once, before the first frame? What can NumPy do without a loop over pixels?'
            % (1000 * usual, 1000 * CAMERA_S)]
