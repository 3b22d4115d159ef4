"""The request: goal, wishes, mode and rider profile."""

from __future__ import annotations

from enum import StrEnum
from typing import Literal

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model


class Mode(StrEnum):
    """Division of control between rider and chair; independent of the local planner.

    Without a destination ``shared`` is ``assisted``.
    """

    AUTONOMOUS = "autonomous"
    """The chair drives alone."""
    SHARED = "shared"
    """The reference blends the path and the rider's input by η."""
    ASSISTED = "assisted"
    """The rider drives, helped with steering: round people and things, along walls, through doors;
    see ``navigation.steering_help``."""
    STOP_ONLY = "stop_only"
    """The rider drives; the whole safety gate applies, separation included, and only slows."""
    MANUAL = "manual"
    """The rider drives; the gate checks freshness, NaN and limits only, so it can collide."""

    @property
    def rider_drives(self) -> bool:
        """The chair does not move while the stick is centred."""
        return self in {Mode.ASSISTED, Mode.STOP_ONLY, Mode.MANUAL}


Side = Literal["left", "right", "none"]
"""Side on which to pass a person, as the rider sees it; ``none``: no preference."""


class RiderProfile(Model):
    """Preferences of the rider, as in the introduction of Xu et al.; the values are assumed."""

    preferred_speed: float = Field(0.8, gt=0.0, le=3.0)
    """Cruising speed, m/s; bounded by the robot's limit."""
    clearance: float = Field(0.05, ge=0.0, le=1.0)
    """Clearance from walls beyond the footprint, m."""
    social_distance: float = Field(0.45, ge=0.0, le=2.0)
    """Minimum extent of a person's social space, m (Hall's intimate distance)."""
    passing_side: Side = "none"
    """Side on which to pass a person if both are equally good."""
    tight_speed: float = Field(3.0, ge=0.1, le=3.0)
    """Highest speed within 0.3 m of walls, m/s; above ``preferred_speed`` it has no effect."""
    tremor_filter: float = Field(0.0, ge=0.0, le=1.0)
    """Time constant of the low-pass on the stick, s; 0 is off."""
    dead_zone: float = Field(0.05, ge=0.0, lt=1.0)
    """Deflection below which the stick counts as centred, share of full deflection."""


@value
class Wish:
    """A preference for the route: points to pass, a line to follow, or a zone to avoid.

    The points of one wish are passed in their order; different wishes in the cheapest order.
    """

    kind: Literal["attract", "avoid", "stroke"] = "attract"
    """``attract``: pass near each point; ``stroke``: follow the line; ``avoid``: keep out of the
    zone. One or two points: the zone extends ``radius`` from the point or segment. Three and more:
    it is the outline, and ``radius`` beyond it."""
    points: Annotated[Floats, Shape("k 2")]
    """(x, y), m."""
    radius: float = 0.0
    """Extent of an avoided zone beyond its points, m."""
    hard: bool = False
    """Never enter the avoided zone, even if no route is left; False: it only costs."""
    visit: bool = False
    """Go to attracting points however long the detour; False: only where it is worth it."""


@value
class Request:
    """Current goal, mode and limits; may change during a ride."""

    goal: Annotated[Floats, Shape("2")]
    """(x, y), m; NaN: no goal, so that the chair moves on rider input only."""
    wishes: tuple[Wish, ...] = ()
    mode: Mode = Mode.SHARED
    profile: RiderProfile = RiderProfile()
    speed_limit: float = np.inf
    """m/s."""
    stop: bool = False
    """The STOP control is pressed, which also acknowledges findings of the health monitor that are
    kept until then."""
    extra_clearance: float = 0.0
    """Clearance from people in addition to the gate's own margin, m."""
    over_edges: bool = False
    """Edges of the floor are no obstacles, and the chair creeps: a therapist stands by."""
