"""What perception and the social model make of it."""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from cohelm.arrays import Annotated, Bytes, Floats, Floats32, Integers, Shape, value


class Sensing(StrEnum):
    """How far what was seen can be trusted."""

    OK = "ok"
    """Sensors spoke, at least one of them anew, and something came back."""
    SILENT = "silent"
    """No sensor spoke since the last observation; tracks coast."""
    NO_RETURNS = "no_returns"
    """A sensor spoke and nothing usable came back: an empty hall, or a blind sensor."""
    CLOCK_STANDS = "clock_stands"
    """No reading is newer than the newest of the same sensor before: time is not known."""
    CLOCK_BACK = "clock_back"
    """A reading is older than the newest of the same sensor before, and left out. Where that
    happens twice running, or all time ran back by more than a second, all tracks begin anew."""
    CLOCK_APART = "clock_apart"
    """A reading's time is more than a second from now, or no number: it is left out."""


@value
class Groups:
    """Who belongs together."""

    id: Annotated[Integers, Shape("g")]
    """Stable over a group's life in view."""
    member: Annotated[Integers, Shape("n")]
    """Index of each person's group, −1: alone."""

    @staticmethod
    def alone(n: int) -> Groups:
        """``n`` people, no groups."""
        return Groups(id=np.empty(0, dtype=np.int64), member=np.full(n, -1))


@value
class Predictions:
    """Where people will be: hypotheses over the horizon, a Gaussian at every step."""

    step: float
    """Time between steps, s; step 0 is now."""
    names: tuple[str, ...]
    """Of the h hypotheses."""
    weight: Annotated[Floats, Shape("n h")]
    """Probability of each hypothesis; rows sum to 1."""
    mean: Annotated[Floats, Shape("n h N+1 2")]
    """Positions, m."""
    velocity: Annotated[Floats, Shape("n h N+1 2")]
    """m/s."""
    deviation: Annotated[Floats, Shape("n h N+1")]
    """Standard deviation of the position, the larger axis, m."""

    def probability(self, name: str) -> Floats:
        """How likely (n,) each person does what is called so; ``turns_aside`` is to either side.

        A name stands for all hypotheses that begin with it; for none, it is 0.
        """
        meant = np.array([each.startswith(name) for each in self.names], dtype=np.bool_)
        found: Floats = self.weight[:, meant].sum(axis=1)
        return found

    def most_likely(self) -> Predictions:
        """One future for each person, the most likely one: h = 1."""
        return self.likeliest(1)

    def likeliest(self, k: int) -> Predictions:
        """The ``k`` most likely hypotheses of each person, or all where there are no more.

        They come in falling order of probability, which may be another one for each person: the
        first is called ``likeliest``, the next ``likeliest_2`` and so on. Weights are made to sum
        to 1 again.

        Raises:
            ValueError: if k is less than 1.
        """
        if k < 1:
            raise ValueError(f"wants one hypothesis or more, not {k}")
        order = np.argsort(-self.weight, axis=1, kind="stable")[:, :k]
        return self._chosen(order, np.take_along_axis(self.weight, order, axis=1))

    def likely(self, at_least: float) -> Predictions:
        """Of each person the most likely hypothesis, and all others of at least that probability.

        They are ordered and called as in :meth:`likeliest`. Who has fewer of them than somebody
        else has the most likely one again in the places left, with weight 0: who wants to keep
        clear of every future of anybody is held to nothing new by it.
        """
        order = np.argsort(-self.weight, axis=1, kind="stable")
        weight = np.take_along_axis(self.weight, order, axis=1)
        kept = weight >= at_least
        kept[:, :1] = True
        h = max(int(kept.sum(axis=1).max(initial=1)), 1)
        order = np.where(kept, order, order[:, :1])[:, :h]
        return self._chosen(order, np.where(kept, weight, 0.0)[:, :h])

    def _chosen(self, which: Integers, weight: Floats) -> Predictions:
        """Hypotheses ``which`` (n, k) of each person, weighted with ``weight`` (n, k)."""
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

    A point p lies outside where p·u > support for some direction u; the greatest excess is its
    distance.
    """

    id: Annotated[Integers, Shape("g")]
    """As in ``Groups``."""
    direction: Annotated[Floats, Shape("m")]
    """Of the outward normals u, rad, evenly spaced."""
    support: Annotated[Floats, Shape("g N+1 m")]
    """The greatest p·u over the hull, m."""


@value
class SocialSpaces:
    """The shape of each person's space over the horizon, and of the robot's own; see ``shapes``."""

    kind: int
    """``shapes.PRINTED``, ``CONTOUR`` or ``ELLIPSE``."""
    scale: float
    """c of eq. (5)."""
    axis: Annotated[Floats, Shape("n h N+1")]
    """Direction of motion, rad; irrelevant for a circle."""
    front: Annotated[Floats, Shape("n h N+1")]
    """σ_h, m; so are the next two."""
    side: Annotated[Floats, Shape("n h N+1")]
    rear: Annotated[Floats, Shape("n h N+1")]
    floor: float
    """Least reach of a person's space, m."""
    robot: Annotated[Floats, Shape("3")]
    """The robot's own (σ_h, σ_s, σ_r) at its measured speed, m."""
    robot_floor: float = 0.0
    """Least reach of the robot's own space, m."""
    groups: GroupSpaces | None = None
    """None: the model knows no groups."""


@value
class Crowding:
    """Where people have been lately: a coarse grid over the floor."""

    density: Annotated[Floats32, Shape("rows cols")]
    """People per m², faded by how long ago they were seen."""
    resolution: float
    """Side of a cell, m."""
    X_MG: Annotated[Floats, Shape("3")]
    """Pose of the grid's lower left corner in the map frame."""
    version: int = 0
    """Grows whenever the density changes by more than fading a little."""


@value
class LiveObstacles:
    """What the sensors have seen lately that is neither in the map nor a person: a rolling window.

    Cells are those of the map's grid, so that ``corner`` says which of them the window covers.
    """

    corner: Annotated[Integers, Shape("2")]
    """(row, column) of the window's first cell in the map's grid; may lie outside it."""
    occupied: Annotated[Bytes, Shape("rows cols")]
    """1 where something stands."""
    version: int
    """Grows whenever a cell changes."""
