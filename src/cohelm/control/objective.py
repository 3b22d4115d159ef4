"""The one objective: a sum of terms under a stack of barriers, in seconds.

Search, SQP, choice and report all evaluate it by the functions below. ``TERMS`` names its summands;
each is a module of ``terms``. A term outside the package needs no change here, see
``terms.extra``.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.array_kernels import ZERO
from cohelm.arrays import Floats
from cohelm.control.objective_tables import (
    BODIES,
    CHANGE,
    EFFORT,
    FIRST_EXTRA,
    GROUP,
    HEADING,
    PATH,
    PERSON,
    PROGRESS,
    SPACE,
    TRACK,
    WALL,
    WALLS,
    Objective,
    Workspace,
)
from cohelm.control.path import project_on_path
from cohelm.control.people_table import MARGIN, PeopleTable
from cohelm.control.scene import Scene
from cohelm.control.terms import (
    barrier,
    extra,
    final_heading,
    group_space,
    input_change,
    input_effort,
    path_distance,
    person_clearance,
    personal_space,
    progress,
    track_reference,
    wall_clearance,
)
from cohelm.control.terms.encounter import own_extent, person_extent, state_encounter
from cohelm.control.terms.norms import norm_gap
from cohelm.control.terms.stage import Encounter, LocalModel, Stage
from cohelm.kernels import CACHED, INNER, KERNEL, callee
from cohelm.maps.distance import sample

_BODY, _SOCIAL = 0, 1
"""Columns of ``Objective.start`` and of ``Workspace.before``."""


@callee(INNER)
def first_stage(scene: Scene) -> Stage:
    """The robot now."""
    x, y, heading = scene.robot.start[0], scene.robot.start[1], scene.robot.start[2]
    i, s, d = project_on_path(scene.path.samples, x, y, ZERO)
    return Stage(0, x, y, heading, math.cos(heading), math.sin(heading), s, d, i, 0.0)


@njit(**CACHED)
def start_values(scene: Scene, norm: int) -> Floats:
    """``Objective.start``."""
    stage, people = first_stage(scene), scene.people
    out = np.empty((people.weight.shape[0], 2))
    for q in range(out.shape[0]):
        e = state_encounter(people, scene.robot.capsule, q, stage)
        state = people.states[q, 0]
        out[q, _BODY] = min(body_value(scene, e, state, q, ZERO, norm), barrier.REACH)
        out[q, _SOCIAL] = min(social_value(people, e, state), barrier.REACH)
    return out


@callee(INNER)
def body_value(scene: Scene, e: Encounter, state: Floats, q: int, k: int, norm: int) -> float:
    """Value h of a body, m."""
    margin: float = state[MARGIN]
    if norm == 2:
        return e.gap - margin
    size = scene.robot.capsule[4] + scene.people.radius[q] + margin
    return norm_gap(e, scene.path.poses[k, 2], size, norm)


@callee(INNER)
def social_value(people: PeopleTable, e: Encounter, state: Floats) -> float:
    """Value h of a social space, m; Xu et al., eq. (8)."""
    return e.gap - person_extent(people, state, e) - own_extent(people, e)


@callee(INNER)
def begin(scene: Scene, o: Objective, work: Workspace) -> Stage:
    """Reset the workspace, and return the stage of the robot now."""
    work.by_term[:] = 0.0
    work.due[:] = 0.0
    work.violation[:] = 0.0
    work.wall_violation[:] = 0.0
    work.free[:] = 0.0
    for q in range(o.start.shape[0]):
        work.before[q, 0], work.before[q, 1] = o.start[q, 0], o.start[q, 1]
    return first_stage(scene)


@callee(INNER)
def advanced(scene: Scene, stage: Stage, u: Floats) -> Stage:
    """The stage after a step with input u (m,)."""
    m, step = u.shape[0], scene.step
    turn = u[m - 1]
    cos, sin = stage.cos, stage.sin
    if scene.heading_lead != 0.0:
        course = stage.heading + scene.heading_lead * turn
        cos, sin = math.cos(course), math.sin(course)
    x, y = stage.x + step * u[0] * cos, stage.y + step * u[0] * sin
    speed = abs(u[0])
    if scene.robot.n_linear > 1:
        x -= step * sin * u[1]
        y += step * cos * u[1]
        speed = math.hypot(u[0], u[1])
    heading = stage.heading + step * turn
    i, s, d = project_on_path(scene.path.samples, x, y, stage.i_path)
    return Stage(stage.k + 1, x, y, heading, math.cos(heading), math.sin(heading), s, d, i, speed)


@callee(INNER)
def step_cost(
    scene: Scene,
    o: Objective,
    stage: Stage,
    u: Floats,
    before: Floats,
    heading: float,
    work: Workspace,
) -> tuple[float, bool]:
    """(cost of a stage, s; whether the robot touches a wall there), added to the workspace.

    Args:
        scene: surroundings.
        o: the objective.
        stage: state x_k.
        u: (m,) input that led there.
        before: (m,) input before it.
        heading: of the state before, rad.
        work: workspace.
    """
    by_term, path = work.by_term, scene.path
    c_progress = progress.cost(o.progress, path, stage)
    c_path = path_distance.cost(o.path, stage)
    c_effort = input_effort.cost(o.effort, path, stage.k - 1, heading, u)
    c_change = input_change.cost(o.change, u, before)
    c_track = track_reference.cost(o.track, path, stage)
    by_term[PROGRESS] += c_progress
    by_term[PATH] += c_path
    by_term[EFFORT] += c_effort
    by_term[CHANGE] += c_change
    by_term[TRACK] += c_track
    total = c_progress + c_path + c_effort + c_change + c_track
    if o.extra.address.shape[0]:
        tangent = math.atan2(path.samples[stage.i_path, 3], path.samples[stage.i_path, 2])
        total += extra.cost(o.extra, stage, u[u.shape[0] - 1], tangent, by_term[FIRST_EXTRA:])
    # walls, only after a distance in which none can be near
    touches = False
    work.free[1] -= stage.speed * scene.step
    if work.free[1] <= 0.0:
        cost, touches = _wall_cost(scene, o, stage, work)
        total += cost
    # people and groups
    total += _people_cost(scene, o, stage, work)
    if scene.groups.support.shape[0]:
        share = person_clearance.speed_share(o.person, stage.speed)
        depth = group_space.cost(o.group, scene.groups, stage)
        c_group = share * scene.people.fade[stage.k] * depth
        by_term[GROUP] += c_group
        total += c_group
    return total, touches


@callee(INNER)
def final_cost(scene: Scene, o: Objective, stage: Stage, work: Workspace) -> float:
    """Cost of the last state, s."""
    late = progress.final_cost(o.progress, scene.path, stage)
    turned = final_heading.final_cost(o.heading, scene.path, stage)
    work.by_term[PROGRESS] += late
    work.by_term[HEADING] += turned
    return late + turned


@callee(INNER)
def _wall_cost(scene: Scene, o: Objective, stage: Stage, work: Workspace) -> tuple[float, bool]:
    """(cost of the walls at a stage, whether one is touched)."""
    walls, robot, grid = scene.walls, scene.robot, scene.walls.grid
    wanted = max(o.wall.distance, walls.clearance)
    # the robot's circle first: where it is clear, all discs are
    room = sample(grid.distance, grid.resolution, grid.X_MG, stage.x, stage.y)[0]
    room -= robot.outer_radius + wanted
    if room > 0.0:
        work.free[1] = room
        return 0.0, False
    work.free[1] = 0.0
    nearest = wall_clearance.nearest_wall(walls, robot, stage)
    cost = wall_clearance.cost(o.wall, nearest.gap)
    work.by_term[WALL] += cost
    violation = walls.clearance - nearest.gap
    worst = work.wall_violation[0]
    if o.walls.active and violation > worst and stage.k <= scene.planned:
        more = barrier.price(o.walls, violation) - barrier.price(o.walls, worst)
        work.wall_violation[0] = violation
        work.by_term[WALLS] += more
        cost += more
    return cost, nearest.touches


@callee(INNER)
def _people_cost(scene: Scene, o: Objective, stage: Stage, work: Workspace) -> float:
    """Cost of all people at a stage."""
    people, robot, k = scene.people, scene.robot, stage.k
    states = people.states
    if k < work.free[0]:
        return 0.0
    soonest, total = np.inf, 0.0
    share = person_clearance.speed_share(o.person, stage.speed) * people.fade[k]
    for q in range(states.shape[0]):
        if k < work.due[q]:
            soonest = min(soonest, work.due[q])
            continue
        # far people are skipped for as long as both speeds allow
        dx, dy = states[q, k, 0] - stage.x, states[q, k, 1] - stage.y
        excess = math.sqrt(dx * dx + dy * dy) - robot.outer_radius - people.radius[q] - o.widest
        if excess > 0.0:
            closing_speed = people.fastest[q] + robot.top_speed + 0.01
            work.due[q] = k + 1 + int(excess / (scene.step * closing_speed))
            soonest = min(soonest, work.due[q])
            work.before[q, 0] = work.before[q, 1] = barrier.REACH
            continue
        soonest = 0.0
        state = states[q, k]
        e = state_encounter(people, robot.capsule, q, stage)
        weight = share * people.weight[q]
        near = weight * person_clearance.cost(o.person, state[MARGIN], e)
        inside = weight * personal_space.cost(o.space, people, state, e)
        work.by_term[PERSON] += near
        work.by_term[SPACE] += inside
        total += near + inside
        if k <= scene.planned:
            if o.bodies.active and o.bodies.binds[q]:
                h = body_value(scene, e, state, q, k, o.bodies.norm)
                total += _priced(o.bodies, _BODY, h, q, people.person[q], work)
            if o.social.active and o.social.binds[q]:
                h = social_value(people, e, state)
                total += _priced(o.social, _SOCIAL, h, q, people.person[q], work)
    work.free[0] = soonest
    return total


@callee(INNER)
def _priced(
    t: barrier.BarrierTable, kind: int, h: float, q: int, person: int, work: Workspace
) -> float:
    """Additional price of h at a state: the largest violation of a person counts."""
    h = min(h, barrier.REACH)
    violation = t.keep * work.before[q, kind] - h
    work.before[q, kind] = h
    worst = work.violation[kind, person]
    if violation <= worst:
        return 0.0
    work.violation[kind, person] = violation
    more = barrier.price(t, violation) - barrier.price(t, worst)
    work.by_term[BODIES + kind] += more
    return more


@njit(**KERNEL)
def trajectory_cost(
    scene: Scene, o: Objective, inputs: Floats, poses: Floats, work: Workspace
) -> float:
    """Cost of inputs (L, m), which are within the limits, s; fills poses (L+1, 3)."""
    stage = begin(scene, o, work)
    poses[0, 0], poses[0, 1], poses[0, 2] = stage.x, stage.y, stage.heading
    total = 0.0
    for k in range(inputs.shape[0]):
        heading = stage.heading
        stage = advanced(scene, stage, inputs[k])
        before = inputs[k - 1] if k > 0 else scene.robot.current_input
        poses[k + 1, 0], poses[k + 1, 1], poses[k + 1, 2] = stage.x, stage.y, stage.heading
        cost, _ = step_cost(scene, o, stage, inputs[k], before, heading, work)
        total += cost
    return total + final_cost(scene, o, stage, work)


@callee(KERNEL)
def add_models(scene: Scene, o: Objective, inputs: Floats, q: LocalModel) -> None:
    """Fill the local model of all terms along inputs (L, m); barriers add rows, see ``sqp``."""
    q.pose_gradient[:] = 0.0
    q.pose_curvature[:] = 0.0
    q.input_gradient[:] = 0.0
    q.input_curvature[:] = 0.0
    q.input_coupling[:] = 0.0
    stage, path, people = first_stage(scene), scene.path, scene.people
    for k in range(inputs.shape[0]):
        before = inputs[k - 1] if k > 0 else scene.robot.current_input
        input_effort.model(o.effort, path, k, stage.heading, inputs[k], q)
        input_change.model(o.change, k, inputs[k], before, q)
        stage = advanced(scene, stage, inputs[k])
        progress.model(o.progress, path, stage, q)
        path_distance.model(o.path, path, stage, q)
        track_reference.model(o.track, path, stage, q)
        wall_clearance.model(o.wall, scene.walls, scene.robot, stage, q)
        if o.extra.address.shape[0]:
            tangent = path.samples[stage.i_path]
            angle = math.atan2(tangent[3], tangent[2])
            extra.model(o.extra, stage, inputs[k], scene.robot.n_linear, angle, q)
        share = person_clearance.speed_share(o.person, stage.speed) * people.fade[k + 1]
        met = group_space.cost(o.group, scene.groups, stage)
        group_space.model(o.group, scene.groups, stage, share, q)
        for i in range(people.states.shape[0]):
            state = people.states[i, k + 1]
            dx, dy = state[0] - stage.x, state[1] - stage.y
            reach = scene.robot.outer_radius + people.radius[i] + o.widest
            if dx * dx + dy * dy < reach * reach:
                e = state_encounter(people, scene.robot.capsule, i, stage)
                weight = share * people.weight[i]
                met += people.weight[i] * person_clearance.cost(o.person, state[MARGIN], e)
                met += people.weight[i] * personal_space.cost(o.space, people, state, e)
                person_clearance.model(o.person, state[MARGIN], e, k + 1, weight, q)
                personal_space.model(o.space, people, state, e, k + 1, weight, q)
        # the costs of people grow with the speed
        if met > 0.0 and 0.0 < stage.speed < person_clearance.STANDS:
            slope = met * people.fade[k + 1] * (1.0 - o.person.standing_share)
            slope /= person_clearance.STANDS * stage.speed
            for a in range(scene.robot.n_linear):
                q.input_gradient[k, a] += slope * inputs[k, a]
    progress.final_model(o.progress, path, stage, q)
    final_heading.final_model(o.heading, path, stage, q)
