"""Contradictions between map and building, remembered over rides, and offered as a map update.

The settings have them for each map, which is known by its content: a map that was updated begins
anew. The map itself is never changed.
"""

from __future__ import annotations

import hashlib
import logging
from typing import Annotated

import numpy as np
from pydantic import Field

from cohelm.config import Model
from cohelm.health import NO_CHANGES, MapChanges
from cohelm.live.sessions.database import Database
from cohelm.live.sessions.records import now_utc
from cohelm.maps import OccupancyGrid

_PREFIX = "map_changes:"
_MAX_MAPS = 100
"""Maps that are remembered, those of the latest rides."""
_log = logging.getLogger(__name__)
Count = Annotated[int, Field(gt=-(2**31), lt=2**31)]
"""An integer that a row of ``MapChanges`` can hold."""
Cell = tuple[Count, Count, Count]


class StoredChanges(Model):
    """Contradictions to one map; a row of ``cells`` and ``balance`` as in ``MapChanges``."""

    scene: str
    """Scene of the last ride on it."""
    updated: str
    """End of that ride, ISO 8601, UTC."""
    rides: int = Field(ge=1)
    """Rides on this map."""
    cells: tuple[Cell, ...]
    balance: tuple[Count, ...]

    def changes(self) -> MapChanges:
        """Return them as memory of the health monitor."""
        k = min(len(self.cells), len(self.balance))
        cells = np.array(self.cells[:k], dtype=np.int64).reshape(-1, 3)
        return MapChanges(cells, np.array(self.balance[:k], dtype=np.int64))


def map_key(grid: OccupancyGrid) -> str:
    """Return a key that is equal for maps of equal content."""
    text = f"{grid.data.shape} {grid.resolution!r} {grid.X_MG.tolist()}".encode()
    return hashlib.sha256(text + grid.data.tobytes()).hexdigest()[:16]


def stored_changes(database: Database) -> dict[str, StoredChanges]:
    """Return what is remembered, by the key of the map; damaged entries are skipped.

    Raises:
        StoreError: The database cannot be read.
    """
    found = {}
    query = "SELECT name, value FROM setting WHERE name LIKE ? ORDER BY name"
    for name, text in database.rows(query, f"{_PREFIX}%"):
        try:
            found[name.removeprefix(_PREFIX)] = StoredChanges.model_validate_json(text)
        except ValueError:
            _log.error("%s: %s is damaged and skipped", database.file, name)
    return found


def remembered_changes(database: Database, grid: OccupancyGrid) -> MapChanges:
    """Return the contradictions to a map; errors as in :func:`stored_changes`."""
    found = stored_changes(database).get(map_key(grid))
    return NO_CHANGES if found is None else found.changes()


def keep_changes(database: Database, grid: OccupancyGrid, scene: str, changes: MapChanges) -> None:
    """Store the contradictions at the end of a ride, which began with the stored ones.

    Raises:
        StoreError: The database cannot be read or written.
    """
    maps, key = stored_changes(database), map_key(grid)
    before = maps.pop(key, None)
    if before is None and not len(changes.cells):
        return
    new = StoredChanges(
        scene=scene,
        updated=now_utc(),
        rides=1 if before is None else before.rides + 1,
        cells=tuple((int(a), int(b), int(c)) for a, b, c in changes.cells),
        balance=tuple(map(int, changes.balance)),
    )
    database.set(f"{_PREFIX}{key}", new.model_dump_json())
    for old in sorted(maps, key=lambda each: maps[each].updated)[: -_MAX_MAPS + 1]:
        forget_changes(database, old)


def forget_changes(database: Database, key: str | None = None) -> int:
    """Forget the contradictions to one map, or to all; returns the number of maps.

    Raises:
        StoreError: The database cannot be read or written.
    """
    gone = [each for each in stored_changes(database) if key in {None, each}]
    if gone:
        with database.transaction() as open_:
            names = [(f"{_PREFIX}{each}",) for each in gone]
            open_.executemany("DELETE FROM setting WHERE name = ?", names)
    return len(gone)
