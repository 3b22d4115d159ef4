"""Routes, references, and who steers."""

from __future__ import annotations

from dataclasses import field

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value


@value
class WishReport:
    """What a wish does to a route."""

    closest: Annotated[Floats, Shape("w")]
    """Least distance of the path to each attracting point, m."""
    along: Annotated[Floats, Shape("s")] = field(default_factory=lambda: np.empty(0))
    """Mean distance of each stroke's line to the path, m."""
    avoided: Annotated[Floats, Shape("a")] = field(default_factory=lambda: np.empty(0))
    """Least distance of the path to each avoided zone, m; negative: as deep inside."""
    extra_length: float = 0.0
    """Against the path without wishes, m."""
    extra_cost: float = 0.0
    """Against the path without wishes, in the unit of ``Path.cost``."""


@value
class Path:
    """A route from start to goal."""

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
    """The path that would have been taken without wishes, m; the same where there are none."""
    score: float = 0.0
    """What the method minimises, m: weighted length and the price of the wishes; to be compared
    with ``kept_score`` only."""
    kept_score: float | None = None
    """The same of ``RouteProblem.kept``; ∞ where that is blocked by now."""
    pivots: Annotated[Integers, Shape("p")] = field(
        default_factory=lambda: np.empty(0, dtype=np.int64)
    )
    """Indices of the points where no curve that the robot can drive fits, and it must turn on the
    spot instead."""


@value
class Reference:
    """Where the robot should be over the horizon."""

    step: float
    """Time between states, s; state 0 is now."""
    poses: Annotated[Floats, Shape("N+1 3")]
    """Headings unwrapped, continuous with the robot's own."""
    speeds: Annotated[Floats, Shape("N+1")]
    """Wanted forward speed, m/s."""


@value
class Authority:
    """How much the rider steers, and where to."""

    eta: float
    """η, weight of the rider's states in the reference, 0…1; Xu et al., eq. (13) corrected, and in
    a ``Tick`` what is left of it where the chair leads."""
    intent: float
    """i, the number of intents within the time frame."""
    deflection: Annotated[Floats, Shape("2")]
    """The stick after filter and dead zone."""
    twist: Annotated[Floats, Shape("3")]
    """What the stick asks of the wheels."""
    states: Reference
    """Where the rider's command would lead."""
    wants_stop: bool = False
    """The stick is held against the travel."""
