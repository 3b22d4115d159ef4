"""Lifts of a building: outlines on its storeys joined to shafts, with the doors of each storey."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np
import shapely
from scipy import ndimage

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.buildings.storey import BuildingStorey, Door, Room, polygon_cells
from cohelm.maps import OCCUPIED

_WORDS = {"lift", "elevator", "aufzug", "fahrstuhl", "ascenseur", "ascensor", "ascensore"}
_NO_SHAFT = {"lobby", "hall", "foyer", "vestibule", "machine", "motor", "control", "vorraum"}
"""Words that make a room beside a lift of one that is named after it."""
_BESIDE = 0.6
"""Distance of a lift's doors from its outline, m: a shaft wall and the gap before the car."""
_OVERLAP = 0.3
"""Share of the smaller of two outlines from which they are one shaft."""
_GAP = 0.5
"""Distance between a lift and the floor in front of it where there is no wall, m."""


@value
class LiftLanding:
    """Lift on one storey that it serves."""

    storey: int
    """Number of the storey."""
    polygon: Annotated[Floats, Shape("k 2")]
    """Outline of the shaft or car; map frame, m."""
    doors: tuple[str, ...]
    """Ids of the doors by which one enters; none where the floor reaches it without a wall."""
    room: str = ""
    """Id of the room that is the lift, if the storey has one."""


@value
class Lift:
    """Lift that serves at least two storeys."""

    name: str
    """Unique in its building."""
    landings: tuple[LiftLanding, ...]
    """One for each storey that it serves, lowest first."""
    car: Annotated[Floats, Shape("k 2")] | None = None
    """Outline of the car; map frame, m. None: the model has the shaft only."""


@value
class _Outline:
    """Transport element or room that is a lift, on one storey."""

    storey: int
    name: str
    shape: shapely.Polygon
    room: str


def lifts_of(storeys: Sequence[BuildingStorey], notes: list[str] | None = None) -> tuple[Lift, ...]:
    """Join transport elements and rooms that are lifts across storeys.

    A lift serves a storey if an outline of it is there, or a door leads into its outline, or free
    floor touches its outline with no wall between, and the outline is no floor itself.

    Args:
        storeys: those of one building.
        notes: gets a sentence on each lift that serves one storey only, which is left out.
    """
    lifts: list[Lift] = []
    for shaft in _shafts(storeys):
        shape = min((each.shape for each in shaft), key=lambda each: float(each.area))
        served = [each for s in storeys if (each := _landing(s, shaft, shape)) is not None]
        name = next((each.name for each in shaft if each.name), "Lift")
        if len(served) > 1:
            same = sum(lift.name.split(" (")[0] == name for lift in lifts)
            name = f"{name} ({same + 1})" if same else name
            cars = sorted((e.shape for e in shaft if not e.room), key=lambda e: e.area)
            car = _corners(cars[0]) if cars else None
            lifts.append(Lift(name=name, landings=tuple(served), car=car))
        elif notes is not None and len(storeys) > 1:
            notes.append(f"the lift {name!r} serves one storey only: it is left out")
    return tuple(lifts)


def open_front(storey: BuildingStorey, polygon: Floats) -> Booleans:
    """Free cells (rows, cols) that a lift's outline (k, 2), m, touches with no wall between."""
    inside = polygon_cells([polygon], storey.grid)
    steps = int(np.ceil(_GAP / storey.grid.resolution))
    no_wall = storey.grid.data != OCCUPIED
    near = ndimage.binary_dilation(inside, iterations=steps, mask=no_wall | inside)
    front: Booleans = near & ~inside & ~storey.grid.blocked()
    return front


def _shafts(storeys: Sequence[BuildingStorey]) -> list[list[_Outline]]:
    """Outlines of lifts, those that overlap in plan together; rooms before transport elements."""
    shafts: list[list[_Outline]] = []
    for outline in sorted(_outlines(storeys), key=lambda each: not each.room):
        same = [s for s in shafts if any(_overlap(outline.shape, each.shape) for each in s)]
        shafts = [shaft for shaft in shafts if shaft not in same]
        shafts.append([*(each for shaft in same for each in shaft), outline])
    return shafts


def _outlines(storeys: Iterable[BuildingStorey]) -> Iterable[_Outline]:
    for storey in storeys:
        for room in storey.rooms:
            if _is_lift(room):
                shape = shapely.make_valid(shapely.Polygon(room.polygons[0]))
                name = room.name or room.number
                yield _Outline(storey=storey.number, name=name, shape=shape, room=room.id)
        for link in storey.links:
            if link.kind == "lift":
                shape = shapely.Polygon(link.polygon)
                yield _Outline(storey=storey.number, name=link.name, shape=shape, room="")


def _is_lift(room: Room) -> bool:
    words = set(re.findall(r"[^\W\d_]+", f"{room.name} {room.number}".casefold()))
    return bool(words & _WORDS) and not words & _NO_SHAFT


def _overlap(a: shapely.Polygon, b: shapely.Polygon) -> bool:
    return bool(a.intersection(b).area > _OVERLAP * min(a.area, b.area))


def _landing(
    storey: BuildingStorey, shaft: Sequence[_Outline], shape: shapely.Polygon
) -> LiftLanding | None:
    """A lift, by its outlines on all storeys, on one storey; None if it does not stop there.

    ``shape`` is its outline where the storey has none.
    """
    here = next((each for each in shaft if each.storey == storey.number), None)
    shape = shape if here is None else here.shape
    polygon = _corners(shape)
    doors = tuple(door.id for door in storey.doors if _leads_into(door, shape))
    if here is None:
        cells = polygon_cells([polygon], storey.grid)
        free = np.count_nonzero(cells & ~storey.grid.blocked()) > 0.5 * np.count_nonzero(cells)
        in_room = any(
            room.area > 2.0 * shape.area and room.contains(shape.centroid.coords[0])
            for room in storey.rooms
        )
        front = open_front(storey, polygon).any() and not free
        if (free and in_room) or not (doors or front):
            return None
    room = "" if here is None else here.room
    return LiftLanding(storey=storey.number, polygon=polygon, doors=doors, room=room)


def _corners(shape: shapely.Polygon) -> Floats:
    """Corners (k, 2) of an outline, m."""
    return np.array(shapely.get_coordinates(shape.exterior))[:-1]


def _leads_into(door: Door, shape: shapely.Polygon) -> bool:
    """Check that the line through a door, across its wall, meets an outline beside it."""
    reach = (door.depth / 2.0 + _BESIDE) * door.normal
    return bool(shapely.LineString([door.point - reach, door.point + reach]).intersects(shape))
