"""Condensed Gauss-Newton SQP over the one objective: a solve is one call of compiled code.

The rollout eliminates the states, so that only the inputs Δu and the slacks s are left; all rows of
one person, and all rows of the walls, share a slack:

    minimise   g·Δu + ½ Δuᵀ H Δu + Σ l1·s + ½ l2·s²
    subject to margin + G Δu + s ≥ 0,  s ≥ 0,  limits of the inputs and of their change (no slack)

g and H are condensed backwards along the trajectory from the local models of the terms (Frison and
Jørgensen 2013): with A and B the derivatives of a step, P_k = Aᵀ P_{k+1} A + Q_k and
H_ij = B_iᵀ P_{i+1} ∂x_{i+1}/∂u_j. Of the second derivatives of a step only the positive one by the
heading is kept: a turn shortens the displacement. Most rows of a crowded problem never become
active, so rows are added on demand: solve with the tightest, check the others, add the violated
ones, solve again.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.control.daqp_call import NO_BOUND, DaqpAddresses, DaqpArrays, daqp_arrays, solve_dense
from cohelm.control.kernels import INNER, KERNEL
from cohelm.control.objective import (
    Objective,
    Workspace,
    add_models,
    advanced,
    body_value,
    first_stage,
    social_value,
    trajectory_cost,
    workspace,
)
from cohelm.control.scene import MARGIN, Scene
from cohelm.control.terms import wall_clearance
from cohelm.control.terms.barrier import REACH
from cohelm.control.terms.encounter import (
    bounded,
    extent_gradients,
    gap_gradient,
    state_encounter,
)
from cohelm.control.terms.norms import norm_gradient
from cohelm.control.terms.stage import LocalModel, Stage
from cohelm.maps.distance import sample

_DAMPING = 1e-4
"""Added to the diagonal, so that every program has one solution."""
_HALVINGS = 6
"""Number of step lengths in the line search."""
_FAR = 1e6
"""A bound beyond all inputs of a robot."""
_FIRST, _TIGHT = 96, 0.05
"""First program: maximum number of soft rows, and the margin below which they are used, m."""
_HARD = 0.15
"""First program: distance to a bound below which hard rows are used."""
_TOLERANCE = 1e-7
"""Violation from which a row is added."""
_NEXT = 0.02
"""Rows within this of a violation are added together with a violated one."""
_ROUNDS = 12
"""Rounds of adding rows; then all rows are used."""
_NEAR, _NEAR_WALL = 0.6, 0.25
"""Rows with a larger margin cannot become active within one linearisation, m."""
FULL = -99
"""Flag: there are more rows than the workspace has space for."""


class Rows(NamedTuple):
    """Linearised constraints −margin ≤ G·Δu + s ≤ upper."""

    margin: Floats
    """(r,) distance from the lower bound; negative where violated."""
    upper: Floats
    """(r,) distance from the upper bound."""
    jacobian: Floats
    """G, (r, N·m)."""
    slack: Integers
    """(r,) index of the slack; −1: none."""
    key: Integers
    """(r,) identifier, the same from program to program."""
    used: Booleans
    """(r,) rows of the present program."""
    chosen: Integers
    """(r,) indices of the used rows."""
    left: Floats
    """(r,) distance of unused rows from their bounds."""


class Program(NamedTuple):
    """A quadratic program in DAQP's form, over (Δu, the slacks of the used rows)."""

    hessian: Floats
    """(N·m, N·m)."""
    gradient: Floats
    low: Floats
    high: Floats
    l1: Floats
    """(S,) prices of all slacks, and so on."""
    l2: Floats
    column: Integers
    """(S,) column of each slack; −1: not used."""
    slacks: Integers
    """(S,) the used slacks."""
    whole: Floats
    """Flat, with the slacks, and so on."""
    slope: Floats
    upper: Floats
    lower: Floats
    dual: Floats
    rows: Floats
    z: Floats
    multipliers: Floats
    of_inputs: Floats
    """(N·m,) multipliers of the last program: bounds of the inputs, slacks, rows by key."""
    of_slacks: Floats
    of_rows: Floats
    slack: Floats
    """(S,) solution."""


