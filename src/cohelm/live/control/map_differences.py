"""Persistent contradictions between map and building as places that a page can show."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Integers
from cohelm.health.map_changes import centres_of, connected_cells
from cohelm.live.messages import MapDifference

MAX_DIFFERENCES = 40
"""Maximum number of places, the largest ones."""
MAX_CELLS = 60
"""Maximum number of cells of one place that are sent."""


def map_differences(rows: Integers) -> tuple[MapDifference, ...]:
    """Return the places of persistent contradictions; cells that touch are one place.

    Args:
        rows: ``MapChanges.persistent_rows``.
    """
    found = [
        _difference(cells, new=new)
        for new in (False, True)
        for cells in connected_cells(rows[rows[:, 2] == int(new), :2])
    ]
    found.sort(key=lambda each: (-len(each.cells), each.kind, each.x, each.y))
    return tuple(found[:MAX_DIFFERENCES])


def _difference(cells: Integers, *, new: bool) -> MapDifference:
    centres = centres_of(cells)
    # The cell nearest to the mean, which may itself lie beside an L-shaped place.
    middle = centres[np.argmin(np.hypot(*(centres - centres.mean(axis=0)).T))]
    rows = centres[:MAX_CELLS].round(3).tolist()
    return MapDifference(
        kind="new" if new else "gone",
        x=round(float(middle[0]), 3),
        y=round(float(middle[1]), 3),
        cells=tuple((x, y) for x, y in rows),
    )
