"""People, groups, predictions and social spaces: arrays with one row per person."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.shapes import RadialShape


@value
class People:
    """People at one instant, as a struct of arrays; n = 0 if there are none."""

    time: float
    """s."""
    id: Annotated[Integers, Shape("n")]
    """Stable while a person is tracked."""
    mean: Annotated[Floats, Shape("n 4")]
    """(x, y, v_x, v_y), m and m/s."""
    covariance: Annotated[Floats, Shape("n 4 4")]
    heading: Annotated[Floats, Shape("n")]
    """Direction faced, rad; NaN where unknown; of a person at rest, that of the last walk."""
    radius: Annotated[Floats, Shape("n")]
    """Radius of the body's disc, m."""
    confidence: Annotated[Floats, Shape("n")]
    """0…1."""
    source: str = "tracker"
    """``tracker``: from the sensors; anything else is an external source and labels the results."""

    @staticmethod
    def empty(time: float, source: str = "tracker") -> People:
        """Return the record of no people at ``time``."""
        none = np.empty(0)
        return People(
            time=time,
            id=np.empty(0, dtype=np.int64),
            mean=none.reshape(0, 4),
            covariance=none.reshape(0, 4, 4),
            heading=none,
            radius=none,
            confidence=none,
            source=source,
        )

    def __len__(self) -> int:
        """Return the number of people."""
        return len(self.id)


@value
class Groups:
    """Group membership."""

    id: Annotated[Integers, Shape("g")]
    """Stable while a group is tracked."""
    member: Annotated[Integers, Shape("n")]
    """Index of each person's group, −1: alone."""

    @staticmethod
    def alone(n: int) -> Groups:
        """Return ``n`` people without groups."""
        return Groups(id=np.empty(0, dtype=np.int64), member=np.full(n, -1))


@value
class Predictions:
    """Predicted motion of people: hypotheses over the horizon, a Gaussian at every step."""

    step: float
    """Time between steps, s; step 0 is now."""
    names: tuple[str, ...]
    """Names of the h hypotheses."""
    weight: Annotated[Floats, Shape("n h")]
    """Probability of each hypothesis; rows sum to 1."""
    mean: Annotated[Floats, Shape("n h N+1 2")]
    """Positions, m."""
    velocity: Annotated[Floats, Shape("n h N+1 2")]
    """m/s."""
    deviation: Annotated[Floats, Shape("n h N+1")]
    """Standard deviation of the position, the larger axis, m."""


@value
class GroupSpaces:
    """The convex hull of the members' personal spaces over the horizon, by its support function.

    A point p lies outside where p·u > support for some direction u; the largest excess is its
    distance.
    """

    id: Annotated[Integers, Shape("g")]
    """As in ``Groups``."""
    direction: Annotated[Floats, Shape("m")]
    """Directions of the outward normals u, rad, evenly spaced."""
    support: Annotated[Floats, Shape("g N+1 m")]
    """Maximum of p·u over the hull, m."""


@value
class SocialSpaces:
    """Personal spaces over the horizon, and the robot's own space; see ``shapes``."""

    kind: int
    """``shapes.PRINTED``, ``CONTOUR`` or ``ELLIPSE``."""
    scale: float
    """c of eq. (5)."""
    axis: Annotated[Floats, Shape("n h N+1")]
    """Direction of motion, rad; irrelevant for a circle."""
    front: Annotated[Floats, Shape("n h N+1")]
    """σ_h, m; ``side`` and ``rear`` likewise."""
    side: Annotated[Floats, Shape("n h N+1")]
    rear: Annotated[Floats, Shape("n h N+1")]
    floor: float
    """Minimum extent of a person's space, m."""
    robot: Annotated[Floats, Shape("3")]
    """The robot's own (σ_h, σ_s, σ_r) at its measured speed, m."""
    robot_floor: float = 0.0
    """Minimum extent of the robot's own space, m."""
    groups: GroupSpaces | None = None
    """None: the model does not use groups."""

    def shape(self, person: int, hypothesis: int = 0, step: int = 0) -> RadialShape:
        """Shape of one person's space."""
        at = (person, hypothesis, step)
        sigmas = (float(self.front[at]), float(self.side[at]), float(self.rear[at]))
        return RadialShape(self.kind, *sigmas, self.scale, self.floor)
