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

    def probability(self, name: str) -> Floats:
        """Probability (n,) of the hypotheses whose name begins with ``name``; 0 without any.

        ``turns_aside`` covers both sides.
        """
        chosen = np.array([each.startswith(name) for each in self.names], dtype=np.bool_)
        total: Floats = self.weight[:, chosen].sum(axis=1)
        return total

    def most_likely(self) -> Predictions:
        """Return the most likely hypothesis of each person: h = 1."""
        return self.likeliest(1)

    def likeliest(self, k: int) -> Predictions:
        """Return the ``k`` most likely hypotheses of each person, or all if there are fewer.

        They are sorted by falling probability, per person: the first is named ``likeliest``, the
        next ``likeliest_2`` and so on. Weights are normalised to sum to 1.

        Raises:
            ValueError: if k is less than 1.
        """
        if k < 1:
            raise ValueError(f"k must be at least 1, not {k}")
        order = np.argsort(-self.weight, axis=1, kind="stable")[:, :k]
        return self._chosen(order, np.take_along_axis(self.weight, order, axis=1))

    def likely(self, at_least: float) -> Predictions:
        """Return each person's most likely hypothesis, and all others of that probability or more.

        They are ordered and named as in :meth:`likeliest`. Unused columns of a person repeat the
        most likely hypothesis with weight 0, so that they add no constraint.
        """
        order = np.argsort(-self.weight, axis=1, kind="stable")
        weight = np.take_along_axis(self.weight, order, axis=1)
        kept = weight >= at_least
        kept[:, :1] = True
        h = max(int(kept.sum(axis=1).max(initial=1)), 1)
        order = np.where(kept, order, order[:, :1])[:, :h]
        return self._chosen(order, np.where(kept, weight, 0.0)[:, :h])

    def _chosen(self, which: Integers, weight: Floats) -> Predictions:
        """Select hypotheses ``which`` (n, k) of each person, with weights ``weight`` (n, k)."""
        row = np.arange(len(which))[:, None]
        k = which.shape[1]
        return Predictions(
            step=self.step,
            names=("likeliest", *(f"likeliest_{j}" for j in range(2, k + 1))),
            weight=weight / weight.sum(axis=1, keepdims=True),
            mean=self.mean[row, which],
            velocity=self.velocity[row, which],
            deviation=self.deviation[row, which],
        )


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
