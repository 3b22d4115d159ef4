"""Objects of a scenario: obstacles, doors, zones and masks."""

from __future__ import annotations

import itertools
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, model_serializer, model_validator

from cohelm.config import Model
from cohelm.maps import FILTER_TYPES, FilterType
from cohelm.scenarios.pedestrian_spec import Length, Point


class Obstacle(Model):
    """Obstacle in the world that is not on the map."""

    at: Point
    """Centre, m."""
    size: tuple[Length, Length] | None = None
    """Width and depth of a rectangle, m."""
    angle_deg: float = 0.0
    """Rotation of the rectangle, degrees."""
    radius: Length | None = None
    """Radius of a disc, m."""
    height: Length | None = None
    """Height above the floor for 3-D sensors, m; None: as high as the walls. A planar scanner sees
    obstacles of any height."""
    sensed: bool = True
    """False: only the rider sees it, and no sensor: glass, or what hangs over a scanner's plane."""
    solid: bool = True
    """False: floor that the rider avoids, as a wet one; it is not sensed and stops nobody."""

    @model_serializer(mode="wrap")
    def _without_defaults(self, serialize: Any) -> dict[str, Any]:
        """Omit flags that hold: their presence must not change a configuration hash."""
        out: dict[str, Any] = serialize(self)
        flags = ("sensed", "solid")
        return {key: each for key, each in out.items() if key not in flags or not each}

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if (self.size is None) == (self.radius is None):
            raise ValueError("give either size: [width, depth] or radius")
        return self


class ScheduledDoor(Model):
    """Door of the world that is open on the map; it does not close on people or the chair."""

    at: Point
    """Centre, m."""
    size: tuple[Length, Length]
    """Width and depth of its leaf, m."""
    angle_deg: float = 0.0
    """Rotation of the leaf, degrees."""
    closed: tuple[tuple[float, float], ...] = Field(min_length=1)
    """Intervals [from, to] in which it is closed, s, in order."""

    @model_validator(mode="after")
    def _times_in_order(self) -> Self:
        times = [time for interval in self.closed for time in interval]
        in_order = all(a < b for a, b in itertools.pairwise(times))
        if times[0] < 0.0 or not in_order:
            raise ValueError("closed must be [[from, to], …] with 0 ≤ from < to < the next from")
        return self

    @property
    def leaf(self) -> Obstacle:
        """Obstacle that the closed door is."""
        return Obstacle(at=self.at, size=self.size, angle_deg=self.angle_deg)

    def is_closed(self, time: float) -> bool:
        """Check that the door is scheduled to be closed at ``time``, s."""
        return any(start <= time < end for start, end in self.closed)


class Threshold(Model):
    """Bar on the floor."""

    at: Point
    """Centre, m."""
    size: tuple[Length, Length]
    """Width and depth, m."""
    angle_deg: float = 0.0
    """Rotation, degrees."""
    height: float = Field(0.02, gt=0.0, le=0.3)
    """m."""


class FloorLevel(Model):
    """Rectangle of floor at another height: kerb, platform, pit, stairs, ramp with open sides."""

    at: Point
    """Centre, m."""
    size: tuple[Length, Length]
    """Width and depth, m."""
    angle_deg: float = 0.0
    """Rotation, degrees."""
    height: float = Field(0.0, ge=-5.0, le=5.0)
    """Over the floor at the beginning of the width, m; below 0 under it."""
    rise: float = Field(0.0, ge=-5.0, le=5.0)
    """From there to the end of the width, m."""
    steps: int = Field(0, ge=0, le=100)
    """Steps in which it rises or falls; 0: evenly."""
    dark: bool = False
    """True: no sensor has a return of it."""


class Ramp(Model):
    """Ramp across the whole floor, level before and behind."""

    at: Point
    """Beginning, m."""
    direction_deg: float = 0.0
    """Direction, degrees."""
    gradient: float = Field(ge=-0.5, le=0.5)
    """Rise over run: 1:12 is 0.0833."""
    length: float = Field(gt=0.0, le=1000.0)
    """Run, m."""


class Storey(Model):
    """Vertical extent of the building for 3-D sensors and wheels; assumed."""

    wall_height: float = Field(2.5, gt=0.0, le=20.0)
    """Height of the walls, m."""
    ceiling: bool = True
    """Close the storey by a ceiling on top of the walls."""
    levels: tuple[FloorLevel, ...] = ()
    """Floor at other heights; a later one lies on an earlier one."""
    thresholds: tuple[Threshold, ...] = ()
    """Bars on the floor."""
    ramp: Ramp | None = None
    """None: level."""

    @model_serializer(mode="wrap")
    def _without_defaults(self, serialize: Any) -> dict[str, Any]:
        """Omit a flat floor: its presence must not change a configuration hash."""
        out: dict[str, Any] = serialize(self)
        flat = {"levels": not self.levels, "thresholds": not self.thresholds}
        flat["ramp"] = self.ramp is None
        return {key: each for key, each in out.items() if not flat.get(key, False)}

    @model_validator(mode="after")
    def _one_kind_of_ramp(self) -> Self:
        if self.ramp is not None and self.levels:
            raise ValueError("give either ramp or levels, one of which may be a ramp")
        return self


class Zone(Model):
    """Zone that the route should avoid."""

    points: tuple[Point, ...] = Field(min_length=1)
    """One point, the ends of a line, or the corners of a polygon, m."""
    radius: float = Field(0.0, ge=0.0, le=1000.0)
    """Extent of the zone beyond the points, m."""
    hard: bool = False
    """Forbid the zone; otherwise it costs more."""

    @model_validator(mode="after")
    def _has_an_area(self) -> Self:
        if len(self.points) < 3 and self.radius <= 0.0:
            raise ValueError("give a radius, or three or more corners of a polygon")
        return self


class Mask(Model):
    """Mask over the map, after Nav2's costmap filters."""

    type: FilterType | None = None
    """Meaning of its numbers; None: that of ``info``."""
    file: str
    """A map_server YAML file, relative to the scenario's folder."""
    info: str | None = None
    """A parameter file of Nav2's costmap_filter_info_server, which has type, base, multiplier."""
    base: float | None = Field(None, ge=-1e6, le=1e6)
    """None: that of ``info``, else of Nav2's sample configurations; so for ``multiplier``."""
    multiplier: float | None = Field(None, ge=-1e6, le=1e6)

    @model_validator(mode="after")
    def _has_type(self) -> Self:
        if self.type is None and self.info is None:
            raise ValueError(f"give its type ({', '.join(FILTER_TYPES)}) or its info")
        return self


def _as_points(given: Any) -> Any:
    """One point or a list of points, as a list of points."""
    pair = isinstance(given, list | tuple) and len(given) == 2
    single = pair and all(isinstance(x, int | float) for x in given)
    return (tuple(given),) if single else given


Preferred = Annotated[tuple[Point, ...], Field(min_length=1), BeforeValidator(_as_points)]
"""Via point, or several in order, that attract the route, m."""