class SolverWorkspace(NamedTuple):
    """Arrays of one solve."""

    model: LocalModel
    rows: Rows
    program: Program
    daqp: DaqpArrays
    work: Workspace
    inputs: Floats
    """(2, L, m): best and trial."""
    poses: Floats
    """(2, L+1, 3)."""
    h: Floats
    """(N+1,) barrier along the trajectory."""
    stages: Floats
    """(N+1, 6): x, y, heading, cos, sin and path sample of the linearised trajectory."""
    multipliers: Floats
    """(n,) λ of the condensation."""


def solver_workspace(scene: Scene, objective: Objective, rows: int) -> SolverWorkspace:
    """Arrays for problems of this size with at most ``rows`` rows."""
    m, states = len(scene.robot.current_input), scene.steps + 1
    x, people = scene.planned * m, scene.people
    s, keys = 2 * people.count + 1, 0
    keys = x + scene.planned * (
        len(scene.robot.facets) + 2 * len(people.weight) + len(scene.robot.discs)
    )

    def zeros(*shape: int) -> Floats:
        return np.zeros(shape)

    def whole(count: int) -> Integers:
        return np.zeros(count, np.int64)

    size = x + s
    return SolverWorkspace(
        model=LocalModel(
            zeros(states, 3), zeros(states, 6), zeros(scene.steps, m), zeros(scene.steps, m),
            zeros(scene.steps, m),
        ),
        rows=Rows(
            zeros(rows), zeros(rows), zeros(rows, x), whole(rows), whole(rows),
            np.zeros(rows, np.bool_), whole(rows), zeros(rows),
        ),
        program=Program(
            zeros(x, x), zeros(x), zeros(x), zeros(x), zeros(s), zeros(s), whole(s), whole(s),
            zeros(size * size), zeros(size), zeros(size + rows), zeros(size + rows),
            zeros(size + rows), zeros(rows * size), zeros(size), zeros(size + rows),
            zeros(x), zeros(s), zeros(keys), zeros(s),
        ),
        daqp=daqp_arrays(size + rows),
        work=workspace(scene, objective),
        inputs=zeros(2, scene.steps, m),
        poses=zeros(2, states, 3),
        h=zeros(scene.planned + 1),
        stages=zeros(scene.planned + 1, 6),
        multipliers=zeros(3),
    )  # fmt: skip


