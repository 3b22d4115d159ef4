"""One storey of a building: its map, rooms, doors, and the ways to other storeys."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Shape, replace, value
from cohelm.errors import BuildingError
from cohelm.geometry import distance_to_polygon, inverse, transform
from cohelm.maps import UNKNOWN, NamedPlace, OccupancyGrid, signed_distance

DoorKind = Literal["door", "opening", "open border", "passage"]
"""A door of the model, an opening in a wall without a door, a border of two rooms without a wall,
or a narrow passage of a map."""
LinkKind = Literal["lift", "stairs", "ramp"]
_MARGIN = 0.5
"""Around the building on its map, m."""
_MOST_CELLS = 40_000_000
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
    point: Annotated[Floats, Shape("2")]
    """Centre of the opening; map frame, m."""
    direction: Annotated[Floats, Shape("2")]
    """Unit vector along the wall; map frame."""
    width: float
    """Clear width, m."""
    opening: float
    """Width of the opening with the lining, m."""
    name: str = ""
    width_from: str = "map"
    """Source of the width: ``opening less lining``, ``opening``, ``overall width``, ``map``."""
    depth: float = 0.0
    """Thickness of the wall, m; 0 if unknown."""
    threshold: float | None = None
    """Height of the threshold, m; None: unknown."""
    rooms: tuple[str, ...] = ()
    """Ids of the rooms that it joins, 0 to 2; other sides are outside, or floor in no room."""

    @property
    def ends(self) -> Floats:
        """Ends (2, 2) of the clear width; map frame, m."""
        half = 0.5 * self.width * self.direction
        return np.array([self.point - half, self.point + half])

    @property
    def normal(self) -> Floats:
        """Unit vector (2,) across the wall, ``direction`` turned left; map frame."""
        return np.array([-self.direction[1], self.direction[0]])

    def part(self, first: float, last: float, margin: float = 0.0) -> Floats:
        """Outline (4, 2) of a part of the opening, from wall face to wall face; map frame, m.

        Args:
            first, last: ends along ``direction``, from ``point``, m.
            margin: how much deeper than the wall it is on both sides, m.
        """
        along = np.array([[first], [last], [last], [first]]) * self.direction
        deep = (self.depth / 2.0 + margin) * np.array([[-1.0], [-1.0], [1.0], [1.0]]) * self.normal
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
    places: tuple[NamedPlace, ...] = ()
    """Named places beside its map file, those of its rooms and others."""


def unknown_grid(points: Floats, resolution: float, name: str, file: Path) -> OccupancyGrid:
    """Grid around points (k, 2), m, of unknown cells, its origin at a multiple of their size.

    Raises:
        BuildingError: if there are too many cells; names the storey.
    """
    if not len(points):
        points = np.zeros((1, 2))
    low = np.floor((points.min(axis=0) - _MARGIN) / resolution)
    high = np.ceil((points.max(axis=0) + _MARGIN) / resolution)
    cols, rows = (high - low).tolist()
    if rows * cols > _MOST_CELLS:
        enough = math.ceil(100 * resolution * math.sqrt(rows * cols / _MOST_CELLS)) / 100
        raise BuildingError(
            f"storey {name!r} spans {cols * resolution:.0f} × {rows * resolution:.0f} m: more than "
            f"{_MOST_CELLS / 1e6:.0f} million cells; use a larger --resolution, as {enough:g}",
            file=file,
        )
    data = np.full((int(rows), int(cols)), UNKNOWN, dtype=np.int8)
    return OccupancyGrid(
        data=data, resolution=resolution, X_MG=np.array([*(low * resolution), 0.0])
    )


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


def inner_distance(cells: Booleans, resolution: float) -> Floats32:
    """Distance (rows, cols) of ``cells`` to all that is not in them, m; 0 elsewhere."""
    out = np.zeros(cells.shape, dtype=np.float32)
    for window in ndimage.find_objects(cells.astype(np.uint8)):
        inside = np.pad(cells[window], 1)
        out[window] = np.maximum(signed_distance(~inside, resolution)[1:-1, 1:-1], 0.0)
    return out


def roomiest(cells: Booleans, resolution: float) -> Cell | None:
    """Cell farthest from all that is not in ``cells`` (rows, cols); None if that is empty."""
    row, col = divmod(int(np.argmax(inner_distance(cells, resolution))), cells.shape[1])
    return (row, col) if cells[row, col] else None


def with_rooms(door: Door, rooms: Sequence[Room]) -> Door:
    """Copy a door with the rooms on its two sides, found along its normal."""
    found = [room_beside(door, rooms, side) for side in (-1.0, 1.0)]
    return replace(door, rooms=tuple(dict.fromkeys(room.id for room in found if room)))


def room_beside(door: Door, rooms: Sequence[Room], side: float) -> Room | None:
    """Room on a side of a door, 1 or -1 times its normal; None if there is none."""
    # Outwards from the wall's face: a room may end at a lining or begin behind a threshold.
    for distance in door.depth / 2.0 + np.array([0.05, 0.15, 0.3, 0.5]):
        point = door.point + side * distance * door.normal
        near = next((room for room in rooms if room.contains(point)), None)
        if near is not None:
            return near
    return None
