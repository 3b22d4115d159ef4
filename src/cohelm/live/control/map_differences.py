"""Persistent contradictions between map and building as places that a page can show."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Integers
from cohelm.health.map_changes import centres_of
from cohelm.live.messages import MapDifference

MAX_DIFFERENCES = 40
"""Maximum number of places, the largest ones."""
MAX_CELLS = 60
"""Maximum number of cells of one place that are sent."""
Cell = tuple[int, int]


def map_differences(rows: Integers) -> tuple[MapDifference, ...]:
    """Return the places of persistent contradictions; cells that touch are one place.

    Args:
        rows: ``MapChanges.persistent_rows``.
    """
    found = [
        _difference(cells, new=new)
        for new in (False, True)
        for cells in _connected({(c, r) for c, r, kind in rows.tolist() if kind == int(new)})
    ]
    found.sort(key=lambda each: (-len(each.cells), each.kind, each.x, each.y))
    return tuple(found[:MAX_DIFFERENCES])


def _difference(cells: list[Cell], *, new: bool) -> MapDifference:
    centres = centres_of(np.array(cells))
    # The cell nearest to the mean, which may itself lie beside an L-shaped place.
    middle = centres[np.argmin(np.hypot(*(centres - centres.mean(axis=0)).T))]
    rows = centres[:MAX_CELLS].round(3).tolist()
    return MapDifference(
        kind="new" if new else "gone",
        x=round(float(middle[0]), 3),
        y=round(float(middle[1]), 3),
        cells=tuple((x, y) for x, y in rows),
    )


def _connected(cells: set[Cell]) -> list[list[Cell]]:
    """Groups of cells that touch, also at a corner, each in a fixed order."""
    left, groups = set(cells), []
    for first in sorted(cells):
        if first not in left:
            continue
        left.remove(first)
        group, edge = [first], [first]
        while edge:
            column, row = edge.pop()
            near = {(column + a, row + b) for a in (-1, 0, 1) for b in (-1, 0, 1)} & left
            left -= near
            group += sorted(near)
            edge += sorted(near)
        groups.append(group)
    return groups
