"""How sharp tags are, compared with how sharp they lately were: motion blurs them for a moment."""
from __future__ import annotations

from typing import Iterable

from aruco_ar.tags.tag import Tag

# A tag is blurred if its likeness is lower than SHARP, and lower by BLUR than the least of the four tags lately
# was at best. That best one is forgotten slowly, by this much in each frame.
SHARP, BLUR, FORGOTTEN = 0.985, 0.01, 1e-4
FRAMES = 15  # so many tell how sharp tags are at best; before that, something may cover a part of one


class Sharpness:
    """Remembers how sharp the tags of an area lately were at best."""

    def __init__(self) -> None:
        self._best, self._frames = 0.0, 0

    def take_in(self, tags: Iterable[Tag]) -> bool:
        """Take in the four tags of a frame, and return whether they are about as sharp as they ever are."""
        likeness = min(tag.likeness for tag in tags)
        self._best, self._frames = max(likeness, self._best - FORGOTTEN), self._frames + 1
        return likeness >= (SHARP if self._frames < FRAMES else min(self._best, SHARP))

    def is_blurred(self, tag: Tag) -> bool:
        """Whether motion has blurred a tag, so that its edges may be elsewhere than they seem."""
        return tag.likeness < min(self._best - BLUR, SHARP)
