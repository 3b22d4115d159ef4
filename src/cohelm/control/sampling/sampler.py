"""Sampler of candidate trajectories: three-segment arcs over a longer horizon than the plan's.

A gradient method stays in one homotopy class. Some hundred arcs explore the others: a seeded table,
of which many arcs return to the path, then perturbations of the best ones and of the last plan. The
objective ranks them, as it ranks everything else.

The vector of the sides on which a candidate passes people and the path approximates its homotopy
class: trajectories of one class agree in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape, read_only
from cohelm.config import Model
from cohelm.control.api import Trajectory
from cohelm.control.objective_tables import workspace
from cohelm.control.optimal_control import PreparedControl
from cohelm.control.path import SPACING, PathTable
from cohelm.control.sampling.arc_table import NO_PERTURBATION, arc_table, perturbations
from cohelm.control.sampling.search import SearchBudget, evaluate_inputs, search_arcs
from cohelm.kernels import CACHED, callee

_NEAR = 3.0
"""A person who is never nearer than this is not passed, m."""
_SWEPT = 0.7
"""A person whose bearing turns by less than this is not passed, rad."""
_SLACK = 1e-6
_BESIDE = 0.35
"""A trajectory that leaves the path by this passes an obstacle, m."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CandidateTrajectories:
    """Trajectories over the whole horizon, in the order of their source; unchecked."""

    step: float
    """Between states, s."""
    inputs: Annotated[Floats, Shape("k N m")]
    poses: Annotated[Floats, Shape("k N+1 3")]
    cost: Annotated[Floats, Shape("k")]
    """Objective, s: lost time, and all other costs in the same unit."""
    by_term: Annotated[Floats, Shape("k T")]
    """Summands of the cost, ``objective.TERMS`` and terms of one's own."""
    slack: Annotated[Floats, Shape("k")]
    """Largest violation of a barrier, m."""
    passing_sides: Annotated[Integers, Shape("k passed")]
    """Signs: first the side of the path (1 left, −1 right, 0 along), then the turn of the bearing
    to each person during the passage (1 counter-clockwise: the robot stays to the right of the
    person, −1 to the left, 0 no passage)."""

    def __len__(self) -> int:
        """Number of trajectories."""
        return len(self.cost)

    def __getitem__(self, chosen: Integers) -> CandidateTrajectories:
        """Some of the trajectories."""
        return CandidateTrajectories(
            step=self.step,
            inputs=self.inputs[chosen],
            poses=self.poses[chosen],
            cost=self.cost[chosen],
            by_term=self.by_term[chosen],
            slack=self.slack[chosen],
            passing_sides=self.passing_sides[chosen],
        )


@njit(**CACHED)
def passing_sides(poses: Floats, positions: Floats, path: PathTable) -> Integers:
    """(k, 1 + n) as ``CandidateTrajectories.passing_sides``.

    poses: (k, N+1, 3).  positions: (n, N+1, 2) of people.
    """
    out = np.zeros((poses.shape[0], 1 + positions.shape[0]), np.int64)
    for w in range(poses.shape[0]):
        out[w, 0] = _side_of_path(poses[w], path.samples)
        for i in range(positions.shape[0]):
            out[w, 1 + i] = _turn_of_bearing(poses[w], positions[i])
    return out


@callee()
def _side_of_path(poses: Floats, samples: Floats) -> int:
    """Side of the largest lateral distance from the path; 0 if that is small."""
    largest = 0.0
    i, last = 0, samples.shape[0] - 1
    for k in range(poses.shape[0]):
        dx, dy = poses[k, 0] - samples[i, 0], poses[k, 1] - samples[i, 1]
        while i < last and dx * samples[i, 2] + dy * samples[i, 3] > SPACING:
            i += 1
            dx, dy = poses[k, 0] - samples[i, 0], poses[k, 1] - samples[i, 1]
        d = samples[i, 2] * dy - samples[i, 3] * dx
        if abs(d) > abs(largest):
            largest = d
    return int(math.copysign(1.0, largest)) if abs(largest) > _BESIDE else 0


@callee()
def _turn_of_bearing(poses: Floats, positions: Floats) -> int:
    """Sign of the turn of the bearing from the robot to a person; 0 if nobody is passed."""
    # without square roots first: most people are far away
    square = np.inf
    for k in range(1, poses.shape[0]):
        u, v = positions[k, 0] - poses[k, 0], positions[k, 1] - poses[k, 1]
        square = min(square, u * u + v * v)
    if square > _NEAR * _NEAR + _SLACK:
        return 0
    turned, nearest = 0.0, np.inf
    x, y = positions[0, 0] - poses[0, 0], positions[0, 1] - poses[0, 1]
    for k in range(1, poses.shape[0]):
        u, v = positions[k, 0] - poses[k, 0], positions[k, 1] - poses[k, 1]
        turned += math.atan2(x * v - y * u, x * u + y * v)
        nearest = min(nearest, math.hypot(u, v))
        x, y = u, v
    return int(math.copysign(1.0, turned)) if nearest < _NEAR and abs(turned) > _SWEPT else 0


