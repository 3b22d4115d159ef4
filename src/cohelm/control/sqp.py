"""Condensed Gauss-Newton SQP over the one objective: a solve is one call of compiled code.

The rollout eliminates the states, so that only the inputs Δu and the slacks s are left; all rows of
one person under one barrier, and all rows of the walls, share a slack:

    minimise   g·Δu + ½ Δuᵀ H Δu + Σ l1·s + ½ l2·s²
    subject to margin + G Δu + s ≥ 0,  s ≥ 0,  limits of the inputs and of their change (no slack)

Of the jerk only the first step is limited here: the result is rolled out again within all limits.

g and H are condensed backwards along the trajectory from the local models of the terms (Frison and
Jørgensen 2013): with A and B the derivatives of a step, P_k = Aᵀ P_{k+1} A + Q_k and
H_ij = B_iᵀ P_{i+1} ∂x_{i+1}/∂u_j. Of the second derivatives of a step only the positive one by the
heading is kept: a turn shortens the displacement.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.constraint_rows import (
    keep_stages,
    limit_rows,
    person_rows,
    step_course,
    step_sensitivity,
    wall_rows,
)
from cohelm.control.daqp_call import DaqpAddresses
from cohelm.control.objective import add_models, trajectory_cost
from cohelm.control.objective_tables import Objective
from cohelm.control.qp import minimise
from cohelm.control.scene import Scene
from cohelm.control.solver_tables import SolverWorkspace
from cohelm.kernels import KERNEL, callee

_DAMPING = 1e-4
"""Added to the diagonal, so that every program has one solution."""
_HALVINGS = 6
"""Number of step lengths in the line search."""
FULL = -99
"""Flag: there are more rows than the workspace has space for."""


@njit(**KERNEL)
def solve(
    scene: Scene,
    o: Objective,
    daqp: DaqpAddresses,
    w: SolverWorkspace,
    inputs: Floats,
    iterations: int,
    tolerance: float,
) -> tuple[int, int, float]:
    """(flag ≥ 1 if it succeeds, quadratic programs solved, cost); improves ``inputs`` in place.

    Each step is halved until it lowers the cost.

    Args:
        scene: surroundings.
        o: the objective.
        daqp: the solver of the programs.
        w: workspace.
        inputs: (L, m), of which the first N are changed.
        iterations: the budget.
        tolerance: on every input, m/s and rad/s; below it the iteration ends.
    """
    best, trial, p = w.inputs[0], w.inputs[1], w.program
    _copy(inputs, best)
    _copy(inputs, trial)
    cost = trajectory_cost(scene, o, best, w.poses[0], w.work)
    p.of_inputs[:] = 0.0
    p.of_slacks[:] = 0.0
    p.of_rows[:] = 0.0
    solved, change = 0, np.inf
    size, m = p.gradient.shape[0], inputs.shape[1]
    while solved < iterations and change >= tolerance:
        count = linearise(scene, o, w, best)
        if count < 0:
            return FULL, solved, cost
        flag = minimise(daqp, w, count)
        if flag < 1:
            return flag, solved, cost
        solved += 1
        length, taken, largest = 1.0, 0.0, 0.0
        for i in range(size):
            largest = max(largest, abs(p.z[i]))
        for _ in range(_HALVINGS):
            for i in range(size):
                trial[i // m, i % m] = best[i // m, i % m] + length * p.z[i]
            cost_there = trajectory_cost(scene, o, trial, w.poses[1], w.work)
            if cost_there < cost:
                cost, taken = cost_there, length
                _copy(trial, best)
                _copy(w.poses[1], w.poses[0])  # the next program is made about these
                break
            length *= 0.5
        change = taken * largest
    _copy(best, inputs)
    return 1, solved, cost


@njit(**KERNEL)
def linearise(scene: Scene, o: Objective, w: SolverWorkspace, inputs: Floats) -> int:
    """Fill gradient, Hessian and rows of the program at inputs (L, m); the number of rows.

    −1: the workspace has not enough rows.
    """
    add_models(scene, o, inputs, w.model)
    keep_stages(scene, w, inputs)
    _condense(scene, w, inputs)
    count = limit_rows(scene, w, inputs)
    people, p = scene.people, w.program
    n = people.num_people
    p.l1[:n], p.l1[n : 2 * n], p.l1[2 * n] = o.bodies.l1, o.social.l1, o.walls.l1
    p.l2[:n], p.l2[n : 2 * n], p.l2[2 * n] = o.bodies.l2, o.social.l2, o.walls.l2
    for s in range(p.l2.shape[0]):
        p.l2[s] = max(p.l2[s], _DAMPING)
    keys = p.gradient.shape[0] + scene.planned * scene.robot.facets.shape[0]
    for kind in range(2):
        barrier = o.bodies if kind == 0 else o.social
        for q in range(people.weight.shape[0] if barrier.active else 0):
            if barrier.binds[q] and count >= 0:
                first_key = keys + (kind * people.weight.shape[0] + q) * scene.planned
                count = person_rows(scene, o, w, count, kind, q, first_key)
    keys += 2 * people.weight.shape[0] * scene.planned
    if o.walls.active and count >= 0:
        count = wall_rows(scene, w, count, keys)
    return count


@callee(KERNEL)
def _copy(source: Floats, target: Floats) -> None:
    for k in range(source.shape[0]):
        for i in range(source.shape[1]):
            target[k, i] = source[k, i]


@callee(KERNEL)
def _condense(scene: Scene, w: SolverWorkspace, inputs: Floats) -> None:
    """Gradient and Hessian by all planned inputs, from the local models; see the module's text."""
    poses, q, p = w.poses[0], w.model, w.program
    m, last = inputs.shape[1], scene.steps
    p.hessian[:] = 0.0
    lx, ly, la = 0.0, 0.0, 0.0
    xx, xy, xa, yy, ya, aa = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(last, 0, -1):
        # cost to go from state k on: gradient λ and curvature P
        lx, ly, la = (
            lx + q.pose_gradient[k, 0], ly + q.pose_gradient[k, 1], la + q.pose_gradient[k, 2],
        )  # fmt: skip
        row = q.pose_curvature[k]
        xx, xy, xa = xx + row[0], xy + row[1], xa + row[2]
        yy, ya, aa = yy + row[3], ya + row[4], aa + row[5]
        j = k - 1
        if j < scene.planned:
            course = step_course(w, j)
            for i in range(m):
                bx, by, ba = step_sensitivity(scene, poses, k, j, i, course)
                at = j * m + i
                p.gradient[at] = q.input_gradient[j, i] + bx * lx + by * ly + ba * la
                # V = P b
                vx, vy = xx * bx + xy * by + xa * ba, xy * bx + yy * by + ya * ba
                va = xa * bx + ya * by + aa * ba
                for o in range(j + 1):
                    earlier = step_course(w, o) if o < j else course
                    for r in range(m if o < j else i + 1):
                        sx, sy, sa = step_sensitivity(scene, poses, k, o, r, earlier)
                        p.hessian[at, o * m + r] = vx * sx + vy * sy + va * sa
                p.hessian[at, at] += q.input_curvature[j, i] + _DAMPING
                if j > 0:
                    p.hessian[at, at - m] += q.input_coupling[j, i]
        # back over step j: A = 1 but for ∂(x, y)/∂θ
        ax, ay = -(poses[k, 1] - poses[j, 1]), poses[k, 0] - poses[j, 0]
        la += ax * lx + ay * ly
        # a turn shortens the displacement of its step: curvature where the cost pulls along it
        aa += max(ax * ly - ay * lx, 0.0)
        aa += 2.0 * (ax * xa + ay * ya) + ax * ax * xx + 2.0 * ax * ay * xy + ay * ay * yy
        xa, ya = xa + ax * xx + ay * xy, ya + ax * xy + ay * yy
    for i in range(p.gradient.shape[0]):
        for j in range(i):
            p.hessian[j, i] = p.hessian[i, j]
