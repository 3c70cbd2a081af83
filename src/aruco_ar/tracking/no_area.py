"""Why tags span no area, in words."""
from __future__ import annotations

from typing import AbstractSet, Iterable

from aruco_ar.tags.tag import listed

NEVER_SEEN = 'Four tags have not been seen together.'


def why_no_area(wanted: AbstractSet[int], seen: Iterable[int], repeated: Iterable[int]) -> str | None:
    """Why tags that span no area do not, and what to do. None without tags.

    ``wanted``: the ids that count; empty for all. ``seen``: the ids in sight. ``repeated``: those of them that
    are there several times.
    """
    seen = set(seen)
    if not seen:
        return None
    several = set(repeated) & (wanted or seen)
    ids = sorted(tag_id for tag_id in seen - several if not wanted or tag_id in wanted)
    if len(ids) >= 4:
        return ('The tags in sight (%s) are not the corners of a quadrilateral, so no area is between them. '
                'Hang one in each corner.' % listed(ids))
    if several:
        return ('Several tags in sight have the same id: %s. An area needs four tags with different ids.'
                % listed(sorted(several)))
    if not wanted:
        return 'Only %d tag%s in sight (%s), and an area needs four.' % (
            len(ids), ' is' if len(ids) == 1 else 's are', listed(ids))
    others = sorted(seen - wanted)
    more = '; other tags in sight are ' + listed(others) if others else ''
    return ('Of the tags %s, %s in sight%s. Bring all of them into view, or give the ids of four that hang '
            'there.' % (listed(sorted(wanted)), _are(ids), more))


def _are(ids: list[int]) -> str:
    return 'none is' if not ids else 'only %s %s' % (listed(ids), 'is' if len(ids) == 1 else 'are')
