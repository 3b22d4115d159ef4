"""Floor plan in YAML: rooms, corridors, doors and furniture, drawn as a grid with named places.

An example, in metres, with the map's origin at the lower left corner::

    size: [40, 25]
    rooms:
      Ward 1: {rect: [0.2, 16, 6, 24.8]}            # between the centre lines of its walls
    corridors:
      North corridor: {rect: [0.2, 13, 39.8, 16]}   # overlapping spaces have no wall between
      Passage: {line: [[20, 2], [20, 13.5]], width: 2.5}
    doors:
      - {at: [3, 16], width: 1.3}                   # cut into the wall that it lies on
    furniture:
      - {name: bed, rect: [0.4, 18, 2.5, 19], height: 0.7}
    places:
      Lift: [20, 14.5]
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from cohelm import config
from cohelm.arrays import Floats, Floats32
from cohelm.errors import ConfigError
from cohelm.maps.drawing import Canvas, polygon_of_disc, polygon_of_rect, rotate
from cohelm.maps.grid import OccupancyGrid
from cohelm.maps.places import NamedPlace, Places

_DOOR_REACH = 0.3
"""Largest distance of a door from the centre line of its wall, m."""


def _ordered(rect: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    if not (rect[0] < rect[2] and rect[1] < rect[3]):
        raise ValueError("a rect is [x0, y0, x1, y1] with x0 < x1 and y0 < y1")
    return rect


Point = tuple[float, float]
Rect = Annotated[tuple[float, float, float, float], AfterValidator(_ordered)]
Polygon = Annotated[tuple[Point, ...], Field(min_length=3)]


class Space(config.Model):
    """Room or part of a corridor: an area with a wall around it."""

    rect: Rect | None = None
    """[x0, y0, x1, y1] between the centre lines of the walls, m."""
    polygon: Polygon | None = None
    """Corners between the centre lines of the walls, in order, m."""
    line: tuple[Point, Point] | None = None
    """Ends of the centre line of the area, m; with ``width``."""
    width: float | None = Field(default=None, gt=0.0, le=1000.0)
    """Width between the centre lines of the walls, m; with ``line``."""
    point: Point | None = None
    """Destination in the area, m; by default the point with the most free space."""

    @model_validator(mode="after")
    def _one_outline(self) -> Space:
        _exactly_one(self, "rect", "polygon", "line")
        if (self.line is None) != (self.width is None):
            raise ValueError("line and width go together")
        if self.line is not None and self.line[0] == self.line[1]:
            raise ValueError("the ends of a line must differ")
        return self

    @property
    def corners(self) -> Floats:
        """Corners (k, 2) of the centre lines of the walls, m."""
        if self.line is not None and self.width is not None:
            return _along(np.array(self.line, dtype=float), self.width)
        return _corners(self.rect, self.polygon)


class Furniture(config.Model):
    """Object on the floor."""

    name: str = ""
    """Kind of the object."""
    rect: Rect | None = None
    """[x0, y0, x1, y1] before the rotation, m."""
    disc: tuple[float, float, float] | None = None
    """[x, y, radius], m."""
    polygon: Polygon | None = None
    """Corners in order, before the rotation, m."""
    turned: float = 0.0
    """Rotation about the centre of its bounding box, degrees anticlockwise."""
    at: tuple[Point, ...] = ((0.0, 0.0),)
    """Position of each piece; the outline is relative to it, m."""
    height: float | None = Field(default=None, gt=0.0, le=20.0)
    """Height above the floor, m; None: as high as the walls."""

    @model_validator(mode="after")
    def _one_outline(self) -> Furniture:
        if self.disc is not None and not self.disc[2] > 0.0:
            raise ValueError("disc: the radius must be positive")
        _exactly_one(self, "rect", "disc", "polygon")
        return self

    @property
    def outlines(self) -> Floats:
        """Corners (pieces, k, 2) in the map frame, m; k = 32 for a disc."""
        if self.disc is not None:
            corners = polygon_of_disc(self.disc)
        else:
            corners = rotate(_corners(self.rect, self.polygon), np.deg2rad(self.turned))
        return np.array(self.at, dtype=float)[:, None, :] + corners


class DoorOpening(config.Model):
    """An opening in a wall."""

    at: Point
    """Centre of the opening, on the wall, m."""
    width: float = Field(default=1.2, gt=0.0)
    """Clear width, m."""


class FloorPlan(config.Model):
    """A floor of a building, in a frame whose origin is the lower left corner of the map."""

    size: tuple[Annotated[float, Field(gt=0.0)], Annotated[float, Field(gt=0.0)]]
    """Width along x and height along y of the map, m."""
    resolution: float = Field(default=0.05, gt=0.0)
    """Side of a cell, m."""
    wall: float = Field(default=0.15, gt=0.0)
    """Thickness of the walls, m."""
    outside: Literal["unknown", "occupied"] = "unknown"
    """State of the cells outside the building."""
    rooms: dict[str, Space] = Field(default_factory=dict)
    """Rooms by name."""
    corridors: dict[str, Space] = Field(default_factory=dict)
    """Corridors and other open areas by name; where two spaces overlap there is no wall."""
    doors: tuple[DoorOpening, ...] = ()
    """Openings in the walls."""
    furniture: tuple[Furniture, ...] = ()
    """Objects on the floor."""
    places: dict[str, Point] = Field(default_factory=dict)
    """Additional named points, m."""
    source: str = ""
    """Source of the plan for error messages, usually the file."""

    @property
    def spaces(self) -> dict[str, Space]:
        """Rooms and corridors by name."""
        return {**self.rooms, **self.corridors}

    @property
    def openings(self) -> Floats:
        """Ends (doors, 2, 2) of the openings, on the centre lines of their walls, m."""
        out = np.empty((len(self.doors), 2, 2))
        for k, door in enumerate(self.doors):
            a, b = _nearest_wall(self, door)
            along = (b - a) / np.hypot(*(b - a))
            middle = a + along * np.dot(np.array(door.at) - a, along)
            out[k] = middle - along * door.width / 2.0, middle + along * door.width / 2.0
        return out

    def draw(self) -> tuple[OccupancyGrid, Places]:
        """Draw the floor as a grid, and list its named places.

        The place of a room or corridor is its area; its point is the given one, or the free point
        with the most clearance.

        Raises:
            ConfigError: if something lies outside the map, a door not in a wall, a name is used
                twice, or furniture leaves a room no floor; carries source and dotted key.
        """
        _check(self)
        canvas = Canvas(size=self.size, resolution=self.resolution, outside=self.outside)
        outlines = [space.corners for space in self.spaces.values()]
        for corners in outlines:
            canvas.wall(corners, self.wall)
        for corners in outlines:
            canvas.floor(corners, self.wall)
        for door in self.doors:
            a, b = _nearest_wall(self, door)
            canvas.opening(np.array(door.at), a, b, door.width, self.wall)
        for piece in self.furniture:
            for corners in piece.outlines:
                canvas.block(corners)
        places = Places(places=tuple(_places(self, canvas)), source=self.source or "the floor plan")
        return canvas.grid(), places

    def heights(self) -> Floats32:
        """Heights of the furniture on the cells (rows, cols) of the grid, m; NaN elsewhere."""
        canvas = Canvas(size=self.size, resolution=self.resolution, outside=self.outside)
        for piece in self.furniture:
            for corners in piece.outlines:
                canvas.rise(corners, np.nan if piece.height is None else piece.height)
        return canvas.heights()


def read_floor_plan(file: Path | str) -> FloorPlan:
    """Read a floor plan from a YAML file.

    Raises:
        ConfigError: with file, dotted key and remedy.
    """
    file = Path(file)
    plan = config.load(FloorPlan, file).model_copy(update={"source": str(file)})
    _check(plan)
    return plan


def _check(plan: FloorPlan) -> None:
    """Refuse errors that concern several parts of the plan."""
    file = plan.source or None
    seen: set[str] = set()
    for group in ("rooms", "corridors", "places"):
        for name in getattr(plan, group):
            key = f"{group}.{name}"
            if name.casefold() in seen:
                raise ConfigError("the name is used twice", file=file, key=key)
            seen.add(name.casefold())
    if not plan.spaces:
        raise ConfigError("a floor needs a room or a corridor", file=file, key="rooms")
    for key, points in _everything(plan):
        if np.any(points < 0.0) or np.any(points > np.array(plan.size)):
            w, h = plan.size
            raise ConfigError(f"reaches outside the map of {w:g} x {h:g} m", file=file, key=key)
    for i, door in enumerate(plan.doors):
        problem = _misfit(plan, door)
        if problem:
            raise ConfigError(problem, file=file, key=f"doors.{i}")


def _everything(plan: FloorPlan) -> Iterator[tuple[str, Floats]]:
    """Dotted key and points (k, 2) of everything that must lie on the map."""
    for group in ("rooms", "corridors"):
        for name, space in getattr(plan, group).items():
            yield f"{group}.{name}", space.corners
            if space.point is not None:
                yield f"{group}.{name}.point", np.array([space.point])
    for i, door in enumerate(plan.doors):
        yield f"doors.{i}.at", np.array([door.at])
    for i, piece in enumerate(plan.furniture):
        yield f"furniture.{i}", piece.outlines.reshape(-1, 2)
    for name, point in plan.places.items():
        yield f"places.{name}", np.array([point])


def _misfit(plan: FloorPlan, door: DoorOpening) -> str:
    """Describe the error of a door's position; empty if it is correct."""
    a, b = _nearest_wall(plan, door)
    length = float(np.hypot(*(b - a)))
    along = float(np.dot(np.array(door.at) - a, b - a)) / length
    off = float(np.hypot(*(a + (b - a) * along / length - np.array(door.at))))
    if off > _DOOR_REACH or not 0.0 <= along <= length:
        return f"no wall within {_DOOR_REACH:g} m of ({door.at[0]:g}, {door.at[1]:g})"
    room = 2.0 * min(along, length - along) - plan.wall
    if door.width > room + 1e-9:
        return f"{door.width:g} m wide, but its wall has {max(room, 0.0):.2f} m there"
    return ""


