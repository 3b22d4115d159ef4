"""Who walks through a scenario, and how its file names a part."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import Field, model_serializer, model_validator

from cohelm.config import Model
from cohelm.maps import FARTHEST
from cohelm.plugins import Spec

Coordinate = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
Point = tuple[Coordinate, Coordinate]
Length = Annotated[float, Field(gt=0.0, le=1000.0)]

WALKERS = "orca"
"""How people walk by default."""


def named(name: str) -> Any:
    """A part's key, with the part used by default."""
    return Field(default_factory=lambda: {"use": name})


class Way(Model):
    """Where one person walks."""

    points: tuple[Point, ...] = Field(min_length=1)
    """Way-points from the start on, m."""
    loop: bool = False
    """Walks to the first point again after the last, and so on for ever."""
    speed: float | None = Field(None, gt=0.0, le=3.0)
    """m/s; none: drawn like everybody's."""
    see_robot: bool | None = None
    """None: like everybody."""
    facing_deg: float | None = Field(None, ge=-360.0, le=360.0)
    """Direction faced at first; none: along the way."""


class Group(Model):
    """People who walk together, or stand and talk."""

    points: tuple[Point, ...] = Field(min_length=1)
    """Way-points of their middle, m; a single one: they stand round it and face it."""
    size: int = Field(2, ge=2, le=12)
    """People."""
    spacing: float = Field(0.85, ge=0.5, le=3.0)
    """From neighbour to neighbour, m (assumed: a little more than Moussaïd et al.'s d₀ of 0.8 m,
    under which members of a group keep off each other)."""
    loop: bool = False
    """They walk to the first point again after the last, and so on for ever."""
    speed: float | None = Field(None, gt=0.0, le=3.0)
    """m/s; none: drawn, once for all of them."""
    see_robot: bool | None = None
    """None: like everybody."""


class Flow(Model):
    """A stream of people along a lane."""

    lane: tuple[Point, ...] = Field(min_length=2)
    """The line along its middle, in the direction of walking, m."""
    width: float = Field(2.0, ge=0.0, le=100.0)
    """Of the lane; everybody keeps to a place across it, m."""
    spread: float | None = Field(None, gt=0.0, le=1000.0)
    """People start on so much of the lane from its beginning on, m; none: on all of it."""
    loop: bool = False
    """The lane's end leads to its beginning again, and so do the people."""
    count: int = Field(6, ge=1, le=300)
    """People; where ``people.count`` says how many in all, the flows share them in proportion."""
    speed: float | None = Field(None, gt=0.0, le=3.0)
    """m/s; none: drawn like everybody's."""
    see_robot: bool | None = None
    """None: like everybody."""


class Crowding(Model):
    """Who walks there."""

    count: int | None = Field(None, ge=0, le=300)
    """People; beyond explicit ways and groups those in the flows, and where there are none, ways
    are drawn that cross the robot's. None: as many as ways, groups and flows have."""
    ways: tuple[Way, ...] = ()
    """Explicit ways, one for each person."""
    together: tuple[tuple[Annotated[int, Field(ge=0)], ...], ...] = ()
    """Which of ``ways`` are of people who belong together, by their numbers from 0."""
    groups: tuple[Group, ...] = ()
    """Who walk or stand together; ``social_force`` keeps them so."""
    flows: tuple[Flow, ...] = ()
    """Streams of people along lanes."""
    model: Spec = named(WALKERS)
    """How they walk: a pedestrian model."""
    see_robot: bool = True
    """Whether they avoid the robot."""
    speed: tuple[float, float] = (0.9, 1.3)
    """Range of the preferred speeds, m/s (assumed)."""
    radius: float = Field(0.25, gt=0.05, le=1.0)
    """Of the body's disc, m (assumed)."""
    stature: tuple[float, float] = (1.55, 1.9)
    """Range of the bodies' heights, m (assumed); 3-D sensors see them."""
    jitter: float = Field(0.05, ge=0.0, le=1.0)
    """Starts are moved by up to this, m: ORCA deadlocks in perfect symmetry."""

    @model_serializer(mode="wrap")
    def _without_nobody_together(self, dumped: Any) -> dict[str, Any]:
        """What was written before there was ``together`` is the same experiment."""
        out: dict[str, Any] = dumped(self)
        return {key: each for key, each in out.items() if key != "together" or each}

    @model_validator(mode="after")
    def _ways_once(self) -> Self:
        named = [number for group in self.together for number in group]
        if len(set(named)) < len(named) or max(named, default=-1) >= len(self.ways):
            raise ValueError("together names ways by number, from 0, and none twice")
        return self

    @model_validator(mode="after")
    def _speeds_in_order(self) -> Self:
        if not 0.0 < self.speed[0] <= self.speed[1] <= 3.0:
            raise ValueError("speed must be [lowest, highest] with 0 < lowest ≤ highest ≤ 3 m/s")
        if not 0.5 <= self.stature[0] <= self.stature[1] <= 2.5:
            raise ValueError(
                "stature must be [lowest, highest] with 0.5 ≤ lowest ≤ highest ≤ 2.5 m"
            )
        return self
