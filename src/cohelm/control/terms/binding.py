"""Predicted bodies that a constraint must avoid, and the clearance from each of them.

The most likely hypothesis of each person always binds, others from a probability on. They share
one slack per person. Everything that does not depend on the motion is computed once per problem.
"""

from __future__ import annotations

import functools
import math
import operator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.control.api import LocalProblem
from cohelm.control.terms.barrier import NEAR, Series
from cohelm.messages import People
from cohelm.robots.contact import BRISK

_CACHED = 16
"""Problems of which the result is cached: a few constraints use each of them about ten times."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PersonMargin:
    """Margin about a predicted body at time t: min(now + growth·t + deviations·σ, upper), m.

    σ is the standard deviation of the predicted position. For a standing person only that part
    grows; the growth increases with the person's speed up to 0.5 m/s.
    """

    now: float = 0.0
    growth: float = 0.0
    """m/s."""
    deviations: float = 0.0
    upper: float = math.inf


class BindingPredictions(NamedTuple):
    """The q hypotheses that bind, in the order of people and hypotheses."""

    positions: Floats
    """(q, N+1, 2) m."""
    clearance: Floats
    """(q, N+1) radius of the body plus margin, m."""
    series: Series
    """Each hypothesis by its person (owner) and its index among all n·h (name)."""
    elsewhere: float
    """Lower bound of h for the hypotheses left out as too far away, m; +inf: none."""


class ProblemKey:
    """Cache key of what follows from robot and people alone, independent of the reference."""

    __slots__ = ("_parts", "problem")

    def __init__(self, problem: LocalProblem) -> None:
        self.problem = problem
        p = problem
        self._parts = (p.predictions, p.people, p.spaces, p.robot, p.pose, p.twist)

    def __hash__(self) -> int:
        """Hash of the parts' identities."""
        return hash(tuple(map(id, self._parts)))

    def __eq__(self, other: object) -> bool:
        """Check that the parts are identical objects."""
        return isinstance(other, ProblemKey) and all(map(operator.is_, self._parts, other._parts))


@functools.lru_cache(maxsize=_CACHED)
def binding_predictions(
    problem: LocalProblem,
    min_probability: float,
    margin: PersonMargin,
    gamma: float,
    extent: float,
) -> BindingPredictions:
    """The hypotheses that bind in a problem.

    Hypotheses are left out where the robot cannot come near enough for one of their rows to become
    active: h is then so large that no step of robot and person uses up its share γ.

    Args:
        problem: with the predictions.
        min_probability: from which a hypothesis binds that is not the most likely one.
        margin: kept from bodies.
        gamma: γ of eq. (9).
        extent: largest extent of any space between robot and person, m.
    """
    return _binding(ProblemKey(problem), min_probability, margin, gamma, extent)


@functools.lru_cache(maxsize=_CACHED)
def _binding(
    key: ProblemKey, min_probability: float, margin: PersonMargin, gamma: float, extent: float
) -> BindingPredictions:
    problem = key.problem
    p, steps = problem.predictions, problem.predictions.mean.shape[2]
    robot = problem.robot
    grows: Floats = margin.growth * p.step * np.arange(steps, dtype=np.float64)
    now = margin.now + grows
    speed = max(robot.max_speed, float(np.hypot(*problem.twist[:2])))
    binds, gap = _selected(
        p.weight,
        p.mean,
        problem.pose,
        problem.people.radius + (robot.circumscribed_radius + robot.capsule[4] + extent),
        _Selection(
            min_probability,
            speed * p.step,
            np.minimum(
                now[-1] + margin.deviations * float(p.deviation.max(initial=0.0)), margin.upper
            ),
            gamma,
        ),
    )
    return _gathered(
        binds,
        p.mean,
        p.velocity,
        p.deviation,
        problem.people.radius,
        grows,
        (margin.now, margin.deviations, margin.upper, gap),
    )


class _Selection(NamedTuple):
    """Limits by which hypotheses are selected."""

    min_probability: float
    stride: float
    """Distance that the robot travels in a step, m."""
    margin: float
    """Largest margin, m."""
    gamma: float