def _nearest_wall(plan: FloorPlan, door: DoorOpening) -> tuple[Floats, Floats]:
    """Ends of the wall segment nearest to a door; the longest of several."""
    starts = np.concatenate([s.corners for s in plan.spaces.values()])
    ends = np.concatenate([np.roll(s.corners, -1, axis=0) for s in plan.spaces.values()])
    along = ends - starts
    length2 = np.sum(along**2, axis=-1)
    offset = np.array(door.at) - starts
    t = np.clip(np.sum(offset * along, axis=-1) / length2, 0.0, 1.0)
    distance = np.hypot(*(offset - t[:, None] * along).T)
    best = int(np.lexsort((-length2, np.round(distance, 3)))[0])
    return starts[best], ends[best]


def _places(plan: FloorPlan, canvas: Canvas) -> Iterator[NamedPlace]:
    clearance = canvas.clearance()
    for name, space in plan.spaces.items():
        corners = space.corners
        point, room = canvas.roomiest(corners, clearance)
        if room <= 0.0:
            key = f"{'rooms' if name in plan.rooms else 'corridors'}.{name}"
            raise ConfigError("no free floor is left in it", file=plan.source or None, key=key)
        at = point if space.point is None else np.array(space.point)
        yield NamedPlace(name=name, point=at, polygon=corners)
    for name, given in plan.places.items():
        yield NamedPlace(name=name, point=np.array(given))


def _corners(rect: tuple[float, ...] | None, polygon: tuple[Point, ...] | None) -> Floats:
    return polygon_of_rect(rect) if rect is not None else np.array(polygon, dtype=float)


def _along(line: Floats, width: float) -> Floats:
    """Corners (4, 2) of the rectangle around a line (2, 2)."""
    direction = (line[1] - line[0]) / np.hypot(*(line[1] - line[0]))
    aside = 0.5 * width * np.array([-direction[1], direction[0]])
    return np.concatenate([line - aside, line[::-1] + aside])


def _exactly_one(model: config.Model, *names: str) -> None:
    given = [name for name in names if getattr(model, name) is not None]
    if len(given) != 1:
        raise ValueError(f"give exactly one of {', '.join(names)}")
