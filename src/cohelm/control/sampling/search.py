"""Search over arcs: a table, then perturbations of the cheapest ones and of the last plan."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.control.sampling.arc_table import NO_PERTURBATION
from cohelm.control.sampling.rollout import RolloutWeights, roll_out
from cohelm.control.sampling.scene import RolloutScene

_APART = 0.2
"""Arcs are different if their middles or ends are this far apart, m."""


class SearchBudget(NamedTuple):
    """Size of the search."""

    rounds: int
    """Rounds of perturbation."""
    elite: int
    """Number of arcs that are perturbed in each round."""
    window: float
    """Cost above the best arc from which an arc is abandoned, s."""
    max_results: int
    """Maximum number of arcs to return."""


class _Pool(NamedTuple):
    """All arcs of a search: a base, and a row of the table or of the perturbations."""

    costs: Floats
    """(a,) s."""
    marks: Floats
    """(a, 4) positions (x, y) after a third of the horizon and at its end, m."""
    base_of: Integers
    """(a,) index of the base; −1: none, a row of the table."""
    row_of: Integers
    """(a,) index of the row; −1: no perturbation."""
    bases: Floats
    """(b, N, m) inputs that are perturbed."""
    base_steps: Integers
    """(b,) number of steps that each base has."""
    base_costs: Floats
    """(b,) cost of each base, s."""


class _Workspace(NamedTuple):
    """Arrays of one rollout."""

    inputs: Floats
    """(N, m) of the arc."""
    poses: Floats
    """(N+1, 3) of the arc."""
    due: Floats
    """(P,) step before which each person cannot be near."""
    no_base: Floats
    """(0, m) base without steps."""
    no_perturbation: Floats
    """(9,) perturbation without effect."""


@njit(cache=True)
def search_arcs(
    scene: RolloutScene,
    weights: RolloutWeights,
    warm: Floats,
    table: Floats,
    perturbations: Floats,
    budget: SearchBudget,
) -> Floats:
    """Inputs (j, N, m) of the cheapest arcs, cheapest first, all some distance apart.

    Args:
        scene: surroundings of the robot.
        weights: of the costs.
        warm: (L, m) inputs of the last plan; L = 0: there is none.
        table: (a, 9) arcs to begin with.
        perturbations: (b, 9), the first of which has no effect.
        budget: size of the search.
    """
    steps, m = scene.steps, scene.robot.current_input.shape[0]
    num_warm = 1 if warm.shape[0] > 0 else 0
    num_bases = 1 + budget.rounds * (budget.elite + 1)
    num_arcs = num_warm + table.shape[0] + (num_bases - 1) * perturbations.shape[0]
    pool, work = _empty_pool(num_arcs, num_bases, steps, m), _workspace(scene)
    # the last plan, then the table
    if num_warm:
        pool.base_steps[0] = min(warm.shape[0], steps)
        pool.bases[0, : pool.base_steps[0]] = warm[: pool.base_steps[0]]
    best, n = np.inf, 0
    for a in range(num_warm + table.shape[0]):
        if a < num_warm:
            base, row = pool.bases[0, : pool.base_steps[0]], work.no_perturbation
        else:
            base, row = work.no_base, table[a - num_warm]
        result = roll_out(
            scene, weights, base, row, best + budget.window, work.inputs, work.poses, work.due
        )
        _add(pool, n, result.cost, -1, a - num_warm, work.poses)
        best = min(best, result.cost)
        n += 1
    if num_warm:
        pool.base_of[0], pool.base_costs[0] = 0, pool.costs[0]
    # rounds: the best arcs become bases, and every base is perturbed
    filled = 1
    for i_round in range(budget.rounds):
        chosen = _cheapest_apart(pool.costs[:n], pool.marks[:n], budget.elite, best + budget.window)
        first = filled if i_round > 0 or not num_warm else 0
        for c in chosen:
            _inputs_of(scene, weights, pool, c, table, perturbations, work)
            pool.bases[filled] = work.inputs
            pool.base_steps[filled], pool.base_costs[filled] = steps, pool.costs[c]
            filled += 1
        for b in range(first, filled):
            for p in range(1, perturbations.shape[0]):
                base = pool.bases[b, : pool.base_steps[b]]
                # only improvements of the base
                limit = min(best + budget.window, pool.base_costs[b])
                result = roll_out(
                    scene, weights, base, perturbations[p], limit,
                    work.inputs, work.poses, work.due,
                )  # fmt: skip
                _add(pool, n, result.cost, b, p, work.poses)
                best = min(best, result.cost)
                n += 1
    # the best of all, rolled out again
    chosen = _cheapest_apart(
        pool.costs[:n], pool.marks[:n], budget.max_results, best + budget.window
    )
    out = np.empty((chosen.shape[0], steps, m))
    for j in range(chosen.shape[0]):
        _inputs_of(scene, weights, pool, chosen[j], table, perturbations, work)
        out[j] = work.inputs
    return out


@njit(cache=True)
def evaluate_inputs(
    scene: RolloutScene, weights: RolloutWeights, given: Floats, limited: Floats, poses: Floats
) -> Floats:
    """(cost, first contact) (j, 2) of inputs (j, L, m); fills the resulting trajectory.

    Args:
        scene: surroundings of the robot.
        weights: of the costs.
        given: (j, L, m); after L steps the trajectory leads back to the path.
        limited: (j, N, m), filled with the inputs within the limits.
        poses: (j, N+1, 3), filled.
    """
    out = np.empty((given.shape[0], 2))
    due = np.empty(scene.people.states.shape[0])
    no_perturbation = NO_PERTURBATION.copy()
    for j in range(given.shape[0]):
        result = roll_out(
            scene, weights, given[j], no_perturbation, np.inf, limited[j], poses[j], due
        )
        for k in range(result.stopped + 1, scene.steps):  # the rest after contact with a wall
            _brake_step(scene, limited[j], poses[j], k)
        out[j, 0], out[j, 1] = result.cost, result.contact
    return out


@njit(cache=True)
def _empty_pool(num_arcs: int, num_bases: int, steps: int, m: int) -> _Pool:
    return _Pool(
        np.full(num_arcs, np.inf),
        np.empty((num_arcs, 4)),
        np.empty(num_arcs, np.int64),
        np.empty(num_arcs, np.int64),
        np.empty((num_bases, steps, m)),
        np.zeros(num_bases, np.int64),
        np.full(num_bases, np.inf),
    )


@njit(cache=True)
def _workspace(scene: RolloutScene) -> _Workspace:
    steps, m = scene.steps, scene.robot.current_input.shape[0]
    return _Workspace(
        np.empty((steps, m)),
        np.empty((steps + 1, 3)),
        np.empty(scene.people.states.shape[0]),
        np.empty((0, m)),
        NO_PERTURBATION.copy(),
    )


@njit(cache=True)
def _add(pool: _Pool, n: int, cost: float, base: int, row: int, poses: Floats) -> None:
    """Record arc ``n`` in the pool."""
    third, mark = poses.shape[0] // 3, pool.marks[n]
    pool.costs[n], pool.base_of[n], pool.row_of[n] = cost, base, row
    mark[0], mark[1] = poses[third, 0], poses[third, 1]
    mark[2], mark[3] = poses[-1, 0], poses[-1, 1]


@njit(cache=True)
def _inputs_of(  # noqa: PLR0917  # a kernel takes plain arrays
    scene: RolloutScene,
    weights: RolloutWeights,
    pool: _Pool,
    c: int,
    table: Floats,
    perturbations: Floats,
    work: _Workspace,
) -> None:
    """Roll out an arc of the pool again, into the workspace; it brakes in time before a wall."""
    base_of, row_of = pool.base_of[c], pool.row_of[c]
    if base_of < 0:
        base, row = work.no_base, table[row_of]
    else:
        base = pool.bases[base_of, : pool.base_steps[base_of]]
        row = work.no_perturbation if row_of < 0 else perturbations[row_of]
    result = roll_out(scene, weights, base, row, np.inf, work.inputs, work.poses, work.due)
    if result.stopped < scene.steps:
        robot, n_linear = scene.robot, max(scene.robot.n_linear, 1)
        speed = np.sqrt(np.sum(work.inputs[result.stopped, :n_linear] ** 2))
        begin = max(result.stopped - int(np.ceil(speed / robot.fall[0])) - 1, 0)
        work.inputs[begin:] = 0.0


@njit(cache=True)
def _cheapest_apart(costs: Floats, marks: Floats, count: int, limit: float) -> Integers:
    """At most ``count`` arcs, cheapest first, each some distance from those before it."""
    chosen = np.empty(count, np.int64)
    n = 0
    for c in np.argsort(costs, kind="mergesort"):
        if n == count or not (costs[c] <= limit and costs[c] < np.inf):
            break
        near = False
        for j in range(n):
            d = marks[c] - marks[chosen[j]]
            if math.hypot(d[0], d[1]) < 0.5 * _APART and math.hypot(d[2], d[3]) < _APART:
                near = True
                break
        if not near:
            chosen[n] = c
            n += 1
    return chosen[:n]


@njit(cache=True)
def _brake_step(scene: RolloutScene, inputs: Floats, poses: Floats, k: int) -> None:
    """Step ``k`` of comfort braking."""
    robot, step, pose, m = scene.robot, scene.step, poses[k], inputs.shape[1]
    n_linear = robot.n_linear
    speed = np.sqrt(np.sum(inputs[k - 1, :n_linear] ** 2))
    share = max(1.0 - robot.fall[0] / speed, 0.0) if speed > 0.0 else 0.0
    for i in range(m):
        if i < n_linear:
            inputs[k, i] = share * inputs[k - 1, i]
        else:
            remaining = max(abs(inputs[k - 1, i]) - robot.fall[i], 0.0)
            inputs[k, i] = np.copysign(remaining, inputs[k - 1, i])
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    vy = inputs[k, 1] if n_linear > 1 else 0.0
    poses[k + 1, 0] = pose[0] + step * (cos * inputs[k, 0] - sin * vy)
    poses[k + 1, 1] = pose[1] + step * (sin * inputs[k, 0] + cos * vy)
    poses[k + 1, 2] = pose[2] + step * inputs[k, m - 1]
