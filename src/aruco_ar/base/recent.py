"""A dict of limited size."""
from __future__ import annotations

from typing import OrderedDict, TypeVar

MAX_ENTRIES = 1024  # no dictionary of tags has more ids

Key = TypeVar('Key')
Value = TypeVar('Value')


class Recent(OrderedDict[Key, Value]):
    """A dict that keeps the ``max_entries`` entries that were set last; a new one drops the oldest."""

    def __init__(self, max_entries: int = MAX_ENTRIES) -> None:
        super().__init__()
        self._max_entries = max_entries

    def __setitem__(self, key: Key, value: Value) -> None:
        super().__setitem__(key, value)
        self.move_to_end(key)
        if len(self) > self._max_entries:
            self.popitem(last=False)
