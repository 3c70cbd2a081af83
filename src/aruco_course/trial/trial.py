"""Runs the learner's function or program, and says what came of it."""
from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any, Sequence

import numpy as np
from aruco_ar.base.arrays import Image

from aruco_course.check import Fault

from .limits import Limits
from .process import run
from .sentences.endings import fault_of_ending
from .sentences.exceptions import fault_of_error
from .sentences.values import fault_of_images, fault_of_value
from .source import fault_of_missing, fault_of_syntax


@dataclass
class Trial:
    """What came of the learner's code.

    ``images``: for each call that was done, what it returned. ``seconds``: how long each took. ``fault``: why
    it ended early. ``printed``: what it printed. ``baseline_seconds``: how long OpenCV takes to find the tags
    in such a frame, in the same process; 0 if that is not known. ``written``: the paths of the images that a
    program wrote; ``refused``: those for which cv2.imwrite returned False.
    """

    images: list[tuple[Image, ...]] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    fault: Fault | None = None
    printed: str = ''
    baseline_seconds: float = 0.0
    written: list[str] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)

    @property
    def call_seconds(self) -> float:
        """The median of the calls' seconds; 0 without calls."""
        return float(np.median(self.seconds)) if self.seconds else 0.0


def run_function(path: str, function: str, calls: Sequence[Sequence[Any]], outputs: int | Sequence[str] = 1,
                 limits: Limits = Limits()) -> Trial:  # noqa: B008  it cannot be changed
    """Call a function of the file with the arguments of each of the calls, in a process of its own.

    ``calls``: tuples of arguments: arrays, numbers, texts. The first argument is a frame of its own for each
    call, if it is an array; an array that is a later argument of several calls is the same for all.
    ``outputs``: how many images the function returns, or their names.
    """
    names = tuple(outputs) if not isinstance(outputs, int) else ('image',) * outputs
    arrays: list[Image] = []
    numbers: dict[int, int] = {}

    def given(value: Any) -> tuple[bool, Any]:
        if not isinstance(value, np.ndarray):
            return False, value
        if id(value) not in numbers:
            numbers[id(value)] = len(arrays)
            arrays.append(value)
        return True, numbers[id(value)]

    job = {'function': function, 'outputs': len(names),
           'calls': [[given(value) for value in arguments] for arguments in calls]}
    return _run(path, job, arrays, limits, None, names,
                [arguments[0].shape if arguments and isinstance(arguments[0], np.ndarray) else None
                 for arguments in calls])


def run_program(path: str, limits: Limits = Limits(), cwd: str | None = None) -> Trial:  # noqa: B008
    """Run the file as a program, in a process of its own. ``cwd``: its folder; None: an empty one."""
    job: dict[str, Any] = {'function': None, 'outputs': 0, 'calls': []}
    return _run(path, job, [], limits, cwd, (), [])


def _run(path: str, job: dict[str, Any], arrays: list[Image], limits: Limits, cwd: str | None,
         names: tuple[str, ...], frames: list[tuple[int, ...] | None]) -> Trial:
    """Run a job. ``frames``: the shapes of the calls' frames, to which what is returned must fit."""
    path = os.path.abspath(path)
    trial = Trial()
    trial.fault = fault_of_syntax(path)
    if trial.fault:
        return trial
    function = job['function']
    now = {'stage': 'start', 'call': 0}
    left: dict[str, Any] = {}

    def hear(record: dict[str, Any], images: list[Image]) -> float | None:
        say = record['say']
        number = len(trial.images) + 1
        if trial.fault:
            return None
        if say == 'ready':
            now['stage'] = 'load'
            return limits.load
        if say == 'call':
            now.update(stage='call', call=number)
            return limits.call
        if say == 'images' and number <= len(frames) and len(images) == len(names):
            trial.fault = fault_of_images(images, names, frames[number - 1], number)
            if trial.fault:
                return None
            trial.images.append(tuple(images))
            trial.seconds.append(float(record['seconds']))
            if sum(trial.seconds) > limits.total:
                trial.fault = Fault('%s takes %.1f seconds for a frame, and the camera sends many each '
                                    'second.' % (
                    function, trial.call_seconds))
                return None
            return limits.call
        if say == 'error':
            trial.fault = fault_of_error(record, path, function, names)
        elif say == 'value':
            trial.fault = fault_of_value(record['what'], names, number, path, function)
        elif say == 'missing':
            trial.fault = fault_of_missing(path, function)
        elif say == 'left':
            left.update(record)
            return limits.call
        elif say == 'end':
            trial.baseline_seconds = float(record['baseline'])
            trial.written = [str(one) for one in record.get('written', ())]
            trial.refused = [str(one) for one in record.get('refused', ())]
        return None

    ending = run(dict(job, path=path, call=limits.call, load=limits.load), arrays, limits, cwd, hear)
    trial.printed = ending.printed
    if not trial.fault and ending.how != 'end':
        trial.fault = fault_of_ending(ending, left, now, path, function, limits)
    return trial
