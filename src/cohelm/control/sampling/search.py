"""Search over arcs: a table, then perturbations of the best ones and of the last plan."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.control.sampling.rollout import RolloutWeights, roll_out
from cohelm.control.sampling.scene import RolloutScene

_NONE = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.2, 0.5, 2.0])
"""A perturbation without effect."""
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
    most: int
    """Number of arcs to return."""


class _Pool(NamedTuple):
    """All arcs of a search: a base, and a row of the table or of the perturbations."""

    costs: Floats
    """(a,) s."""
    marks: Floats
    """(a, 4) positions after a third of the horizon and at its end."""
    base_of: Integers
    """(a,) index of the base; −1: none, a row of the table."""
    row_of: Integers
    """(a,) index of the row; −1: no perturbation."""
    bases: Floats
    """(b, N, m) inputs that are perturbed."""
    lengths: Integers
    """(b,) known steps of each."""
    worth: Floats
    """(b,) cost of each, s."""


class _Workspace(NamedTuple):
    """Arrays of one rollout."""

    inputs: Floats
    poses: Floats
    due: Floats
    empty: Floats
    """A base without steps."""
    nothing: Floats
    """A perturbation without effect."""


@njit(cache=True)
def search_arcs(
    scene: RolloutScene,
    weights: RolloutWeights,
    warm: Floats,
    table: Floats,
    perturbations: Floats,
    budget: SearchBudget,
) -> Floats:
    """Inputs (j, N, m) of the best arcs, cheapest first, all some distance apart.

    Args:
        scene: surroundings of the robot.
        weights: of the costs.
        warm: (L, m) inputs of the last plan; L = 0: there is none.
        table: (a, 9) arcs to begin with.
        perturbations: (b, 9), the first of which has no effect.
        budget: size of the search.
    """
    steps, m = scene.steps, scene.body.now.shape[0]
    started = 1 if warm.shape[0] > 0 else 0
    each = budget.elite + 1
    total = started + table.shape[0] + budget.rounds * each * perturbations.shape[0]
    pool = _Pool(
        np.full(total, np.inf),
        np.empty((total, 4)),
        np.empty(total, np.int64),
        np.empty(total, np.int64),
        np.empty((1 + budget.rounds * each, steps, m)),
        np.zeros(1 + budget.rounds * each, np.int64),
        np.full(1 + budget.rounds * each, np.inf),
    )
    work = _Workspace(
        np.empty((steps, m)),
        np.empty((steps + 1, 3)),
        np.empty(scene.people.states.shape[0]),
        np.empty((0, m)),
        _NONE.copy(),
    )
    # the last plan, then the table
    if started:
        pool.lengths[0] = min(warm.shape[0], steps)
        pool.bases[0, : pool.lengths[0]] = warm[: pool.lengths[0]]
    best, n = np.inf, 0
    for a in range(started + table.shape[0]):
        if a < started:
            base, row = pool.bases[0, : pool.lengths[0]], work.nothing
        else:
            base, row = work.empty, table[a - started]
        done = roll_out(
            scene, weights, base, row, best + budget.window, work.inputs, work.poses, work.due
        )
        _add(pool, n, done.cost, -1, a - started, work.poses)
        best = min(best, done.cost)
        n += 1
    if started:
        pool.base_of[0], pool.worth[0] = 0, pool.costs[0]
    # rounds: the best arcs become bases, and every base is perturbed
    filled = 1
    for each_round in range(budget.rounds):
        chosen = _apart(pool.costs[:n], pool.marks[:n], budget.elite, best + budget.window)
        first = filled if each_round > 0 or not started else 0
        for c in chosen:
            _inputs_of(scene, weights, pool, c, table, perturbations, work)
            pool.bases[filled] = work.inputs
            pool.lengths[filled], pool.worth[filled] = steps, pool.costs[c]
            filled += 1
        for b in range(first, filled):
            for p in range(1, perturbations.shape[0]):
                base = pool.bases[b, : pool.lengths[b]]
                limit = min(best + budget.window, pool.worth[b])  # only improvements of the base
                done = roll_out(
                    scene, weights, base, perturbations[p], limit,
                    work.inputs, work.poses, work.due,
                )  # fmt: skip
                _add(pool, n, done.cost, b, p, work.poses)
                best = min(best, done.cost)
                n += 1
    # the best of all, rolled out again
    chosen = _apart(pool.costs[:n], pool.marks[:n], budget.most, best + budget.window)
    out = np.empty((chosen.shape[0], steps, m))
    for j in range(chosen.shape[0]):
        _inputs_of(scene, weights, pool, chosen[j], table, perturbations, work)
        out[j] = work.inputs
    return out


@njit(cache=True)
def evaluate_inputs(
    scene: RolloutScene, weights: RolloutWeights, given: Floats, limited: Floats, poses: Floats
) -> Floats:
    """(cost, first contact) (j, 2) of inputs (j, L, m); fills the resulting motion.

    Args:
        scene: surroundings of the robot.
        weights: of the costs.
        given: (j, L, m); after L steps the motion leads back to the path.
        limited: (j, N, m), filled with the inputs within the limits.
        poses: (j, N+1, 3), filled.
    """
    out = np.empty((given.shape[0], 2))
    due = np.empty(scene.people.states.shape[0])
    nothing = _NONE.copy()
    for j in range(given.shape[0]):
        done = roll_out(scene, weights, given[j], nothing, np.inf, limited[j], poses[j], due)
        for k in range(done.stopped + 1, scene.steps):  # the rest after contact with a wall
            _brake_step(scene, limited[j], poses[j], k)
        out[j, 0], out[j, 1] = done.cost, done.contact
    return out


@njit(cache=True)
def _add(pool: _Pool, n: int, cost: float, base: int, row: int, poses: Floats) -> None:
    """Record an arc."""
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
        base, row = work.empty, table[row_of]
    else:
        base = pool.bases[base_of, : pool.lengths[base_of]]
        row = work.nothing if row_of < 0 else perturbations[row_of]
    done = roll_out(scene, weights, base, row, np.inf, work.inputs, work.poses, work.due)
    if done.stopped < scene.steps:
        body, joint = scene.body, max(scene.body.translating, 1)
        speed = np.sqrt(np.sum(work.inputs[done.stopped, :joint] ** 2))
        begin = max(done.stopped - int(np.ceil(speed / body.fall[0])) - 1, 0)
        work.inputs[begin:] = 0.0


@njit(cache=True)
def _apart(costs: Floats, marks: Floats, most: int, limit: float) -> Integers:
    """The cheapest arcs, cheapest first, each some distance from those before it."""
    chosen = np.empty(most, np.int64)
    count = 0
    for c in np.argsort(costs, kind="mergesort"):
        if count == most or not (costs[c] <= limit and costs[c] < np.inf):
            break
        near = False
        for j in range(count):
            d = marks[c] - marks[chosen[j]]
            if math.hypot(d[0], d[1]) < 0.5 * _APART and math.hypot(d[2], d[3]) < _APART:
                near = True
                break
        if not near:
            chosen[count] = c
            count += 1
    return chosen[:count]


@njit(cache=True)
def _brake_step(scene: RolloutScene, inputs: Floats, poses: Floats, k: int) -> None:
    """Step ``k`` of comfort braking."""
    body, step, pose, m = scene.body, scene.step, poses[k], inputs.shape[1]
    joint = body.translating
    speed = np.sqrt(np.sum(inputs[k - 1, :joint] ** 2))
    share = max(1.0 - body.fall[0] / speed, 0.0) if speed > 0.0 else 0.0
    for i in range(m):
        if i < joint:
            inputs[k, i] = share * inputs[k - 1, i]
        else:
            left = max(abs(inputs[k - 1, i]) - body.fall[i], 0.0)
            inputs[k, i] = np.copysign(left, inputs[k - 1, i])
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    aside = inputs[k, 1] if joint > 1 else 0.0
    poses[k + 1, 0] = pose[0] + step * (cos * inputs[k, 0] - sin * aside)
    poses[k + 1, 1] = pose[1] + step * (sin * inputs[k, 0] + cos * aside)
    poses[k + 1, 2] = pose[2] + step * inputs[k, m - 1]
