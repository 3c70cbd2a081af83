"""The one exception for what a user, a file or a camera got wrong."""
from __future__ import annotations


class InputError(ValueError):
    """A sentence that names what is wrong and what would be right.

    ``kind`` is the same for every error of one kind, however its sentence
    varies (a thousand broken frames are one kind), so that a log can say
    each kind once.
    """

    def __init__(self, sentence: str, kind: str | None = None) -> None:
        super().__init__(sentence)
        self.kind = kind or sentence
