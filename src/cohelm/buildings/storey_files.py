"""Files of a storey: Nav2 map, places, and a record of rooms and doors."""

from __future__ import annotations

import dataclasses
import itertools
import json
from collections import Counter
from collections.abc import Iterable, Sequence, Set
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.buildings.storey import (
    BuildingStorey,
    Door,
    Room,
    StoreyLink,
    room_cells,
    roomiest,
)
from cohelm.errors import BuildingError, MapError
from cohelm.maps import (
    UNKNOWN,
    NamedPlace,
    OccupancyGrid,
    Places,
    innermost_point,
    read_map,
    write_map,
    write_places,
)


def write_storey(
    storey: BuildingStorey, folder: Path, further: Iterable[NamedPlace] = ()
) -> tuple[Path, ...]:
    """Write map (.yaml, .pgm), places (.places.yaml) and record (.storey.json); returns the files.

    A storey without free floor has a record only.

    Args:
        storey: to be written.
        folder: that exists.
        further: places beside the rooms, as in front of lifts; the name of a room wins.

    Raises:
        MapError: if a file cannot be written.
    """
    stem, files = storey.stem, [folder / f"{storey.stem}.storey.json"]
    record = storey_record(storey)
    if np.any(~storey.grid.blocked()):
        files = [folder / f"{stem}{suffix}" for suffix in (".yaml", ".pgm", ".places.yaml")] + files
        write_map(storey.grid, files[0])
        places = room_places(storey)
        taken = {name.casefold() for name in places.names}
        new = [each for each in further if each.name.casefold() not in taken]
        write_places(replace(places, places=(*places.places, *new)), files[2])
        record["map"] = files[0].name
    try:
        text = json.dumps(record, ensure_ascii=False, indent=1)
        files[-1].write_text(text + "\n", encoding="utf-8")
    except OSError as cause:
        raise MapError(f"cannot be written ({cause})", file=files[-1]) from cause
    return tuple(files)


def read_storeys(folder: Path) -> tuple[BuildingStorey, ...]:
    """Storeys that :func:`write_storey` wrote to a folder, lowest first.

    A storey without a map has one unknown cell.

    Raises:
        BuildingError: if the folder has no record of a storey, or one that cannot be read.
        MapError: if a map cannot be read.
    """
    files = sorted(folder.glob("*.storey.json"))
    if not files:
        raise BuildingError(
            "no storey (.storey.json): name a folder that cohelm building --out wrote", file=folder
        )
    storeys = tuple(sorted(map(_read_storey, files), key=lambda storey: storey.number))
    for one, other in itertools.pairwise(storeys):
        if one.number == other.number:
            both = f"{one.stem} and {other.stem} are both storey {one.number}"
            raise BuildingError(f"{both}: give each building its own folder", file=folder)
    return storeys


def _read_storey(file: Path) -> BuildingStorey:
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
        map_file = file.parent / record.pop("map") if "map" in record else None
        # Else a picture of the same name would be read as the map.
        if map_file is not None and not (picture := map_file.with_suffix(".pgm")).is_file():
            raise BuildingError("the picture of its map is missing", file=picture)
        grid = OccupancyGrid(data=np.array([[UNKNOWN]]), resolution=1.0, X_MG=np.zeros(3))
        return BuildingStorey(
            **{**record, "notes": tuple(record["notes"])}
            | {
                "grid": grid if map_file is None else read_map(map_file),
                "rooms": tuple(_room(each) for each in record["rooms"]),
                "doors": tuple(
                    Door(**{**each, "rooms": tuple(each["rooms"])}) for each in record["doors"]
                ),
                "links": tuple(StoreyLink(**each) for each in record["links"]),
            }
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as cause:
        raise BuildingError(f"no record of a storey ({cause!r})", file=file) from None


def _room(record: dict[str, Any]) -> Room:
    del record["place"]
    outlines = {key: tuple(map(np.array, record[key])) for key in ("polygons", "holes")}
    return Room(**{**record, **outlines})


def room_places(storey: BuildingStorey) -> Places:
    """Rooms as named places: by name, with the number where others have the same name.

    The point of a room is the one farthest from its border and from obstacles.
    """
    names = room_names(storey.rooms)
    return Places(
        places=tuple(
            NamedPlace(
                name=name,
                point=_roomiest_point(room, storey.grid),
                polygon=room.polygons[0],
            )
            for room, name in zip(storey.rooms, names, strict=True)
        ),
        source=storey.name,
    )


def room_names(rooms: Sequence[Room]) -> tuple[str, ...]:
    """Different names of rooms, those without a name by number."""
    shared = Counter((room.name or room.number).casefold() for room in rooms)
    names: list[str] = []
    for room in rooms:
        plain = room.name or room.number
        name = plain if plain and shared[plain.casefold()] == 1 else room.label or "Room"
        same = sum(each.casefold() == name.casefold() for each in names)
        names.append(f"{name} ({same + 1})" if same else name)
    return tuple(names)


def storey_record(storey: BuildingStorey) -> dict[str, Any]:
    """Everything about a storey but its map, for JSON; m, m²."""
    record: dict[str, Any] = _record(storey, {"grid"})
    for room, place in zip(record["rooms"], room_names(storey.rooms), strict=True):
        room["place"] = place
    return record


def _record(part: Any, without: Set[str] = frozenset()) -> Any:
    """A value and its parts as mappings, lists and numbers to 0.1 mm."""
    if dataclasses.is_dataclass(part):
        names = [field.name for field in dataclasses.fields(part) if field.name not in without]
        return {name: _record(getattr(part, name)) for name in names}
    if isinstance(part, tuple):
        return [_record(each) for each in part]
    if isinstance(part, float | np.ndarray):
        return np.round(part, 4).tolist()
    return part


def _roomiest_point(room: Room, grid: OccupancyGrid) -> Floats:
    """Free cell centre (2,) farthest from border and obstacles; the innermost point if none."""
    cell = roomiest(room_cells(room, grid) & ~grid.blocked(), grid.resolution)
    return innermost_point(room.polygons[0]) if cell is None else grid.centres(cell)
