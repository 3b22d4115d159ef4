"""Sampler of candidate trajectories: three-segment arcs over a longer horizon than the plan's.

A gradient method stays in one homotopy class. Some hundred arcs explore the others: a seeded table,
of which many arcs return to the path, then perturbations of the best ones and of the last plan. The
objective ranks them, as it ranks everything else.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Integers, read_only
from cohelm.config import Model
from cohelm.control.api import Trajectory
from cohelm.control.objective_tables import workspace
from cohelm.control.optimal_control import PreparedControl
from cohelm.control.sampling.arc_table import NO_PERTURBATION, arc_table, perturbations
from cohelm.control.sampling.candidates import CandidateTrajectories, passing_sides
from cohelm.control.sampling.search import SearchBudget, evaluate_inputs, search_arcs
from cohelm.kernels import CACHED

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
