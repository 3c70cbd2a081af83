"""InputError, the one exception for wrong input from a user, a file or a camera."""
from __future__ import annotations

MAX_SENTENCE = 500
ELLIPSIS = ' ... '


class InputError(ValueError):
    """Its message is a sentence that says what is wrong and what would be right.

    ``kind`` is the same for all errors of one kind, even if their sentences
    differ (a thousand broken frames are one kind). So a log can report each
    kind once. The sentence may quote any input. It is always one line of at
    most MAX_SENTENCE printable characters.
    """

    def __init__(self, sentence: str, kind: str | None = None) -> None:
        sentence = shorten(sentence, MAX_SENTENCE)
        super().__init__(sentence)
        self.kind = kind or sentence


def shorten(text: str, length: int) -> str:
    """The text in at most ``length`` characters; a longer text loses its middle.

    Characters that cannot be printed become escapes as in Python's source, such as \\\\n.
    """
    text = _without_middle(text, length)  # cut first: escaping a long text is slow
    if text.isprintable():
        return text
    return _without_middle(''.join(each if each.isprintable() else each.encode('unicode_escape').decode()
                                   for each in text), length)  # and again: escapes have made it longer


def _without_middle(text: str, length: int) -> str:
    kept = (length - len(ELLIPSIS)) // 2
    return text if len(text) <= length else text[:kept] + ELLIPSIS + text[-kept:]
