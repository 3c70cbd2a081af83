"""Memories that stay small, whatever is seen."""
from __future__ import annotations

from typing import OrderedDict, TypeVar

MOST = 1024  # no dictionary of tags has more ids

Key = TypeVar('Key')
Value = TypeVar('Value')


class Recent(OrderedDict[Key, Value]):
    """A dict of the ``most`` entries that were set last: ever-new ones drive out the oldest."""

    def __init__(self, most: int = MOST) -> None:
        super().__init__()
        self._most = most

    def __setitem__(self, key: Key, value: Value) -> None:
        super().__setitem__(key, value)
        self.move_to_end(key)
        if len(self) > self._most:
            self.popitem(last=False)
