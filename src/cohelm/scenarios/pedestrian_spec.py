"""Pedestrians of a scenario: keys of its ``people`` mapping."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_serializer, model_validator

from cohelm.config import Model
from cohelm.maps import MAX_COORDINATE
from cohelm.plugins import Spec

Coordinate = Annotated[float, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]
Point = tuple[Coordinate, Coordinate]
Length = Annotated[float, Field(gt=0.0, le=1000.0)]

PEDESTRIAN_MODEL = "orca"
"""Default pedestrian model."""


def part_field(name: str) -> Any:
    """Field of a replaceable part, with the name of the default part."""
    return Field(default_factory=lambda: {"use": name})


Body = Literal["disc", "legs", "child", "seated", "walker", "wheelchair", "trolley"]
"""Outline of a pedestrian in planar scans; see ``BodyKind``."""


class PedestrianSpec(Model):
    """One pedestrian with an explicit route."""

    points: tuple[Point, ...] = Field(min_length=1)
    """Waypoints from the start, m."""
    loop: bool = False
    """Return to the first waypoint after the last one, and repeat."""
    speed: float | None = Field(None, gt=0.0, le=3.0)
    """Preferred speed, m/s; None: drawn from ``people.speed``."""
    see_robot: bool | None = None
    """Avoid the robot; None: as ``people.see_robot``."""
    facing_deg: float | None = Field(None, ge=-360.0, le=360.0)
    """Initial heading, degrees; None: towards the second waypoint."""
    body: Body | None = None
    """Outline, size and highest speed; None: drawn from ``people.bodies``."""

    @model_serializer(mode="wrap")
    def _without_default_body(self, serialize: Any) -> dict[str, Any]:
        """Omit ``body`` where it is not given, as in older configuration hashes."""
        out: dict[str, Any] = serialize(self)
        return {key: each for key, each in out.items() if key != "body" or each is not None}


class GroupSpec(Model):
    """Group of pedestrians who walk together, or who stand and talk."""

    points: tuple[Point, ...] = Field(min_length=1)
    """Waypoints of the group's centre, m; with one point the group stands around it, facing it."""
    size: int = Field(2, ge=2, le=12)
    """Number of members."""
    spacing: float = Field(0.85, ge=0.5, le=3.0)
    """Distance between neighbours, m (assumed: slightly above d₀ = 0.8 m of Moussaïd et al., below
    which members of a group repel each other)."""
    loop: bool = False
    """Return to the first waypoint after the last one, and repeat."""
    speed: float | None = Field(None, gt=0.0, le=3.0)
    """Preferred speed of all members, m/s; None: drawn once for the group."""
    see_robot: bool | None = None
    """Avoid the robot; None: as ``people.see_robot``."""


class FlowSpec(Model):
    """Stream of pedestrians along a lane."""

    lane: tuple[Point, ...] = Field(min_length=2)
    """Centre line of the lane in walking direction, m."""
    width: float = Field(2.0, ge=0.0, le=100.0)
    """Width of the lane, m; each pedestrian keeps a constant lateral offset."""
    spread: float | None = Field(None, gt=0.0, le=1000.0)
    """Length of the first part of the lane on which people start, m; None: the whole lane."""
    loop: bool = False
    """Join the end of the lane to its beginning."""
    count: int = Field(6, ge=1, le=300)
    """Number of pedestrians; a weight where ``people.count`` sets the total."""
    speed: float | None = Field(None, gt=0.0, le=3.0)
    """Preferred speed, m/s; None: drawn from ``people.speed``."""
    see_robot: bool | None = None
    """Avoid the robot; None: as ``people.see_robot``."""


class CrowdSpec(Model):
    """All pedestrians of a scenario."""

    count: int | None = Field(None, ge=0, le=300)
    """Total number. Beyond the explicit pedestrians and groups it is shared by the flows; without
    flows, routes that cross the robot's route are drawn. None: as many as are specified."""
    pedestrians: tuple[PedestrianSpec, ...] = ()
    """Pedestrians with explicit routes."""
    grouped: tuple[tuple[Annotated[int, Field(ge=0)], ...], ...] = ()
    """Social groups among ``pedestrians``, as indices from 0."""
    groups: tuple[GroupSpec, ...] = ()
    """Groups that walk or stand together; ``social_force`` keeps them together."""
    flows: tuple[FlowSpec, ...] = ()
    """Streams along lanes."""
    model: Spec = part_field(PEDESTRIAN_MODEL)
    """Pedestrian model."""
    see_robot: bool = True
    """Avoid the robot."""
    speed: tuple[float, float] = (0.9, 1.3)
    """Range of the preferred speeds, m/s (assumed)."""
    radius: float = Field(0.25, gt=0.05, le=1.0)
    """Radius of the body's disc, m (assumed)."""
    stature: tuple[float, float] = (1.55, 1.9)
    """Range of body heights, m (assumed); for 3-D sensors."""
    bodies: dict[Body, Annotated[float, Field(ge=0.0, le=1.0)]] = Field(default_factory=dict)
    """Shares of outlines among pedestrians, which sum to at most 1; the others are discs."""
    jitter: float = Field(0.05, ge=0.0, le=1.0)
    """Largest random offset of a start, m: ORCA deadlocks in perfect symmetry."""

    @model_serializer(mode="wrap")
    def _without_empty_groups(self, serialize: Any) -> dict[str, Any]:
        """Omit keys that are empty: their presence must not change a configuration hash."""
        out: dict[str, Any] = serialize(self)
        return {k: each for k, each in out.items() if k not in {"grouped", "bodies"} or each}

    @model_validator(mode="after")
    def _in_one_group_at_most(self) -> Self:
        indices = [index for group in self.grouped for index in group]
        if len(set(indices)) < len(indices) or max(indices, default=-1) >= len(self.pedestrians):
            raise ValueError("grouped lists indices of pedestrians, from 0, each at most once")
        return self

    @model_validator(mode="after")
    def _shares_of_a_whole(self) -> Self:
        if sum(self.bodies.values()) > 1.0 + 1e-9:
            raise ValueError("the shares of bodies must sum to at most 1")
        return self

    @model_validator(mode="after")
    def _ordered_ranges(self) -> Self:
        if not 0.0 < self.speed[0] <= self.speed[1] <= 3.0:
            raise ValueError("speed must be [lowest, highest] with 0 < lowest ≤ highest ≤ 3 m/s")
        if not 0.5 <= self.stature[0] <= self.stature[1] <= 2.5:
            raise ValueError(
                "stature must be [lowest, highest] with 0.5 ≤ lowest ≤ highest ≤ 2.5 m"
            )
        return self
