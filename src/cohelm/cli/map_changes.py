"""``cohelm map-changes``: where buildings differ from their maps, and updated copies of maps."""

from __future__ import annotations

from pathlib import Path

from cohelm.arrays import Floats
from cohelm.cli.report import print_line, write_json
from cohelm.errors import ConfigError
from cohelm.health import MapChanges, updated_map
from cohelm.live.sessions.database import Database
from cohelm.live.sessions.map_changes import (
    StoredChanges,
    forget_changes,
    map_key,
    stored_changes,
)
from cohelm.live.sessions.records import default_folder
from cohelm.maps import read_map, write_map

KINDS = {False: "a wall of the map is not there", True: "an obstacle is not on the map"}
"""Sentence on a change; True: new."""
_MOST_PLACES = 3
"""Places that a sentence names."""


def change_notes(changes: MapChanges) -> list[str]:
    """Sentences on persistent contradictions between a map and sweeps."""
    found = {new: changes.persistent(new=new) for new in KINDS}
    return [f"map: {KINDS[new]} at {_places(at)}" for new, at in found.items() if len(at)]


def show(data: Path | None, *, json: bool) -> int:
    """Print what is remembered; returns 0.

    Raises:
        StoreError: if it cannot be read.
    """
    found = stored_changes(Database(data or default_folder()))
    if json:
        write_json({key: _record(each) for key, each in found.items()})
        return 0
    for key, each in found.items():
        notes = change_notes(each.changes())
        rides = f"{each.rides} ride{'s' * (each.rides > 1)}, the last one {each.updated}"
        print_line(f"{each.scene} ({key}): {rides}{'' if notes else ': nothing persistent'}")
        for note in notes:
            print_line(f"  {note}")
    if not found:
        print_line("no map is known to differ from its building")
    return 0


def apply(file: Path, out: Path, data: Path | None) -> int:
    """Write an updated copy of a map; returns 0, or 1 if nothing differs.

    Raises:
        ConfigError: if the copy would replace a file.
        MapError: if the map cannot be read, or the copy not be written.
        StoreError: if what is remembered cannot be read.
    """
    if out.suffix.lower() not in {".yaml", ".yml"}:
        raise ConfigError(f"must end in .yaml, as {out.stem}.yaml", key="--out")
    for each in (out, out.with_suffix(".pgm")):
        if each.exists():
            raise ConfigError(f"{each} exists; name another file", key="--out")
    grid = read_map(file)
    found = stored_changes(Database(data or default_folder())).get(map_key(grid))
    notes = [] if found is None else change_notes(found.changes())
    if found is None or not notes:
        print_line(f"no ride has found {file} to differ from its building; nothing is written")
        return 1
    write_map(updated_map(grid, found.changes()), out)
    print_line("\n".join(notes))
    print_line(f"written: {out}; look at it before you drive with it")
    return 0


def forget(data: Path | None, key: str | None) -> int:
    """Forget the changes to one map, or to all; returns 0, or 1 if there is no such map.

    Raises:
        StoreError: if they cannot be read or written.
    """
    count = forget_changes(Database(data or default_folder()), key)
    print_line(f"forgotten: {count} map{'s' * (count != 1)}")
    return 0 if count or key is None else 1


def _record(stored: StoredChanges) -> dict[str, object]:
    changes = stored.changes()
    return {
        "scene": stored.scene,
        "rides": stored.rides,
        "updated": stored.updated,
        "gone": changes.persistent(new=False).tolist(),
        "new": changes.persistent(new=True).tolist(),
    }


def _places(points: Floats) -> str:
    """At most three of the points (n, 2), m, as text."""
    shown = ", ".join(f"({x:.1f}, {y:.1f})" for x, y in points[:_MOST_PLACES])
    more = len(points) - _MOST_PLACES
    return shown + (f" and {more} more cells" if more > 0 else "")
