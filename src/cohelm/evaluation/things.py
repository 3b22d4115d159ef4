"""What stands, opens, closes and is drawn on the floor of a scenario."""

from __future__ import annotations

import itertools
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, model_validator

from cohelm.config import Model
from cohelm.evaluation.company import Length, Point
from cohelm.maps import FilterType


class Obstacle(Model):
    """Something that stands in the world and that the map does not know."""

    at: Point
    """Centre, m."""
    size: tuple[Length, Length] | None = None
    """Width and depth of a rectangle, m."""
    angle_deg: float = 0.0
    """Of the rectangle."""
    radius: Length | None = None
    """Of a disc, m."""
    height: Length | None = None
    """Over the floor, m, for 3-D sensors; none: as high as the walls. A planar scanner sees it
    however low it is."""

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if (self.size is None) == (self.radius is None):
            raise ValueError("give either size: [width, depth] or radius")
        return self


class Door(Model):
    """A door of the true world that is open on the map; it waits for whoever stands in it."""

    at: Point
    """Centre, m."""
    size: tuple[Length, Length]
    """Width and depth of its leaf, m."""
    angle_deg: float = 0.0
    """Of the leaf's width."""
    closed: tuple[tuple[float, float], ...] = Field(min_length=1)
    """From when to when it is closed, s, in order."""

    @model_validator(mode="after")
    def _times_in_order(self) -> Self:
        times = [time for span in self.closed for time in span]
        in_order = all(a < b for a, b in itertools.pairwise(times))
        if times[0] < 0.0 or not in_order:
            raise ValueError("closed must be [[from, to], …] with 0 ≤ from < to < the next from")
        return self

    @property
    def leaf(self) -> Obstacle:
        """What stands there while it is closed."""
        return Obstacle(at=self.at, size=self.size, angle_deg=self.angle_deg)

    def is_closed(self, time: float) -> bool:
        """Whether it is to be closed at ``time``, s."""
        return any(start <= time < end for start, end in self.closed)


class Storey(Model):
    """How high the building is, for 3-D sensors; assumed."""

    wall_height: float = Field(2.5, gt=0.0, le=20.0)
    """m."""
    ceiling: bool = True
    """Whether there is one, on top of the walls."""


class Zone(Model):
    """Where the rider would rather not go."""

    points: tuple[Point, ...] = Field(min_length=1)
    """One point, the ends of a line, or the corners of an outline, m."""
    radius: float = Field(0.0, ge=0.0, le=1000.0)
    """How far the zone reaches beyond them, m."""
    hard: bool = False
    """Never enter it; else only rather not."""

    @model_validator(mode="after")
    def _has_an_inside(self) -> Self:
        if len(self.points) < 3 and self.radius <= 0.0:
            raise ValueError("give a radius, or the three or more corners of an outline")
        return self


class Mask(Model):
    """A mask over the map, after Nav2's costmap filters."""

    type: FilterType
    file: str
    """A map_server YAML file; a relative name is looked for beside the scenario."""
    base: float = Field(0.0, ge=-1e6, le=1e6)
    multiplier: float = Field(1.0, ge=-1e6, le=1e6)


def _ordered(given: Any) -> Any:
    """One point or a list of points, as a list of points."""
    pair = isinstance(given, list | tuple) and len(given) == 2
    single = pair and all(isinstance(x, int | float) for x in given)
    return (tuple(given),) if single else given


Preferred = Annotated[tuple[Point, ...], Field(min_length=1), BeforeValidator(_ordered)]
"""A point that attracts the route, or several that do so in this order, m."""


def _named_map(given: Any) -> Any:
    """A map's file alone, as the mapping that it stands for."""
    return {"map": given} if isinstance(given, str) else given


class OtherMap(Model):
    """Where else a scene is laid."""

    map: str
    """A map_server YAML file; a relative name is looked for beside the scenario, then here."""
    place: int = Field(0, ge=0, le=1000)
    """0: the place most like the scene's own floor, 1: the next one, and so on."""


Onto = Annotated[OtherMap, BeforeValidator(_named_map)]
"""A map's file, or a mapping with the file and which of the places there."""
