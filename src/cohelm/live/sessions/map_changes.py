"""Contradictions between map and building, remembered over rides, and offered as a map update.

One file beside the settings has them for each map, which is known by its content: a map that was
updated begins anew. The map itself is never changed.
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from cohelm.config import Model
from cohelm.errors import StoreError
from cohelm.health import NO_CHANGES, MapChanges
from cohelm.live.sessions.files import make_private_folder, write_atomically
from cohelm.live.sessions.session_files import now_utc
from cohelm.maps import OccupancyGrid

FILE = "map-changes.json"
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


class _File(Model):
    """Content of the file: key of a map → its contradictions."""

    maps: Mapping[str, StoredChanges] = {}


def map_key(grid: OccupancyGrid) -> str:
    """Return a key that is equal for maps of equal content."""
    text = f"{grid.data.shape} {grid.resolution!r} {grid.X_MG.tolist()}".encode()
    return hashlib.sha256(text + grid.data.tobytes()).hexdigest()[:16]


def stored_changes(folder: Path) -> dict[str, StoredChanges]:
    """Return what is remembered, by the key of the map.

    Raises:
        StoreError: The file is damaged or cannot be read.
    """
    file = folder / FILE
    try:
        return dict(_File.model_validate_json(file.read_bytes()).maps)
    except FileNotFoundError:
        return {}
    except (OSError, ValueError):
        raise StoreError("cannot be read; remove it to begin anew", file=file) from None


def remembered_changes(folder: Path, grid: OccupancyGrid) -> MapChanges:
    """Return the contradictions to a map; none if the file is damaged, which the log tells."""
    try:
        found = stored_changes(folder).get(map_key(grid))
    except StoreError as error:
        _log.error("map changes are not known: %s", error)
        return NO_CHANGES
    return NO_CHANGES if found is None else found.changes()


def keep_changes(folder: Path, grid: OccupancyGrid, scene: str, changes: MapChanges) -> None:
    """Store the contradictions at the end of a ride, which began with the stored ones.

    A damaged file is replaced.

    Raises:
        StoreError: The file cannot be written.
    """
    try:
        maps = stored_changes(folder)
    except StoreError as error:
        _log.error("map changes begin anew: %s", error)
        maps = {}
    key = map_key(grid)
    before = maps.pop(key, None)
    if before is None and not len(changes.cells):
        return
    maps[key] = StoredChanges(
        scene=scene,
        updated=now_utc(),
        rides=1 if before is None else before.rides + 1,
        cells=tuple((int(a), int(b), int(c)) for a, b, c in changes.cells),
        balance=tuple(map(int, changes.balance)),
    )
    latest = dict(sorted(maps.items(), key=lambda item: item[1].updated)[-_MAX_MAPS:])
    _write(folder, latest)


def forget_changes(folder: Path, key: str | None = None) -> int:
    """Forget the contradictions to one map, or to all; returns the number of maps.

    Raises:
        StoreError: The file cannot be read or written.
    """
    maps = stored_changes(folder)
    gone = [each for each in maps if key in {None, each}]
    if gone:
        _write(folder, {each: found for each, found in maps.items() if each not in gone})
    return len(gone)


def _write(folder: Path, maps: Mapping[str, StoredChanges]) -> None:
    text = _File(maps=maps).model_dump_json(indent=1).encode() + b"\n"
    write_atomically(make_private_folder(folder) / FILE, text)