_EXAMINED = 24
"""Arcs among which different homotopy classes are selected."""
_ELITE = 4
"""Arcs that are perturbed in each round."""
_CLASSES = 4
"""Maximum number of different homotopy classes in the result."""
_WINDOW = 2.5
"""Candidates that cost more than the best one by this are dropped, s."""

_NO_PERTURBATION = read_only(NO_PERTURBATION.copy())  # as the rows of the arc table


class Sampling(Model):
    """Horizon and budget of the search; tuned on rides."""

    horizon: float = Field(6.0, gt=0.0, le=20.0)
    """Horizon of the objective, s; never less than that of the plan."""
    stride: int = Field(2, ge=1, le=10)
    """Steps of the problem per step of the search; its results are evaluated in all steps."""
    count: int = Field(160, ge=50, le=20_000)
    """Arcs of the table."""
    perturbations: int = Field(40, ge=0, le=1000)
    """Perturbations of each of the best arcs and of the last plan, per round; at least two."""
    rounds: int = Field(1, ge=0, le=10)
    """Rounds of perturbation."""

    def steps(self, step: float, planned: int) -> int:
        """L, steps of the objective: a multiple of the stride, at least those of the plan."""
        least = max(round(self.horizon / step), planned)
        return self.stride * -(-least // self.stride)


def sample(
    prepared: PreparedControl, budget: Sampling, warm: Trajectory | None = None
) -> CandidateTrajectories:
    """The best sampled trajectories of different homotopy classes, cheapest first.

    Args:
        prepared: the problem.
        budget: of the search.
        warm: the last plan from now on, which is perturbed as well; if given it is the first row,
            before the sampled ones.
    """
    scene, objective = prepared.coarser(budget.stride)
    m = len(scene.robot.current_input)
    previous = np.empty((0, m)) if warm is None else warm.inputs[: prepared.scene.steps]
    arcs = search_arcs(
        scene,
        objective,
        _averaged(previous, budget.stride),
        arc_table(budget.count),
        perturbations(budget.perturbations),
        SearchBudget(budget.rounds, _ELITE, _WINDOW, _EXAMINED),
        work=workspace(scene, objective),
    )
    sampled = np.repeat(arcs, budget.stride, axis=1)
    if warm is None:
        found = evaluate(prepared, sampled)
    else:
        found = evaluate(prepared, previous[None], sampled)
    first = len(found) - len(arcs)
    order = first + np.argsort(found.cost[first:], kind="stable")
    chosen = _of_different_classes(found.passing_sides, order, _CLASSES)
    return found[np.concatenate([np.arange(first), chosen])]


def evaluate(prepared: PreparedControl, *inputs: Floats) -> CandidateTrajectories:
    """Any trajectories with their costs, in the given order.

    Args:
        prepared: the problem.
        inputs: (k, K, m) each; beyond K steps a trajectory leads back to the path.
    """
    scene, work = prepared.scene, prepared.work
    count, m = sum(map(len, inputs)), inputs[0].shape[2]
    limited = np.empty((count, scene.steps, m))
    poses = np.empty((count, scene.steps + 1, 3))
    by_term = np.empty((count, len(work.by_term)))
    cost, slack = np.empty(count), np.empty(count)
    begin = 0
    for each in inputs:
        # a copy: read-only inputs would compile the rollout a second time
        given = np.array(each[:, : scene.steps], dtype=float, order="C")
        rows = slice(begin, begin + len(given))
        evaluate_inputs(
            scene, prepared.objective, given, _NO_PERTURBATION, limited[rows], poses[rows],
            by_term[rows], cost[rows], slack[rows], work,
        )  # fmt: skip
        begin += len(given)
    return CandidateTrajectories(
        step=scene.step,
        inputs=limited,
        poses=poses,
        cost=cost,
        by_term=by_term,
        slack=slack,
        passing_sides=passing_sides(poses, likeliest(prepared), scene.path),
    )


@lru_cache(maxsize=1)  # of one plan, whose samples and solutions are evaluated
def likeliest(prepared: PreparedControl) -> Floats:
    """Most likely positions of each person, (n, L+1, 2)."""
    weight = prepared.problem.predictions.weight
    people, hypotheses = weight.shape
    likely = weight.argmax(axis=1) if people else np.empty(0, np.int64)
    rows = hypotheses * np.arange(people) + likely
    return np.ascontiguousarray(prepared.scene.people.states[rows, :, :2])


@njit(**CACHED)
def _of_different_classes(sides: Integers, order: Integers, count: int) -> Integers:
    """The first ``count`` of ``order`` with pairwise different rows of ``sides`` (k, 1 + n)."""
    chosen = np.empty(count, np.int64)
    n = 0
    for candidate in order:
        if n == count:
            break
        known = False
        for c in range(n):
            same = True
            for a in range(sides.shape[1]):
                same &= sides[candidate, a] == sides[chosen[c], a]
            known |= same
        if not known:
            chosen[n] = candidate
            n += 1
    return chosen[:n]


def _averaged(inputs: Floats, stride: int) -> Floats:
    """Inputs (K, m) averaged over ``stride`` at a time; an incomplete last part is dropped."""
    whole = len(inputs) // stride
    return np.asarray(inputs[: whole * stride].reshape(whole, stride, inputs.shape[1]).mean(axis=1))
