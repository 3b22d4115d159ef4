"""Whom a constraint keeps clear of: the futures that bind, and how much is kept from each body.

Of each person the likeliest future always binds, another one from a probability on. They share one
slack: who cannot be kept clear of in one future is not kept clear of. What concerns a future and
not the motion is worked out once a problem.
"""

from __future__ import annotations

import functools
import math
import operator
from dataclasses import dataclass

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Integers, Shape
from cohelm.control.api import LocalProblem, Measure, Rows
from cohelm.control.constraints import barrier
from cohelm.robots.contact import BRISK

_KEPT = 16
"""Problems of which the futures are remembered: a few constraints look at each some ten times."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Margin:
    """How far off a predicted body counts, m, at age t: min(now + growth·t + deviations·σ, most).

    σ is the standard deviation of the predicted position. About who stands nothing grows but that;
    growth becomes whole as people become faster, at 0.5 m/s.
    """

    now: float = 0.0
    growth: float = 0.0
    """m/s."""
    deviations: float = 0.0
    most: float = math.inf


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Futures:
    """The futures that bind, q of them, in the order of people and hypotheses."""

    positions: Annotated[Floats, Shape("q N+1 2")]
    """m."""
    kept: Annotated[Floats, Shape("q N+1")]
    """Radius of the body and margin, m."""
    which: Annotated[Integers, Shape("q")]
    """Index among all n·h futures."""
    person: Annotated[Integers, Shape("q")]
    people: int
    """n."""
    every: int
    """n·h."""
    elsewhere: float
    """What is at least kept from the others that were left out for being far, m; +inf: none."""

    def measure(self, h: Floats, slack: Floats, smallest: float) -> Measure:
        """The far ones bounded.

        h: (q, N+1).  slack, smallest: by person, the worst over futures and steps; of all; both
        from ``barrier.worst_of``.
        """
        return Measure(slack, min(smallest, self.elsewhere), h)

    def rows(
        self, h: Floats, margin: Floats, jacobian: Floats, person: Integers, key: Integers
    ) -> Rows:
        """What ``barrier.rows_of`` found of h (q, N+1), one slack for each person."""
        keys = self.every * (h.shape[1] - 1)
        return Rows(margin, jacobian, person, key, keys, groups=self.people)


class Surroundings:
    """A key for what follows from robot and people alone, the same whatever is to be followed."""

    __slots__ = ("_parts", "problem")

    def __init__(self, problem: LocalProblem) -> None:
        self.problem = problem
        p = problem
        self._parts = (p.predictions, p.people, p.spaces, p.robot, p.pose, p.twist)

    def __hash__(self) -> int:
        """Of the parts' identities."""
        return hash(tuple(map(id, self._parts)))

    def __eq__(self, other: object) -> bool:
        """Whether the parts are the same objects."""
        return isinstance(other, Surroundings) and all(map(operator.is_, self._parts, other._parts))


@functools.lru_cache(maxsize=_KEPT)
def futures(
    problem: LocalProblem, at_least: float, margin: Margin, gamma: float, reach: float
) -> Futures:
    """The futures that bind in a problem.

    Left out are those that the robot can nowhere come so near that a row of theirs becomes active:
    h is then so large that no step of robot and person uses up its share γ.

    Args:
        problem: whose predictions.
        at_least: probability from which on a future binds that is not the likeliest.
        margin: what is kept from bodies.
        gamma: γ of eq. (9).
        reach: greatest reach of any space between robot and person, m.
    """
    return _futures(Surroundings(problem), at_least, margin, gamma, reach)


@functools.lru_cache(maxsize=_KEPT)
def _futures(
    surroundings: Surroundings, at_least: float, margin: Margin, gamma: float, reach: float
) -> Futures:
    problem = surroundings.problem
    p, steps = problem.predictions, problem.predictions.mean.shape[2]
    n, h = p.weight.shape
    robot = problem.robot
    grows: Floats = margin.growth * p.step * np.arange(steps, dtype=np.float64)
    now = margin.now + grows
    speed = max(robot.max_speed, float(np.hypot(*problem.twist[:2])))
    binds, gap = _binding(
        p.weight,
        p.mean,
        at_least,
        problem.pose,
        speed * p.step,
        problem.people.radius + (robot.circumscribed_radius + robot.capsule[4] + reach),
        np.minimum(now[-1] + margin.deviations * float(p.deviation.max(initial=0.0)), margin.most),
        barrier.NEAR,
        gamma,
    )
    which, person, positions, kept = _gathered(
        binds,
        p.mean,
        p.velocity,
        p.deviation,
        problem.people.radius,
        grows,
        margin.now,
        margin.deviations,
        margin.most,
    )
    return Futures(
        positions=positions,
        kept=kept,
        which=which,
        person=person,
        people=n,
        every=n * h,
        elsewhere=gap,
    )


@njit(cache=True)
def _gathered(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    binds: Integers,
    mean: Floats,
    velocity: Floats,
    deviation: Floats,
    radius: Floats,
    grows: Floats,
    now: float,
    deviations: float,
    most: float,
) -> tuple[Integers, Integers, Floats, Floats]:
    """(which, person, positions, kept) of ``Futures``, of those that bind.

    grows: (N+1,) of the margin about who walks.
    """
    which = np.flatnonzero(binds)
    hypotheses, states = max(mean.shape[1], 1), mean.shape[2]
    person = np.empty(len(which), np.int64)
    positions, kept = np.empty((len(which), states, 2)), np.empty((len(which), states))
    for q in range(len(which)):
        i, j = which[q] // hypotheses, which[q] % hypotheses
        person[q] = i
        speed = math.hypot(velocity[i, j, 0, 0], velocity[i, j, 0, 1])
        walks = min(speed / BRISK, 1.0)
        for k in range(states):
            positions[q, k, 0], positions[q, k, 1] = mean[i, j, k, 0], mean[i, j, k, 1]
            grown = now + walks * grows[k] + deviations * deviation[i, j, k]
            kept[q, k] = radius[i] + min(grown, most)
    return which, person, positions, kept


@njit(cache=True)
def _binding(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    weight: Floats,
    mean: Floats,
    at_least: float,
    pose: Floats,
    stride: float,
    kept: Floats,
    margin: float,
    near: float,
    gamma: float,
) -> tuple[Integers, float]:
    """(1 or 0 for each future (n·h,), least h that the far ones among them can have).

    stride: the robot's way in a step, m.  kept: (n,) what is subtracted of distances, m.
    """
    n, h, states = mean.shape[0], mean.shape[1], mean.shape[2]
    out = np.zeros(n * h, dtype=np.int64)
    least = math.inf
    for i in range(n):
        likeliest = 0
        for j in range(h):
            if weight[i, j] > weight[i, likeliest]:
                likeliest = j
        for j in range(h):
            if j != likeliest and weight[i, j] < at_least:
                continue
            nearest, farthest = math.inf, 0.0
            for k in range(states):
                dx, dy = mean[i, j, k, 0] - pose[0], mean[i, j, k, 1] - pose[1]
                gap = math.sqrt(dx * dx + dy * dy) - k * stride - kept[i] - margin
                nearest = min(nearest, gap)
                if k > 0:
                    dx = mean[i, j, k, 0] - mean[i, j, k - 1, 0]
                    dy = mean[i, j, k, 1] - mean[i, j, k - 1, 1]
                    farthest = max(farthest, math.sqrt(dx * dx + dy * dy))
            if gamma * nearest > near + 2.0 * (stride + farthest):
                least = min(least, nearest)
            else:
                out[i * h + j] = 1
    return out, least
