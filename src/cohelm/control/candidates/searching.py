"""Which arcs are ridden: those of the table, then the best of them and the last plan, pushed."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.control.candidates.riding import Prices, Ride, ride
from cohelm.control.candidates.scene import Scene

_NONE = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.2, 0.5, 2.0])
"""A push that changes nothing."""
_APART = 0.2
"""Arcs count as different whose middles or ends lie so far apart, m."""


@njit(cache=True)
def searched(  # noqa: PLR0913, PLR0917  # a kernel takes what it works on one by one
    scene: Scene,
    prices: Prices,
    warm: Floats,
    table: Floats,
    pushes: Floats,
    rounds: int,
    elite: int,
    spread: float,
    most: int,
) -> Floats:
    """Inputs (j, N, m) of at most ``most`` arcs, the cheapest first, all some way apart.

    Args:
        scene: to ride through.
        prices: of what happens.
        warm: (L, m) inputs of the last plan; L = 0: there is none.
        table: (a, 9) arcs to begin with.
        pushes: (b, 9), the first of which changes nothing.
        rounds: how often the best ones are pushed.
        elite: how many of them each time.
        spread: arcs dearer than the best one by more than this are of no interest, s.
        most: how many are wanted.
    """
    steps, m = scene.steps, scene.body.now.shape[0]
    started = 1 if warm.shape[0] > 0 else 0
    each = elite + 1
    total = started + table.shape[0] + rounds * each * pushes.shape[0]
    costs, marks = np.full(total, np.inf), np.empty((total, 4))
    base_of, push_of = np.empty(total, np.int64), np.empty(total, np.int64)
    bases = np.empty((1 + rounds * each, steps, m))
    lengths, worth = np.zeros(1 + rounds * each, np.int64), np.full(1 + rounds * each, np.inf)
    due = np.empty(scene.crowd.states.shape[0])
    inputs, poses = np.empty((steps, m)), np.empty((steps + 1, 3))
    nothing, empty = _NONE.copy(), np.empty((0, m))
    if started:
        lengths[0] = min(warm.shape[0], steps)
        bases[0, : lengths[0]] = warm[: lengths[0]]
    best, n = np.inf, 0
    for a in range(started + table.shape[0]):
        if a < started:
            base, push = bases[0, : lengths[0]], nothing
        else:
            base, push = empty, table[a - started]
        done = ride(scene, prices, base, push, best + spread, inputs, poses, due)
        costs[n], base_of[n], push_of[n] = done.cost, -1, a - started
        _mark(marks[n], poses)
        best = min(best, done.cost)
        n += 1
    if started:
        base_of[0], worth[0] = 0, costs[0]
    filled = 1
    for each_round in range(rounds):
        chosen = _apart(costs[:n], marks[:n], elite, best + spread)
        first = filled if each_round > 0 or not started else 0
        for c in chosen:
            base, push = _made_of(
                bases, lengths, base_of[c], push_of[c], table, pushes, empty, nothing
            )
            done = ride(scene, prices, base, push, np.inf, inputs, poses, due)
            if done.stopped < steps:
                _brake(scene, inputs, done.stopped)
            bases[filled] = inputs
            lengths[filled], worth[filled] = steps, costs[c]
            filled += 1
        for b in range(first, filled):
            for p in range(1, pushes.shape[0]):
                base = bases[b, : lengths[b]]
                most_of = min(best + spread, worth[b])  # or nothing is gained
                done = ride(scene, prices, base, pushes[p], most_of, inputs, poses, due)
                costs[n], base_of[n], push_of[n] = done.cost, b, p
                _mark(marks[n], poses)
                best = min(best, done.cost)
                n += 1
    chosen = _apart(costs[:n], marks[:n], most, best + spread)
    out = np.empty((chosen.shape[0], steps, m))
    for j in range(chosen.shape[0]):
        c = chosen[j]
        base, push = _made_of(bases, lengths, base_of[c], push_of[c], table, pushes, empty, nothing)
        done = ride(scene, prices, base, push, np.inf, inputs, poses, due)
        if done.stopped < steps:
            _brake(scene, inputs, done.stopped)
        out[j] = inputs
    return out


@njit(cache=True)
def judged(scene: Scene, prices: Prices, given: Floats, limited: Floats, poses: Floats) -> Floats:
    """(cost, first contact) (j, 2) of inputs (j, L, m); fills what they lead to.

    Args:
        scene: to ride through.
        prices: of what happens.
        given: (j, L, m); after L steps the way leads back to the path.
        limited: (j, N, m), filled with the inputs as the limits allow them.
        poses: (j, N+1, 3), filled.
    """
    out = np.empty((given.shape[0], 2))
    due = np.empty(scene.crowd.states.shape[0])
    nothing = _NONE.copy()
    for j in range(given.shape[0]):
        done: Ride = ride(scene, prices, given[j], nothing, np.inf, limited[j], poses[j], due)
        for k in range(done.stopped + 1, scene.steps):  # the rest of a ride that a wall ended
            _fade(scene, limited[j], poses[j], k)
        out[j, 0], out[j, 1] = done.cost, done.contact
    return out


@njit(cache=True)
def _made_of(  # noqa: PLR0917  # a kernel takes what it works on one by one
    bases: Floats,
    lengths: Integers,
    base: int,
    push: int,
    table: Floats,
    pushes: Floats,
    empty: Floats,
    nothing: Floats,
) -> tuple[Floats, Floats]:
    if base < 0:
        return empty, table[push]
    return bases[base, : lengths[base]], nothing if push < 0 else pushes[push]


@njit(cache=True)
def _mark(mark: Floats, poses: Floats) -> None:
    """Where a ride is at a third of its time and at its end."""
    third = poses.shape[0] // 3
    mark[0], mark[1] = poses[third, 0], poses[third, 1]
    mark[2], mark[3] = poses[-1, 0], poses[-1, 1]


@njit(cache=True)
def _apart(costs: Floats, marks: Floats, most: int, limit: float) -> Integers:
    """The cheapest arcs, cheapest first, each some way apart from those before it."""
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
def _brake(scene: Scene, inputs: Floats, stopped: int) -> None:
    """Braking in time before the step at which a wall is met."""
    body, joint = scene.body, max(scene.body.translating, 1)
    speed = np.sqrt(np.sum(inputs[stopped, :joint] ** 2))
    begin = max(stopped - int(np.ceil(speed / body.fall[0])) - 1, 0)
    inputs[begin:] = 0.0


@njit(cache=True)
def _fade(scene: Scene, inputs: Floats, poses: Floats, k: int) -> None:
    """Step ``k`` of braking as hard as in ordinary driving."""
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
