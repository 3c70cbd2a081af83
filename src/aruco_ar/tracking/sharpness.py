"""How sharp tags are, compared with how sharp they lately were: motion blurs them for a moment."""
from __future__ import annotations

from typing import Iterable

from aruco_ar.tags.tag import Tag

# A tag is blurred if its likeness is lower than SHARP, and lower by BLUR than the least of the four tags lately
# was at best. That best one is forgotten slowly, by this much in each frame.
SHARP, BLUR, FORGOTTEN = 0.985, 0.01, 1e-4


class Sharpness:
    """Remembers how sharp the tags of an area lately were at best."""

    def __init__(self) -> None:
        self._best = 0.0

    def take_in(self, tags: Iterable[Tag]) -> bool:
        """Take in the four tags of a frame, and return whether they are about as sharp as they ever are."""
        likeness = min(tag.likeness for tag in tags)
        self._best = max(likeness, self._best - FORGOTTEN)
        return likeness >= min(self._best, SHARP)

    def is_blurred(self, tag: Tag) -> bool:
        """Whether motion has blurred a tag, so that its edges may be elsewhere than they seem."""
        return tag.likeness < min(self._best - BLUR, SHARP)
