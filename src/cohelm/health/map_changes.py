"""Persistent contradictions between map and sweeps: walls that are gone, walls that are new.

Only a report: the map is never changed, an updated copy is made on request. A coarse cell collects
sweeps that pass through its mapped wall, or that end where the map is free, from different places;
a sweep that agrees takes one back.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.geometry import compose, transform
from cohelm.health.map_fit import HIT, SHORT, THROUGH, BeamTable, MapFit
from cohelm.maps import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

CELL = 0.25
"""Side of a cell, m."""
PERSISTENT = 10
"""Balance of contradicting sweeps from which a cell counts: 5 s at two sweeps a second."""
_PERIOD = 0.5
"""Time between two sweeps that are counted, s: successive sweeps are no new evidence."""
_MOST = 50
"""Largest balance, so that a change back is noticed in time."""
_MAX_CELLS = 2000
_BEHIND = 0.3
"""Distance beyond a mapped wall from which a beam has passed it, m: twice the width of a wall's
place in the fit."""
_PERSON = 1.5
"""Extent below which what is new may be people who stand and were never recognised, m: in rides
past single people, talking groups and queues the largest was 1.3 m."""
_NEAR_PERSON = 0.8
"""Distance from a person within which obstacles are theirs, m: a body, a cell, and the way that
somebody who stood has walked when the tracker recognises them."""
_RECENT = 60.0
"""Time for which somebody who stood counts as standing there after the last detection, s."""
_STANDS = 0.3
"""Speed below which somebody stands, m/s."""


class MapChanges(NamedTuple):
    """Contradictions so far; rows of one cell."""

    cells: Integers
    """(k, 3): column, row, 0 for a wall that is gone or 1 for an obstacle that is new."""
    balance: Integers
    """(k,) sweeps that contradict the map less those that agree."""
    time: float = -np.inf
    """Time of the last sweep that was counted, s."""

    def persistent(self, *, new: bool) -> Floats:
        """Centres (m, 2) of persistent contradictions, m: new obstacles, or walls that are gone."""
        rows = self.persistent_rows
        return centres_of(rows[rows[:, 2] == int(new), :2])

    @property
    def persistent_rows(self) -> Integers:
        """Rows (m, 3) of ``cells`` that are persistent; new obstacles larger than people."""
        rows: Integers = self.cells[self.balance >= PERSISTENT]
        new = rows[:, 2] == 1
        large = [each for each in connected_cells(rows[new, :2]) if _extent(each) >= _PERSON]
        kept = [np.column_stack([each, np.ones(len(each), dtype=np.int64)]) for each in large]
        return np.concatenate([rows[~new], *kept]) if new.any() else rows


def connected_cells(cells: Integers) -> list[Integers]:
    """Groups (k, 2) of cells (n, 2) that touch, also at a corner, each in a fixed order."""
    left, groups = set(map(tuple, cells.tolist())), []
    for first in sorted(left):
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
        groups.append(np.array(group, dtype=np.int64))
    return groups


def _extent(cells: Integers) -> float:
    """Diagonal of the box about cells (k, 2), m."""
    return float(np.hypot(*(np.ptp(cells, axis=0) + 1))) * CELL


def centres_of(cells: Integers) -> Floats:
    """Centres (m, 2) of cells (m, 2) by column and row, m."""
    return np.asarray((cells + 0.5) * CELL, dtype=float)


NO_CHANGES = MapChanges(np.zeros((0, 3), dtype=np.int64), np.zeros(0, dtype=np.int64))


def update_map_changes(
    before: MapChanges, fit: MapFit, beams: BeamTable, X_MR: Floats, mount: Floats, time: float
) -> MapChanges:
    """Count a sweep, unless the last one that was counted is recent.

    Args:
        before: contradictions so far.
        fit: of the sweep, at a pose that can be trusted.
        beams: of the sweep.
        X_MR: pose of the robot (3,).
        mount: X_RL (3,).
        time: of the sweep, s.
    """
    if time - before.time < _PERIOD - 1e-9:
        return before
    X_MS = compose(X_MR, mount)
    walls = _cells(X_MS, beams.angle, fit.expected)
    ends = _cells(X_MS, beams.angle, beams.range)
    hit, new = fit.beams == HIT, fit.beams == SHORT
    gone = (fit.beams == THROUGH) | (hit & _beyond(fit, beams))
    agreeing = _votes(walls[hit & ~gone], 0)
    contradicting = np.concatenate([_votes(walls[gone], 0), _votes(ends[new], 1)])
    # A beam that goes on beyond a place takes back an obstacle there.
    freed = _freed(before, X_MS, beams, gone | hit)
    rows = np.concatenate([before.cells, contradicting, agreeing, freed])
    votes = np.concatenate(
        [
            before.balance,
            np.ones(len(contradicting), dtype=np.int64),
            -np.ones(len(agreeing) + len(freed), dtype=np.int64),
        ]
    )
    cells, index = np.unique(rows, axis=0, return_inverse=True)
    balance = np.minimum(np.bincount(index.ravel(), votes), _MOST).astype(np.int64)
    keep = balance > 0
    if keep.sum() > _MAX_CELLS:
        keep &= balance >= np.partition(balance, -_MAX_CELLS)[-_MAX_CELLS]
    return MapChanges(cells[keep], balance[keep], time)


def standing_people(before: Floats, people: Floats, time: float) -> Floats:
    """Return where people stand or stood a short while ago: rows (k, 3) of x, y, m, and time, s.

    Args:
        before: result of the last call.
        people: positions and velocities (n, 4) of the people tracked now.
        time: s.
    """
    stands = people[np.hypot(people[:, 2], people[:, 3]) < _STANDS, :2]
    now = np.column_stack([stands, np.full(len(stands), time)])
    apart = (
        np.hypot(*(before[:, None, :2] - stands).T) if len(stands) else np.empty((0, len(before)))
    )
    gone = (apart < CELL).any(axis=0) | (before[:, 2] < time - _RECENT) | (before[:, 2] > time)
    return np.concatenate([before[~gone], now])


def without_people(changes: MapChanges, people: Floats) -> MapChanges:
    """Forget new obstacles beside people: somebody who stood there was no obstacle.

    Args:
        changes: contradictions so far.
        people: positions (n, 2), m.
    """
    if not len(people) or not len(changes.cells):
        return changes
    apart = (changes.cells[:, None, :2] + 0.5) * CELL - people
    near = (np.hypot(apart[..., 0], apart[..., 1]) < _NEAR_PERSON).any(axis=1)
    keep = ~(near & (changes.cells[:, 2] == 1))
    return MapChanges(changes.cells[keep], changes.balance[keep], changes.time)


def _beyond(fit: MapFit, beams: BeamTable) -> Booleans:
    """Mask (n,) of the beams that pass a mapped wall, and end on another one behind it.

    As for those that end in free space, a neighbour that expects a longer range excuses an edge.
    """
    e = fit.expected
    far = np.maximum(np.maximum(np.roll(e, 1), e), np.roll(e, -1))  # NaN where one is not known
    return np.asarray(beams.range > far + _BEHIND)


def _cells(X_MS: Floats, angle: Floats, distance: Floats) -> Integers:
    """Cells (n, 2) at distances (n,) along beams; far away where the distance is not finite."""
    r = np.where(np.isfinite(distance), distance, 1e6)
    a = X_MS[2] + angle
    points = X_MS[:2] + np.column_stack([r * np.cos(a), r * np.sin(a)])
    return np.asarray(np.floor(points / CELL), dtype=np.int64)


def _votes(cells: Integers, kind: int) -> Integers:
    """Distinct cells (k, 3) of one kind."""
    marked = np.column_stack([cells, np.full(len(cells), kind)])
    return np.unique(marked, axis=0)


def _freed(before: MapChanges, X_MS: Floats, beams: BeamTable, reaching: Integers) -> Integers:
    """Cells (k, 3) of new obstacles that a beam passes."""
    new = before.cells[before.cells[:, 2] == 1]
    if not len(new) or not reaching.any():
        return np.zeros((0, 3), dtype=np.int64)
    apart = (new[:, :2] + 0.5) * CELL - X_MS[:2]
    distance = np.hypot(*apart.T)
    bearing = np.arctan2(apart[:, 1], apart[:, 0]) - X_MS[2] - beams.angle[0]
    step = beams.angle[1] - beams.angle[0]
    index = np.round((bearing % (2.0 * np.pi)) / step).astype(np.int64)
    inside = index < len(beams.angle)
    at = np.where(inside, index, 0)
    far = np.where(reaching[at], beams.range[at], 0.0)
    freed: Integers = new[inside & np.isfinite(far) & (far > distance + 2.0 * CELL)]
    return freed


def updated_map(grid: OccupancyGrid, changes: MapChanges) -> OccupancyGrid:
    """Return a map with the persistent changes: walls that are gone are free, new ones occupied.

    A new obstacle occupies its whole cell. Where both kinds are in one cell, as of a door that
    moved within it, the obstacle stays.

    Args:
        grid: the map that was contradicted; it stays as it is.
        changes: contradictions to it.
    """
    data = grid.data.copy()
    rows, cols = np.indices(grid.shape)
    local = np.stack([cols + 0.5, rows + 0.5], axis=-1) * grid.resolution
    cell = np.floor(transform(grid.X_MG, local.reshape(-1, 2)) / CELL).astype(np.int64)
    cell, rows = cell.reshape(*grid.shape, 2), changes.persistent_rows
    for new in (False, True):
        chosen = rows[rows[:, 2] == int(new)]
        # Unknown cells stay unknown.
        data[np.isin(_code(cell), _code(chosen)) & (data != UNKNOWN)] = OCCUPIED if new else FREE
    return OccupancyGrid(data=data, resolution=grid.resolution, X_MG=grid.X_MG)


def _code(cells: Integers) -> Integers:
    """One number for each cell (…, 2 or more)."""
    return np.asarray(cells[..., 0] * 2**32 + cells[..., 1])
