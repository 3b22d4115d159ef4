"""Paths, references, and the rider's authority."""

from __future__ import annotations

from dataclasses import field

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value


@value
class WishReport:
    """Effect of the wishes on a path."""

    closest: Annotated[Floats, Shape("w")]
    """Minimum distance of the path to each attracting point, m."""
    along: Annotated[Floats, Shape("s")] = field(default_factory=lambda: np.empty(0))
    """Mean distance of each stroke's line to the path, m."""
    avoided: Annotated[Floats, Shape("a")] = field(default_factory=lambda: np.empty(0))
    """Minimum distance of the path to each avoided zone, m; negative: depth inside."""
    extra_length: float = 0.0
    """Compared with the path without wishes, m."""
    extra_cost: float = 0.0
    """Compared with the path without wishes, in the unit of ``Path.cost``."""


@value
class Path:
    """A path from start to goal."""

    points: Annotated[Floats, Shape("k 2")]
    """m; about evenly spaced."""
    length: float
    """m."""
    cost: float
    """Length weighted by the costmap, m."""
    method: str
    """The planner's name."""
    wishes: WishReport
    without_wishes: Annotated[Floats, Shape("j 2")]
    """Path planned without the wishes, m; equal to ``points`` if there are none."""
    pivots: Annotated[Integers, Shape("p")] = field(
        default_factory=lambda: np.empty(0, dtype=np.int64)
    )
    """Indices of points at which no drivable curve fits, so that the robot turns on the spot."""
    cusps: Annotated[Integers, Shape("c")] = field(
        default_factory=lambda: np.empty(0, dtype=np.int64)
    )
    """Indices of points at which the robot changes its gear, forward or backward."""
    backs_out: bool = False
    """The first stretch, up to the first cusp, is driven backwards."""


@value
class Reference:
    """Desired states of the robot over the horizon."""

    step: float
    """Time between states, s; state 0 is now."""
    poses: Annotated[Floats, Shape("N+1 3")]
    """Headings unwrapped, continuous with the robot's heading."""
    speeds: Annotated[Floats, Shape("N+1")]
    """Desired forward speed, m/s."""


@value
class Authority:
    """Weight of the rider's input, and the motion that it commands."""

    eta: float
    """η, weight of the rider's states in the reference, 0…1; Xu et al., eq. (13) corrected, and in
    a ``Tick`` reduced where the chair takes over."""
    intent: float
    """i, number of intents within the time frame."""
    deflection: Annotated[Floats, Shape("2")]
    """Stick deflection after filter and dead zone."""
    twist: Annotated[Floats, Shape("3")]
    """Twist commanded by the stick."""
    states: Reference
    """Predicted states under the rider's command."""
    wants_stop: bool = False
    """True while the stick is held against the direction of travel."""
    yields: bool = False
    """The chair yields: it helps the rider with steering, without attraction."""
