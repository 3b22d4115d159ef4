"""Predicted people that constrain a trajectory, selected once per problem.

The most likely hypothesis of each person always constrains, others from a probability on; all of a
person share one slack. Nothing here depends on the trajectory.
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
from cohelm.control.terms.constraints.barrier import NEAR, BarrierLayout
from cohelm.messages import People
from cohelm.robots.contact import BRISK

_CACHED = 16
"""Problems of which the result is cached: a few constraints use each of them about ten times."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PersonMargin:
    """Margin about a predicted person: min(initial + growth·t + deviations·σ, upper), m.

    σ is the standard deviation of the predicted position. For a standing person only that part
    grows; the growth increases with the person's speed up to 0.5 m/s.
    """

    initial: float = 0.0
    """At t = 0, m."""
    growth: float = 0.0
    """m/s."""
    deviations: float = 0.0
    """Number of standard deviations."""
    upper: float = math.inf
    """m."""


class SelectedPredictions(NamedTuple):
    """The q hypotheses that constrain, in the order of people and hypotheses."""

    positions: Floats
    """(q, N+1, 2) m."""
    clearance: Floats
    """(q, N+1) radius of the person plus margin, m."""
    layout: BarrierLayout
    """Each hypothesis has the slack of its person, and its index among all n·h as identifier."""
    lower_bound_of_others: float
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
def selected_predictions(
    problem: LocalProblem,
    min_probability: float,
    margin: PersonMargin,
    gamma: float,
    extent: float,
) -> SelectedPredictions:
    """The hypotheses that constrain in a problem.

    Hypotheses are left out where the robot cannot come near enough for one of their rows to become
    active: h is then so large that no step of robot and person uses up its share γ.

    Args:
        problem: with the predictions.
        min_probability: from which a hypothesis constrains that is not the most likely one.
        margin: kept from people.
        gamma: γ of eq. (9).
        extent: largest extent of any space between robot and person, m.
    """
    return _selected_predictions(ProblemKey(problem), min_probability, margin, gamma, extent)


@functools.lru_cache(maxsize=_CACHED)
def _selected_predictions(
    key: ProblemKey, min_probability: float, margin: PersonMargin, gamma: float, extent: float
) -> SelectedPredictions:
    problem = key.problem
    p, states = problem.predictions, problem.predictions.mean.shape[2]
    robot = problem.robot
    growth: Floats = margin.growth * p.step * np.arange(states, dtype=np.float64)
    walking_margin = margin.initial + growth
    speed = max(robot.max_speed, float(np.hypot(*problem.twist[:2])))
    selected, lower_bound = _select(
        p.weight,
        p.mean,
        problem.pose,
        problem.people.radius + (robot.circumscribed_radius + robot.capsule[4] + extent),
        _SelectionLimits(
            min_probability,
            speed * p.step,
            np.minimum(
                walking_margin[-1] + margin.deviations * float(p.deviation.max(initial=0.0)),
                margin.upper,
            ),
            gamma,
        ),
    )
    return _gathered(
        selected,
        p.mean,
        p.velocity,
        p.deviation,
        problem.people.radius,
        _GatheredMargin(growth, margin.initial, margin.deviations, margin.upper),
        lower_bound,
    )


class _SelectionLimits(NamedTuple):
    """Limits by which hypotheses are selected."""

    min_probability: float
    stride: float
    """Distance that the robot travels in a step, m."""
    margin: float
    """Largest margin, m."""
    gamma: float


class _GatheredMargin(NamedTuple):
    """``PersonMargin`` for compiled code."""

    growth: Floats
    """(N+1,) growth of the margin about a walking person, m."""
    initial: float
    deviations: float
    upper: float


@njit(cache=True)
def _select(
    weight: Floats, mean: Floats, pose: Floats, sizes: Floats, limits: _SelectionLimits
) -> tuple[Integers, float]:
    """(1 or 0 for each hypothesis (n·h,), lower bound of h for those left out as far away).

    sizes: (n,) subtracted from distances, m.
    """
    n, h, states = mean.shape[0], mean.shape[1], mean.shape[2]
    selected = np.zeros(n * h, dtype=np.int64)
    lower_bound = math.inf
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
            smallest_gap, longest_step = math.inf, 0.0
            for k in range(states):
                dx, dy = mean[i, j, k, 0] - pose[0], mean[i, j, k, 1] - pose[1]
                gap = math.sqrt(dx * dx + dy * dy) - k * stride - sizes[i] - limits.margin
                smallest_gap = min(smallest_gap, gap)
                if k > 0:
                    dx = mean[i, j, k, 0] - mean[i, j, k - 1, 0]
                    dy = mean[i, j, k, 1] - mean[i, j, k - 1, 1]
                    longest_step = max(longest_step, math.sqrt(dx * dx + dy * dy))
            if limits.gamma * smallest_gap > NEAR + 2.0 * (stride + longest_step):
                lower_bound = min(lower_bound, smallest_gap)
            else:
                selected[i * h + j] = 1
    return selected, lower_bound


@njit(cache=True)
def _gathered(  # noqa: PLR0917  # a kernel takes plain arrays
    selected: Integers,
    mean: Floats,
    velocity: Floats,
    deviation: Floats,
    radius: Floats,
    margin: _GatheredMargin,
    lower_bound: float,
) -> SelectedPredictions:
    """The selected hypotheses with their clearance."""
    ids = np.flatnonzero(selected)
    hypotheses, states = max(mean.shape[1], 1), mean.shape[2]
    person = np.empty(len(ids), np.int64)
    positions, clearance = np.empty((len(ids), states, 2)), np.empty((len(ids), states))
    for q in range(len(ids)):
        i, j = ids[q] // hypotheses, ids[q] % hypotheses
        person[q] = i
        speed = math.hypot(velocity[i, j, 0, 0], velocity[i, j, 0, 1])
        walks = min(speed / BRISK, 1.0)
        for k in range(states):
            positions[q, k, 0], positions[q, k, 1] = mean[i, j, k, 0], mean[i, j, k, 1]
            grown = (
                margin.initial + walks * margin.growth[k] + margin.deviations * deviation[i, j, k]
            )
            clearance[q, k] = radius[i] + min(grown, margin.upper)
    layout = BarrierLayout(person, ids, mean.shape[0], mean.shape[0] * mean.shape[1])
    return SelectedPredictions(positions, clearance, layout, lower_bound)


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
