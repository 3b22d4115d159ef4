"""Rows of the SQP's programs: limits of the inputs, and barriers linearised along a trajectory."""

from __future__ import annotations

import math

from numba import njit

from cohelm.arrays import Floats
from cohelm.control.objective import advanced, body_value, first_stage, social_value
from cohelm.control.objective_tables import Objective
from cohelm.control.scene import Scene
from cohelm.control.solver_tables import SolverWorkspace
from cohelm.control.terms import wall_clearance
from cohelm.control.terms.barrier import REACH
from cohelm.control.terms.encounter import (
    bounded,
    extent_gradients,
    gap_gradient,
    state_encounter,
)
from cohelm.control.terms.norms import norm_gradient
from cohelm.control.terms.stage import Stage
from cohelm.kernels import INNER, KERNEL, callee
from cohelm.maps.distance import sample

_FAR = 1e6
"""A bound beyond all inputs of a robot."""
_NEAR, _NEAR_WALL = 0.6, 0.25
"""Rows with a larger margin cannot become active within one linearisation, m."""


@callee(KERNEL)
def keep_stages(scene: Scene, w: SolverWorkspace, inputs: Floats) -> None:
    """Record the planned states of the linearised trajectory."""
    stage = first_stage(scene)
    for k in range(scene.planned + 1):
        if k > 0:
            stage = advanced(scene, stage, inputs[k - 1])
        row, turn = w.stages[k], inputs[k, inputs.shape[1] - 1] if k < inputs.shape[0] else 0.0
        row[0], row[1], row[2], row[3], row[4] = (
            stage.x, stage.y, stage.heading, stage.cos, stage.sin,
        )  # fmt: skip
        angle = stage.heading + scene.heading_lead * turn
        row[5], row[6] = math.cos(angle), math.sin(angle)


@callee(INNER)
def _stage(w: SolverWorkspace, k: int) -> Stage:
    row = w.stages[k]
    return Stage(k, row[0], row[1], row[2], row[3], row[4], 0.0, 0.0, 0, 0.0)


@callee(INNER)
def step_sensitivity(
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


@callee(INNER)
def step_course(w: SolverWorkspace, j: int) -> tuple[float, float]:
    """(cos, sin) of the translation of step j."""
    return w.stages[j, 5], w.stages[j, 6]


@callee(KERNEL)
def limit_rows(scene: Scene, w: SolverWorkspace, inputs: Floats) -> int:
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
                if i == 0 and robot.jerk < math.inf:
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


@callee(KERNEL)
def person_rows(
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
        w.rows.slack[at] = kind * people.num_people + people.person[q]
        w.rows.key[at] = first_key + k
        w.rows.jacobian[at] = 0.0
        _add_gradient(scene, o, w, at, kind, q, k + 1, 1.0)
        if h[k] < REACH and barrier.keep > 0.0 and k > 0:
            _add_gradient(scene, o, w, at, kind, q, k, -barrier.keep)
        at += 1
    return at


@callee(KERNEL)
def _add_gradient(
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


@callee(KERNEL)
def _add_row(
    scene: Scene, w: SolverWorkspace, at: int, k: int, g: tuple[float, float, float]
) -> None:
    """Add g·∂x_k/∂u to a row; an input has no effect on earlier poses."""
    poses, inputs = w.poses[0], w.inputs[0]
    m, row = inputs.shape[1], w.rows.jacobian[at]
    for j in range(min(k, scene.planned)):
        course = step_course(w, j)
        for i in range(m):
            sx, sy, sa = step_sensitivity(scene, poses, k, j, i, course)
            row[j * m + i] += g[0] * sx + g[1] * sy + g[2] * sa


@callee(KERNEL)
def wall_rows(scene: Scene, w: SolverWorkspace, at: int, first_key: int) -> int:
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
            w.rows.slack[at] = 2 * scene.people.num_people
            w.rows.key[at] = first_key + j * scene.planned + k - 1
            w.rows.jacobian[at] = 0.0
            g = wall_clearance.gap_gradient(walls, robot, stage, j)
            _add_row(scene, w, at, k, g)
            at += 1
    return at


@njit(**KERNEL)
def smallest_barrier(scene: Scene, o: Objective, w: SolverWorkspace, inputs: Floats) -> float:
    """Smallest h over people, social spaces and walls along the planned states, m; 1 at most."""
    keep_stages(scene, w, inputs)
    people, smallest = scene.people, REACH
    for k in range(scene.planned + 1):
        stage = _stage(w, k)
        for q in range(people.weight.shape[0]):
            state = people.states[q, k]
            e = state_encounter(people, scene.robot.capsule, q, stage)
            if o.bodies.active and o.bodies.binds[q]:
                smallest = min(smallest, body_value(scene, e, state, q, k, o.bodies.norm))
            if o.social.active and o.social.binds[q]:
                smallest = min(smallest, social_value(people, e, state))
        if o.walls.active:
            gap = wall_clearance.nearest_wall(scene.walls, scene.robot, stage).gap
            smallest = min(smallest, gap - scene.walls.clearance)
    return smallest
