"""Buildings read from models and maps; files of a storey: Nav2 map, places, rooms and doors."""

from __future__ import annotations

import dataclasses
import itertools
import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import replace
from cohelm.buildings.storey import (
    BuildingStorey,
    Door,
    Room,
    StoreyLink,
    polygon_cells,
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
    places_beside,
    read_map,
    write_map,
    write_places,
)

Watch = Callable[[Iterable[Any], int], Iterator[Any]]
"""Passes elements on, of which there are so many, and may show progress."""
RESOLUTION = 0.05
"""Side of a cell, m."""
_NEAR_DOOR, _SLOWER = 1.0, 50
"""In front of a door, up to this distance, m, a chair is slower by this share, %; assumed."""
_MAPS = {".yaml", ".yml", ".pgm", ".png", ".bmp", ".jpg", ".jpeg"}


def read_building(
    file: Path,
    *,
    storey: str | None = None,
    resolution: float = RESOLUTION,
    watch: Watch = lambda elements, _: iter(elements),
) -> tuple[BuildingStorey, ...]:
    """Storeys of a building, lowest first.

    Args:
        file: IFC model (.ifc), IndoorGML (.gml), osmAG (.osm), or Nav2 map.
        storey: only this one: its name, or its number, counted from 1 at the lowest.
        resolution: side of a cell of the maps, m; a Nav2 map keeps its own.
        watch: shows progress over the products of a model.

    Raises:
        BuildingError: if the model cannot be read, or has no such storey, or the extra ``building``
            is not installed.
        MapError: if the map cannot be read.
    """
    try:
        from cohelm.buildings.free_space import partition  # noqa: PLC0415  # needs the extra
        from cohelm.buildings.ifc_storeys import read_ifc  # noqa: PLC0415
        from cohelm.buildings.indoor_files import read_outlines  # noqa: PLC0415
    except ImportError as cause:
        problem = f"reading buildings needs more ({cause}): pip install 'cohelm[building]'"
        raise BuildingError(problem, file=file) from None
    if file.suffix.lower() == ".ifc":
        return read_ifc(file, storey=storey, resolution=resolution, watch=watch)
    if file.suffix.lower() in {".gml", ".osm"}:
        return read_outlines(file, storey=storey, resolution=resolution)
    if file.suffix.lower() not in _MAPS:
        problem = (
            "neither an IFC model (.ifc), nor IndoorGML (.gml), osmAG (.osm), Nav2 map (.yaml)"
        )
        raise BuildingError(problem, file=file)
    if storey not in {None, "1", file.stem}:
        raise BuildingError(f"no storey {storey!r}: a map is one storey", file=file)
    grid, places = read_map(file), places_beside(file)
    found = partition(grid, places=places)
    return (
        BuildingStorey(
            name=file.stem, stem=file.stem, elevation=0.0, grid=grid, rooms=found.rooms,
            doors=found.doors, notes=found.notes, places=places.places,
        ),
    )  # fmt: skip


def write_storey(
    storey: BuildingStorey, folder: Path, further: Iterable[NamedPlace] = ()
) -> tuple[Path, ...]:
    """Write map (.yaml, .pgm), places (.places.yaml) and record (.storey.json); returns the files.

    With doors, a speed mask (.speed.yaml, .speed.pgm) for Nav2's SpeedFilter, in percent, with base
    100 and multiplier -1. A storey without free floor has a record only.

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
        slow = np.zeros(storey.grid.shape, dtype=np.int8)
        for door in storey.doors:
            if door.kind != "open border":
                half = door.width / 2.0
                slow[polygon_cells([door.part(-half, half, _NEAR_DOOR)], storey.grid)] = _SLOWER
        if slow.any():
            files[2:2] = [folder / f"{stem}.speed{suffix}" for suffix in (".yaml", ".pgm")]
            write_map(replace(storey.grid, data=slow), files[2])
        places = room_places(storey)
        taken = {name.casefold() for name in places.names}
        others = {each.name.casefold(): each for each in (*further, *storey.places)}
        new = (others[name] for name in others if name not in taken)
        write_places(replace(places, places=(*places, *new)), files[-2])
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
                "places": () if map_file is None else tuple(places_beside(map_file)),
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

    The point of a room is the free cell farthest from its border and from obstacles.
    """
    names, grid, places = room_names(storey.rooms), storey.grid, []
    for room in storey.rooms:
        cell = roomiest(room_cells(room, grid) & ~grid.blocked(), grid.resolution)
        point = innermost_point(room.polygons[0]) if cell is None else grid.centres(cell)
        places.append(NamedPlace(name=names[room.id], point=point, polygon=room.polygons[0]))
    return Places(places=tuple(places), source=storey.name)


def room_names(rooms: Sequence[Room]) -> dict[str, str]:
    """Different names of rooms by id, those without a name by number."""
    shared = Counter((room.name or room.number).casefold() for room in rooms)
    names: dict[str, str] = {}
    for room in rooms:
        plain = room.name or room.number
        name = plain if plain and shared[plain.casefold()] == 1 else room.label or "Room"
        same = sum(each.casefold() == name.casefold() for each in names.values())
        names[room.id] = f"{name} ({same + 1})" if same else name
    return names


def door_sides(door: Door, names: Mapping[str, str]) -> list[str]:
    """Names of the two sides of a door, from those of the rooms by id."""
    none = "no room" if door.kind == "passage" else "outside"
    return [*(names[room] for room in door.rooms), none, none][:2]


def storey_record(storey: BuildingStorey) -> dict[str, Any]:
    """Everything about a storey but its map, for JSON; m, m²."""
    record: dict[str, Any] = _record(storey, {"grid", "places"})
    names = room_names(storey.rooms)
    for room in record["rooms"]:
        room["place"] = names[room["id"]]
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