@njit(cache=True)
def _selected(
    weight: Floats, mean: Floats, pose: Floats, sizes: Floats, limits: _Selection
) -> tuple[Integers, float]:
    """(1 or 0 for each hypothesis (n·h,), lower bound of h for the far ones among them).

    sizes: (n,) subtracted from distances, m.
    """
    n, h, states = mean.shape[0], mean.shape[1], mean.shape[2]
    out = np.zeros(n * h, dtype=np.int64)
    least = math.inf
    stride = limits.stride
    for i in range(n):
        likeliest = 0
        for j in range(h):
            if weight[i, j] > weight[i, likeliest]:
                likeliest = j
        for j in range(h):
            if j != likeliest and weight[i, j] < limits.min_probability:
                continue
            # the smallest possible gap, and the person's longest step
            nearest, farthest = math.inf, 0.0
            for k in range(states):
                dx, dy = mean[i, j, k, 0] - pose[0], mean[i, j, k, 1] - pose[1]
                gap = math.sqrt(dx * dx + dy * dy) - k * stride - sizes[i] - limits.margin
                nearest = min(nearest, gap)
                if k > 0:
                    dx = mean[i, j, k, 0] - mean[i, j, k - 1, 0]
                    dy = mean[i, j, k, 1] - mean[i, j, k - 1, 1]
                    farthest = max(farthest, math.sqrt(dx * dx + dy * dy))
            if limits.gamma * nearest > NEAR + 2.0 * (stride + farthest):
                least = min(least, nearest)
            else:
                out[i * h + j] = 1
    return out, least


@njit(cache=True)
def _gathered(  # noqa: PLR0917  # a kernel takes plain arrays
    binds: Integers,
    mean: Floats,
    velocity: Floats,
    deviation: Floats,
    radius: Floats,
    grows: Floats,
    margin: tuple[float, float, float, float],
) -> BindingPredictions:
    """The selected hypotheses.

    grows: (N+1,) growth of the margin about a walking person, m.  margin: (now, deviations, upper)
    of ``PersonMargin``, and the lower bound of h for the others.
    """
    now, deviations, upper, gap = margin
    which = np.flatnonzero(binds)
    hypotheses, states = max(mean.shape[1], 1), mean.shape[2]
    person = np.empty(len(which), np.int64)
    positions, clearance = np.empty((len(which), states, 2)), np.empty((len(which), states))
    for q in range(len(which)):
        i, j = which[q] // hypotheses, which[q] % hypotheses
        person[q] = i
        speed = math.hypot(velocity[i, j, 0, 0], velocity[i, j, 0, 1])
        walks = min(speed / BRISK, 1.0)
        for k in range(states):
            positions[q, k, 0], positions[q, k, 1] = mean[i, j, k, 0], mean[i, j, k, 1]
            grown = now + walks * grows[k] + deviations * deviation[i, j, k]
            clearance[q, k] = radius[i] + min(grown, upper)
    series = Series(person, which, mean.shape[0], mean.shape[0] * mean.shape[1])
    return BindingPredictions(positions, clearance, series, gap)


def oncoming_share(people: People, pose: Floats) -> float:
    """Share of the oncoming margin that applies to all walking people, 0 to 1.

    1 for a single person who walks straight towards the robot, less by the cosine for crossing
    people, 0 for people who walk in the robot's direction: the robot yields to crossing people
    instead of driving around them. Positions do not matter, so the margin does not fade during a
    passage. The mean over several people is divided by their number, because a wide margin to one
    would lead into the next. Slow people count in proportion, in full from 0.5 m/s. Assumed.

    Args:
        people: as they are now.
        pose: X_MR, (3,).
    """
    return float(_oncoming(people.mean, math.cos(pose[2]), math.sin(pose[2])))


@njit(cache=True)
def _oncoming(states: Floats, cos: float, sin: float) -> float:
    """Oncoming share of states (n, 4) for a heading."""
    walking, towards = 0.0, 0.0
    for i in range(states.shape[0]):
        vx, vy = states[i, 2], states[i, 3]
        speed = math.hypot(vx, vy)
        if speed > 0.0:
            walks = min(speed / BRISK, 1.0)
            walking += walks
            towards += walks * max(-(cos * vx + sin * vy) / speed, 0.0)
    return towards / walking / max(walking, 1.0) if walking > 0.0 else 0.0
