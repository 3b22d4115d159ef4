"""One storey of a building: its map, rooms, doors, and the ways to other storeys."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import cv2
import numpy as np
from numpy.typing import ArrayLike

from cohelm.arrays import Annotated, Booleans, Floats, Shape, replace, value
from cohelm.geometry import distance_to_polygon, inverse, transform
from cohelm.maps import OccupancyGrid, signed_distance

DoorKind = Literal["door", "opening", "open border", "passage"]
"""A door of the model, an opening in a wall without a door, a border of two rooms without a wall,
or a narrow passage of a map."""
LinkKind = Literal["lift", "stairs", "ramp"]
Cell = tuple[int, int]
"""(row, column)."""


@value
class Room:
    """Area of a storey with a name."""

    id: str
    """GlobalId in an IFC model; ``room-3`` from a plain map."""
    number: str
    name: str
    """May be empty."""
    polygons: tuple[Floats, ...]
    """Outlines (k, 2) of the parts, largest first; map frame, m."""
    area: float
    """Without holes, m²."""
    holes: tuple[Floats, ...] = ()
    """Outlines (k, 2) of what they enclose and the room does not contain, as an inner room."""

    @property
    def label(self) -> str:
        """Number and name, or the longer one if it contains the other: A102 Office, Room 3."""
        number, name = self.number, self.name
        if name.casefold() in number.casefold():
            return number
        if number.casefold() in name.casefold().split():
            return name
        return f"{name} {number}".strip() if number.isdecimal() else f"{number} {name}".strip()

    def contains(self, point: ArrayLike) -> bool:
        """Check that a map point (2,) lies in the room."""
        x, y = np.asarray(point, dtype=float)
        inside, beside = (
            any(distance_to_polygon(each, x, y) < 0.0 for each in outlines)
            for outlines in (self.polygons, self.holes)
        )
        return inside and not beside


@value
class Door:
    """Door, or opening in a wall, that a chair may pass."""

    id: str
    kind: DoorKind
    name: str
    point: Annotated[Floats, Shape("2")]
    """Centre of the opening; map frame, m."""
    direction: Annotated[Floats, Shape("2")]
    """Unit vector along the wall; map frame."""
    width: float
    """Clear width, m."""
    width_from: str
    """Source of the width: ``opening less lining``, ``opening``, ``overall width``, ``map``."""
    opening: float
    """Width of the opening with the lining, m."""
    depth: float
    """Thickness of the wall, m; 0 if unknown."""
    threshold: float | None
    """Height of the threshold, m; None: unknown."""
    rooms: tuple[str, ...]
    """Ids of the rooms that it joins, 0 to 2; other sides are outside, or floor in no room."""

    @property
    def ends(self) -> Floats:
        """Ends (2, 2) of the clear width; map frame, m."""
        half = 0.5 * self.width * self.direction
        return np.array([self.point - half, self.point + half])

    def part(self, first: float, last: float, margin: float = 0.0) -> Floats:
        """Outline (4, 2) of a part of the opening, from wall face to wall face; map frame, m.

        Args:
            first, last: ends along ``direction``, from ``point``, m.
            margin: how much deeper than the wall it is on both sides, m.
        """
        normal = np.array([-self.direction[1], self.direction[0]])
        along = np.array([[first], [last], [last], [first]]) * self.direction
        deep = (self.depth / 2.0 + margin) * np.array([[-1.0], [-1.0], [1.0], [1.0]]) * normal
        corners: Floats = self.point + along + deep
        return corners


@value
class StoreyLink:
    """Lift, stairs or ramp: an outline on the storey."""

    id: str
    kind: LinkKind
    name: str
    polygon: Annotated[Floats, Shape("k 2")]
    """Convex hull; map frame, m."""


@value
class BuildingStorey:
    """Floor of a building as a chair meets it; the map frame is the model's, in metres."""

    name: str
    stem: str
    """Name of its files, without suffix."""
    elevation: float
    """Height of the floor in the model, m; 0 for a plain map."""
    grid: OccupancyGrid
    rooms: tuple[Room, ...]
    doors: tuple[Door, ...]
    links: tuple[StoreyLink, ...] = ()
    notes: tuple[str, ...] = ()
    """Oddities of the model and what was assumed, one sentence each."""
    number: int = 1
    """Counted from 1 at the lowest storey of the building."""


def room_cells(room: Room, grid: OccupancyGrid) -> Booleans:
    """Cells (rows, cols) of a room."""
    return polygon_cells(room.polygons, grid) & ~polygon_cells(room.holes, grid)


def polygon_cells(polygons: Iterable[Floats], grid: OccupancyGrid) -> Booleans:
    """Cells (rows, cols) of simple polygons (k, 2), m, to half a cell."""
    inside = np.zeros(grid.shape, dtype=np.uint8)
    for polygon in polygons:
        # Corners in 1/16 of a cell, from the centre of the first cell.
        corners = transform(inverse(grid.X_MG), polygon) / grid.resolution - 0.5
        cv2.fillPoly(inside, [np.round(16.0 * corners).astype(np.int32)], 1, shift=4)
    return inside.astype(np.bool_)


def roomiest(cells: Booleans, resolution: float) -> Cell | None:
    """Cell farthest from all that is not in ``cells`` (rows, cols); None if that is empty."""
    if not cells.any():
        return None
    rows, cols = (np.flatnonzero(cells.any(axis=axis)) for axis in (1, 0))
    window = np.pad(cells[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1], 1)
    clearance = signed_distance(~window, resolution)
    row, col = divmod(int(np.argmax(clearance)), window.shape[1])
    return int(rows[0]) + row - 1, int(cols[0]) + col - 1


def with_rooms(door: Door, rooms: Iterable[Room]) -> Door:
    """Copy a door with the rooms on its two sides, found along its normal."""
    rooms, normal = tuple(rooms), np.array([-door.direction[1], door.direction[0]])
    found: dict[str, None] = {}
    for side in (-1.0, 1.0):
        # Outwards from the wall's face: a room may end at a lining or begin behind a threshold.
        for distance in door.depth / 2.0 + np.array([0.05, 0.15, 0.3, 0.5]):
            point = door.point + side * distance * normal
            near = [room.id for room in rooms if room.contains(point)]
            if near:
                found[near[0]] = None
                break
    return replace(door, rooms=tuple(found))
