"""What is true for a while, though not every frame shows it."""
from __future__ import annotations

from typing import Generic, Mapping, TypeVar

Key = TypeVar('Key')
Value = TypeVar('Value')


class Lasting(Generic[Key, Value]):
    """Tells what has been true for ``lasting`` seconds. What no frame shows for ``gone`` seconds has ended."""

    def __init__(self, lasting: float, gone: float) -> None:
        self._lasting, self._gone = lasting, gone
        self.reset()

    def reset(self) -> None:
        """Forget the frames before."""
        self._true: dict[Key, tuple[float, float, Value]] = {}  # since when, when last, and the value

    def update(self, stamp: float, shown: Mapping[Key, Value]) -> dict[Key, Value]:
        """Take in what a frame at a time, seconds, shows. Returns what lasts, each with its newest value."""
        self._true = {key: true for key, true in self._true.items() if stamp - true[1] <= self._gone}
        for key, value in shown.items():
            self._true[key] = self._true.get(key, (stamp,))[0], stamp, value
        return {key: value for key, (since, _, value) in self._true.items() if stamp - since >= self._lasting}