@njit(**KERNEL)
def solve(  # noqa: PLR0917  # a kernel takes plain values
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
    _keep_stages(scene, w, inputs)
    _condense(scene, w, inputs)
    count = _limit_rows(scene, w, inputs)
    people, p = scene.people, w.program
    n = people.count
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
                count = _person_rows(scene, o, w, count, kind, q, first_key)
    keys += 2 * people.weight.shape[0] * scene.planned
    if o.walls.active and count >= 0:
        count = _wall_rows(scene, w, count, keys)
    return count


@njit(**KERNEL)
def _copy(source: Floats, target: Floats) -> None:
    for k in range(source.shape[0]):
        for i in range(source.shape[1]):
            target[k, i] = source[k, i]


@njit(**KERNEL)
def _keep_stages(scene: Scene, w: SolverWorkspace, inputs: Floats) -> None:
    """Record the planned states of the linearised trajectory."""
    stage = first_stage(scene)
    for k in range(scene.planned + 1):
        if k > 0:
            stage = advanced(scene, stage, inputs[k - 1])
        row = w.stages[k]
        row[0], row[1], row[2], row[3], row[4] = (
            stage.x, stage.y, stage.heading, stage.cos, stage.sin,
        )  # fmt: skip


@njit(**INNER)
def _stage(w: SolverWorkspace, k: int) -> Stage:
    row = w.stages[k]
    return Stage(k, row[0], row[1], row[2], row[3], row[4], 0.0, 0.0, 0, 0.0)


@njit(**INNER)
def _sensitivity(
    scene: Scene, poses: Floats, k: int, j: int, i: int, course: tuple[float, float]
) -> tuple[float, float, float]:
    """∂x_k/∂u_ji, j < k. poses: (L+1, 3).  course: (cos, sin) of the translation of step j."""
    step, cos, sin = scene.step, course[0], course[1]
    if i < scene.robot.n_linear:
        if i == 0:
            return step * cos, step * sin, 0.0
        return -step * sin, step * cos, 0.0
    lead = scene.heading_lead
    dx, dy = poses[j + 1, 0] - poses[j, 0], poses[j + 1, 1] - poses[j, 1]
    return (
        -step * (poses[k, 1] - poses[j + 1, 1]) - lead * dy,
        step * (poses[k, 0] - poses[j + 1, 0]) + lead * dx,
        step,
    )


@njit(**INNER)
def _course(scene: Scene, poses: Floats, inputs: Floats, j: int) -> tuple[float, float]:
    """(cos, sin) of the translation of step j."""
    angle = poses[j, 2] + scene.heading_lead * inputs[j, inputs.shape[1] - 1]
    return math.cos(angle), math.sin(angle)


@njit(**KERNEL)
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
            course = _course(scene, poses, inputs, j)
            for i in range(m):
                bx, by, ba = _sensitivity(scene, poses, k, j, i, course)
                at = j * m + i
                p.gradient[at] = q.input_gradient[j, i] + bx * lx + by * ly + ba * la
                # V = P b
                vx, vy = xx * bx + xy * by + xa * ba, xy * bx + yy * by + ya * ba
                va = xa * bx + ya * by + aa * ba
                for o in range(j + 1):
                    earlier = _course(scene, poses, inputs, o) if o < j else course
                    for r in range(m if o < j else i + 1):
                        sx, sy, sa = _sensitivity(scene, poses, k, o, r, earlier)
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


@njit(**KERNEL)
def _limit_rows(scene: Scene, w: SolverWorkspace, inputs: Floats) -> int:
    """Rows for rise and fall of every input and for the facets; bounds of the inputs.

    Where the robot already exceeds a bound (a limit lowered during the ride) the bound opens as far
    as braking needs, so that the problem stays feasible.
    """
    robot, rows, p = scene.robot, w.rows, w.program
    m, at = inputs.shape[1], 0
    for k in range(scene.planned):
        for i in range(m):
            r = k * m + i
            before = inputs[k - 1, i] if k > 0 else robot.current_input[i]
            rise, fall = robot.rise[i], robot.fall[i]
            if k == 0:
                rise, fall = robot.first_rise[i], robot.first_fall[i]
                if i == 0 and robot.jerk < np.inf:
                    more = (robot.acceleration + robot.jerk * robot.tick) * robot.tick
                    less = (robot.jerk * robot.tick - robot.acceleration) * robot.tick
                    rise, fall = max(min(rise, more), -fall), max(min(fall, less), -rise)
                    # a bound that is near comes first
                    rise = max(rise, robot.low[0] - before)
                    fall = max(fall, before - robot.high[0])
            change = inputs[k, i] - before
            rows.margin[at], rows.upper[at] = change + fall, rise - change
            rows.slack[at], rows.key[at] = -1, r
            rows.jacobian[at] = 0.0
            rows.jacobian[at, r] = 1.0
            if k > 0:
                rows.jacobian[at, r - m] = -1.0
            at += 1
            more = robot.first_rise[i] + k * robot.rise[i]
            less = robot.first_fall[i] + k * robot.fall[i]
            p.low[r] = min(robot.low[i], robot.current_input[i] + more) - inputs[k, i]
            p.high[r] = max(robot.high[i], robot.current_input[i] - less) - inputs[k, i]
    facets = robot.facets
    for k in range(scene.planned if facets.shape[0] else 0):
        for f in range(facets.shape[0]):
            now, braked, r = 0.0, 0.0, k * m
            rows.jacobian[at] = 0.0
            for i in range(m):
                less = robot.first_fall[i] + k * robot.fall[i]
                more = robot.first_rise[i] + k * robot.rise[i]
                u = robot.current_input[i]
                now += facets[f, i] * inputs[k, i]
                braked += facets[f, i] * (max(u - less, 0.0) + min(u + more, 0.0))
                rows.jacobian[at, r + i] = -facets[f, i]
            rows.margin[at], rows.upper[at] = max(braked, robot.top_speed) - now, _FAR
            rows.slack[at] = -1
            rows.key[at] = p.gradient.shape[0] + k * facets.shape[0] + f
            at += 1
    return at


@njit(**KERNEL)
def _person_rows(  # noqa: PLR0917  # a kernel takes plain values
    scene: Scene, o: Objective, w: SolverWorkspace, at: int, kind: int, q: int, first_key: int
) -> int:
    """Rows of one hypothesis under the barrier on bodies (kind 0) or social spaces (1)."""
    people, capsule, h = scene.people, scene.robot.capsule, w.h
    barrier = o.bodies if kind == 0 else o.social
    near = False
    h[0] = o.start[q, kind]
    for k in range(1, scene.planned + 1):
        state = people.states[q, k]
        dx, dy = state[0] - w.stages[k, 0], state[1] - w.stages[k, 1]
        reach = scene.robot.outer_radius + people.radius[q] + o.widest
        h[k] = REACH
        if dx * dx + dy * dy < reach * reach:
            e = state_encounter(people, capsule, q, _stage(w, k))
            value = social_value(people, e, state)
            if kind == 0:
                value = body_value(scene, e, state, q, k, barrier.norm)
            h[k] = min(value, REACH)
        near |= h[k] < REACH
    if not near:
        return at
    for k in range(scene.planned):
        margin = h[k + 1] - barrier.keep * h[k]
        if margin >= _NEAR or h[k + 1] >= REACH:
            continue
        if at >= w.rows.margin.shape[0]:
            return -1
        w.rows.margin[at], w.rows.upper[at] = margin, _FAR
        w.rows.slack[at] = kind * people.count + people.person[q]
        w.rows.key[at] = first_key + k
        w.rows.jacobian[at] = 0.0
        _add_gradient(scene, o, w, at, kind, q, k + 1, 1.0)
        if h[k] < REACH and barrier.keep > 0.0 and k > 0:
            _add_gradient(scene, o, w, at, kind, q, k, -barrier.keep)
        at += 1
    return at


@njit(**KERNEL)
def _add_gradient(  # noqa: PLR0917  # a kernel takes plain values
    scene: Scene,
    o: Objective,
    w: SolverWorkspace,
    at: int,
    kind: int,
    q: int,
    k: int,
    share: float,
) -> None:
    """Add ``share``·∂h_k/∂u to a row."""
    people, stage = scene.people, _stage(w, k)
    e, state = state_encounter(people, scene.robot.capsule, q, stage), people.states[q, k]
    gx, gy, ga = gap_gradient(e)
    if kind == 1:
        (lx, ly, la), (ox, oy, oa) = extent_gradients(people, state, e)
        gx, gy, ga = bounded((gx - lx - ox, gy - ly - oy, ga - la - oa))
    elif o.bodies.norm != 2:
        axis = scene.path.poses[k, 2]
        gx, gy, ga = norm_gradient(e, stage.cos, stage.sin, axis, o.bodies.norm)
    _add_row(scene, w, at, k, (share * gx, share * gy, share * ga))


@njit(**KERNEL)
def _add_row(
    scene: Scene, w: SolverWorkspace, at: int, k: int, g: tuple[float, float, float]
) -> None:
    """Add g·∂x_k/∂u to a row; an input has no effect on earlier poses."""
    poses, inputs = w.poses[0], w.inputs[0]
    m, row = inputs.shape[1], w.rows.jacobian[at]
    for j in range(min(k, scene.planned)):
        course = _course(scene, poses, inputs, j)
        for i in range(m):
            sx, sy, sa = _sensitivity(scene, poses, k, j, i, course)
            row[j * m + i] += g[0] * sx + g[1] * sy + g[2] * sa


@njit(**KERNEL)
def _wall_rows(scene: Scene, w: SolverWorkspace, at: int, first_key: int) -> int:
    """Rows of the footprint's discs near walls."""
    walls, robot, grid = scene.walls, scene.robot, scene.walls.grid
    for k in range(1, scene.planned + 1):
        stage = _stage(w, k)
        room = sample(grid.distance, grid.resolution, grid.X_MG, stage.x, stage.y)[0]
        if room - robot.outer_radius - walls.clearance >= _NEAR_WALL:
            continue
        for j in range(robot.discs.shape[0]):
            x = stage.x + stage.cos * robot.discs[j, 0] - stage.sin * robot.discs[j, 1]
            y = stage.y + stage.sin * robot.discs[j, 0] + stage.cos * robot.discs[j, 1]
            gap = sample(grid.distance, grid.resolution, grid.X_MG, x, y)[0]
            margin = gap - robot.discs[j, 2] - walls.clearance
            if margin >= _NEAR_WALL:
                continue
            if at >= w.rows.margin.shape[0]:
                return -1
            w.rows.margin[at], w.rows.upper[at] = margin, _FAR
            w.rows.slack[at] = 2 * scene.people.count
            w.rows.key[at] = first_key + j * scene.planned + k - 1
            w.rows.jacobian[at] = 0.0
            g = wall_clearance.gap_gradient(walls, robot, stage, j)
            _add_row(scene, w, at, k, g)
            at += 1
    return at


@njit(**KERNEL)
def minimise(daqp: DaqpAddresses, w: SolverWorkspace, count: int) -> int:
    """Solve the program of ``count`` rows: DAQP's flag; the step is the beginning of z."""
    rows, multipliers = w.rows, w.program.of_rows
    tight = 0
    for r in range(count):
        rows.used[r] = False
        if rows.slack[r] < 0:
            rows.used[r] = min(rows.margin[r], rows.upper[r]) < _HARD
        elif rows.margin[r] < _TIGHT:
            rows.left[tight] = rows.margin[r]
            tight += 1
    limit = _TIGHT
    if tight > _FIRST:
        limit = _nth(rows.left[:tight], _FIRST)
    for r in range(count):
        if (rows.slack[r] >= 0 and rows.margin[r] < limit) or multipliers[rows.key[r]] != 0.0:
            rows.used[r] = True
    for rounds_left in range(_ROUNDS, -1, -1):
        flag = _solve_used(daqp, w, count)
        if flag < 1 or not _add_violated(w, count):
            return flag
        if rounds_left == 1:
            rows.used[:count] = True
    return 1


@njit(**KERNEL)
def _nth(values: Floats, n: int) -> float:
    """The value with n smaller ones, by bisection: sorting is dear to compile."""
    low: float = values[0]
    high: float = values[0]
    for each in values:
        low, high = min(low, each), max(high, each)
    for _ in range(30):
        middle, smaller = 0.5 * (low + high), 0
        for each in values:
            smaller += each < middle
        if smaller > n:
            high = middle
        else:
            low = middle
    return low


@njit(**KERNEL)
def _solve_used(  # noqa: PLR0912  # one program from its parts
    daqp: DaqpAddresses, w: SolverWorkspace, count: int
) -> int:
    """Solve with the used rows only: DAQP's flag."""
    rows, p = w.rows, w.program
    x = p.gradient.shape[0]
    # a column for each slack of a used row
    p.column[:] = -1
    n = 0
    for r in range(count):
        if rows.used[r]:
            rows.chosen[n] = r
            n += 1
            if rows.slack[r] >= 0:
                p.column[rows.slack[r]] = 0
    num_slacks = 0
    for s in range(p.column.shape[0]):
        if p.column[s] == 0:
            p.slacks[num_slacks] = s
            num_slacks += 1
    size = x + num_slacks
    whole = p.whole[: size * size].reshape((size, size))
    whole[:] = 0.0
    for i in range(x):
        for j in range(x):
            whole[i, j] = p.hessian[i, j]
        p.slope[i], p.upper[i], p.lower[i] = p.gradient[i], p.high[i], p.low[i]
        p.dual[i] = p.of_inputs[i]
    for c in range(num_slacks):
        s, at = p.slacks[c], x + c
        p.column[s] = at
        whole[at, at] = p.l2[s]
        p.slope[at], p.upper[at], p.lower[at], p.dual[at] = p.l1[s], NO_BOUND, 0.0, p.of_slacks[s]
    stacked = p.rows[: n * size].reshape((n, size))
    for i in range(n):
        r, at = rows.chosen[i], size + i
        for j in range(x):
            stacked[i, j] = rows.jacobian[r, j]
        for j in range(x, size):
            stacked[i, j] = 0.0
        if rows.slack[r] >= 0:
            stacked[i, p.column[rows.slack[r]]] = 1.0
        p.upper[at], p.lower[at] = rows.upper[r], -rows.margin[r]
        p.dual[at] = p.of_rows[rows.key[r]]
    total = size + n
    flag = solve_dense(
        daqp, w.daqp, whole, p.slope[:size], stacked, p.upper[:total], p.lower[:total],
        p.dual[:total], p.z, p.multipliers,
    )  # fmt: skip
    if flag < 1 or not _finite(p.z[:size]):
        return min(flag, 0)
    p.slack[:] = 0.0
    p.of_slacks[:] = 0.0
    p.of_rows[:] = 0.0
    for i in range(x):
        p.of_inputs[i] = p.multipliers[i]
    for c in range(num_slacks):
        s = p.slacks[c]
        p.slack[s], p.of_slacks[s] = p.z[x + c], p.multipliers[x + c]
    for i in range(n):
        p.of_rows[rows.key[rows.chosen[i]]] = p.multipliers[size + i]
    return flag


@njit(**KERNEL)
def _finite(values: Floats) -> bool:
    total = 0.0
    for each in values:
        total += abs(each)
    return bool(np.isfinite(total))


@njit(**KERNEL)
def _add_violated(w: SolverWorkspace, count: int) -> bool:
    """Check the unused rows; if one is violated, use it, and all that are nearly violated."""
    rows, p = w.rows, w.program
    violated = False
    for r in range(count):
        if rows.used[r]:
            continue
        change = 0.0
        for j in range(p.gradient.shape[0]):
            change += rows.jacobian[r, j] * p.z[j]
        if rows.slack[r] >= 0:
            change += p.slack[rows.slack[r]]
        rows.left[r] = min(change + rows.margin[r], rows.upper[r] - change)
        violated |= rows.left[r] < -_TOLERANCE
    for r in range(count if violated else 0):
        if not rows.used[r] and rows.left[r] < _NEXT:
            rows.used[r] = True
    return violated


@njit(**KERNEL)
def smallest_barrier(scene: Scene, o: Objective, w: SolverWorkspace, inputs: Floats) -> float:
    """Smallest h over people, social spaces and walls along the planned states, m; 1 at most."""
    _keep_stages(scene, w, inputs)
    people, smallest = scene.people, REACH
    for k in range(scene.planned + 1):
        stage = _stage(w, k)
        for q in range(people.weight.shape[0]):
            state = people.states[q, k]
            e = state_encounter(people, scene.robot.capsule, q, stage)
            if o.bodies.active and o.bodies.binds[q]:
                smallest = min(smallest, e.gap - state[MARGIN])
            if o.social.active and o.social.binds[q]:
                smallest = min(smallest, social_value(people, e, state))
        gap = wall_clearance.nearest_wall(scene.walls, scene.robot, stage).gap
        smallest = min(smallest, gap - scene.walls.clearance)
    return smallest
