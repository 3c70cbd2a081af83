"""The one exception for what a user, a file or a camera got wrong."""
from __future__ import annotations

MAX_SENTENCE = 500
DOTS = ' ... '


class InputError(ValueError):
    """A sentence that names what is wrong and what would be right.

    ``kind`` is the same for every error of one kind, however its sentence
    varies (a thousand broken frames are one kind), so that a log can say
    each kind once. Whatever the sentence repeats of what is wrong, it is one
    line of at most MAX_SENTENCE characters, all of which can be printed.
    """

    def __init__(self, sentence: str, kind: str | None = None) -> None:
        sentence = shorten(sentence, MAX_SENTENCE)
        super().__init__(sentence)
        self.kind = kind or sentence


def shorten(text: str, length: int) -> str:
    """The text in at most that many characters: where it has more, without its middle.

    What cannot be printed becomes what stands for it in Python's source, such as \\\\n.
    """
    text = _cut(text, length)  # first, as what follows makes it longer, and takes time
    return _cut(''.join(each if each.isprintable() else each.encode('unicode_escape').decode()
                        for each in text), length)


def _cut(text: str, length: int) -> str:
    kept = (length - len(DOTS)) // 2
    return text if len(text) <= length else text[:kept] + DOTS + text[-kept:]
