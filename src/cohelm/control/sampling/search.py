"""Search over arcs: a table, then perturbations of the cheapest ones and of the last plan.

An arc is rolled out through the scene, with its cost in seconds. Costs add up and none is negative,
so an arc is abandoned as soon as it costs more than the best one by more than a window; a
perturbation also if it costs more than its base. The result does not depend on the order of the
arcs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.control.objective import advanced, begin, final_cost, step_cost
from cohelm.control.objective_tables import PROGRESS, Objective, Workspace
from cohelm.control.path import SPACING
from cohelm.control.sampling.arc_table import END_1, END_2, NO_PERTURBATION, RETURN, SPEED_3
from cohelm.control.scene import RobotTable, Scene
from cohelm.control.terms.stage import Stage
from cohelm.kernels import INNER, KERNEL, callee

_LOOKAHEAD = round(1.0 / SPACING)
"""Lookahead of the return to the path: 1 m, in samples."""
_GAIN = 2.5
"""Turn rate per heading error in the return to the path, 1/s."""
_FULL = 2.0 * math.pi


@callee(INNER)
def request_input(
    scene: Scene,
    base: Floats,
    arc: Floats,
    k: int,
    state: tuple[float, float, float, float, float],
    i_path: int,
    requested: Floats,
) -> None:
    """Fill ``requested`` (m,) with the input that the arc requests at step k.

    state: (x, y, heading, arc length on the path, direction of the path at its start).
    i_path: nearest sample of the path.
    """
    path, robot = scene.path, scene.robot
    samples, max_speed = path.samples, path.max_speed
    holonomic = robot.n_linear > 1
    x, y, angle, s, first_tangent = state
    base_steps, elapsed = base.shape[0], k / scene.steps
    if elapsed >= arc[RETURN] or (base_steps > 0 and k >= base_steps):
        # back to the path, towards a point ahead on it
        i_ahead = min(i_path + _LOOKAHEAD, samples.shape[0] - 1)
        dx, dy = samples[i_ahead, 0] - x, samples[i_ahead, 1] - y
        speed = min(max(arc[SPEED_3], 0.0), 1.0) if base_steps == 0 else 1.0
        speed = min(speed * max_speed, max(path.reference[scene.steps] - s, 0.0) / scene.step)
        if holonomic:
            direction = math.atan2(dy, dx) - angle
            requested[0], requested[1] = speed * math.cos(direction), speed * math.sin(direction)
        else:
            error = math.atan2(dy, dx) - angle
            error -= _FULL * round(error / _FULL)
            requested[0] = speed * max(math.cos(error), 0.0)
            requested[1] = _GAIN * error
        turns = holonomic
    else:
        # one of three segments, absolute or added to the base
        segment = 0 if elapsed < arc[END_1] else (2 if elapsed < arc[END_2] else 4)
        speed, turn = arc[segment], arc[segment + 1]
        turns = holonomic and base_steps == 0
        if base_steps > 0:
            # the turn share goes to input 1: ω of a unicycle, v_y of a holonomic robot
            for i in range(requested.shape[0]):
                requested[i] = base[k, i]
            requested[0] += speed * max_speed
            requested[1] += turn * robot.high[1]
        elif holonomic:
            requested[0] = speed * max_speed * math.cos(first_tangent + turn * math.pi - angle)
            requested[1] = speed * max_speed * math.sin(first_tangent + turn * math.pi - angle)
        else:
            requested[0] = speed * (max_speed if speed > 0.0 else -robot.low[0])
            requested[1] = turn * robot.high[1]
    if turns:  # a holonomic robot turns to the path's heading meanwhile
        error = math.atan2(path.heading[i_path, 1], path.heading[i_path, 0]) - angle
        requested[2] = 0.5 * _GAIN * (error - _FULL * round(error / _FULL))


@callee(INNER)
def limit_input(robot: RobotTable, max_speed: float, step: float, k: int, inputs: Floats) -> None:
    """Reduce the input at step k to the limits of speed, acceleration and jerk.

    The first change must fit into the time until the next decision. Apart from the jerk it is a
    copy of ``robots.kinematics.within_limits`` for one step.
    """
    u, m = inputs[k], inputs.shape[1]
    joint = robot.n_linear if robot.n_linear > 1 else 0  # inputs that change in proportion
    # each input within its bounds, then the speed
    square = 0.0
    for i in range(m):
        upper = min(robot.high[i], max_speed) if i == 0 else robot.high[i]
        u[i] = min(max(u[i], robot.low[i]), upper)
        square += u[i] * u[i] if i < joint else 0.0
    top_speed = min(robot.top_speed, max_speed)
    shrink = min(1.0, top_speed / math.sqrt(square)) if square > 0.0 else 1.0
    # the share of a joint change that keeps every component within its acceleration
    share = 1.0
    for i in range(joint):
        u[i] *= shrink
        change = u[i] - (inputs[k - 1, i] if k > 0 else robot.current_input[i])
        lower, upper = _change_limits(robot, step, k, i, inputs)
        most = upper if change > 0.0 else -lower
        if abs(change) > most:
            share = min(share, most / abs(change))
    for i in range(m):
        before = inputs[k - 1, i] if k > 0 else robot.current_input[i]
        change = u[i] - before
        if i < joint:
            change *= share
        else:
            lower, upper = _change_limits(robot, step, k, i, inputs)
            change = min(max(change, lower), upper)
        u[i] = before + change
        if i >= joint:  # the jerk is exceeded rather than a limit of speed
            highest = min(robot.high[i], max_speed) if i == 0 else robot.high[i]
            u[i] = min(max(u[i], min(robot.low[i], before)), max(highest, before))


@callee(INNER)
def _change_limits(
    robot: RobotTable, step: float, k: int, i: int, inputs: Floats
) -> tuple[float, float]:
    """(lowest, highest) change of input i at step k.

    With a limit of jerk the acceleration changes by at most j·Δt, and braking fades in time before
    the robot stands: a² ≤ 2 j |v|. It does not fade before the highest speed.
    """
    fall, rise = -robot.fall[i], robot.rise[i]
    if k == 0:
        fall, rise = -robot.first_fall[i], robot.first_rise[i]
    if i > 0 or robot.jerk == math.inf:
        return fall, rise
    duration = robot.tick if k == 0 else step
    before, earlier = robot.current_input[0], robot.acceleration
    if k > 0:
        before = inputs[k - 1, 0]
        since = robot.current_input[0] if k == 1 else inputs[k - 2, 0]
        earlier = (before - since) / (robot.tick if k == 1 else step)
    change = robot.jerk * duration
    stopping = math.sqrt(2.0 * robot.jerk * abs(before)) + change
    lower, upper = earlier - change, earlier + change
    if before > 0.0:
        lower = max(lower, -stopping)
    else:
        upper = min(upper, stopping)
    return max(fall, min(lower * duration, rise)), min(rise, max(upper * duration, fall))


_BLOCKED = 1e4
"""Cost of a wall that cannot be avoided any more: above all others."""


class RolloutResult(NamedTuple):
    """Result of an arc."""

    cost: float
    """s; +inf: abandoned."""
    stopped: int
    """Step at which a wall is touched; L if none is."""


@callee(KERNEL)
def roll_out(
    scene: Scene,
    o: Objective,
    base: Floats,
    arc: Floats,
    limit: float,
    inputs: Floats,
    poses: Floats,
    work: Workspace,
) -> RolloutResult:
    """Roll out one arc; abandoned with cost +inf if it costs more than ``limit``.

    Args:
        scene: surroundings of the robot.
        o: the objective.
        base: (K, m) inputs; after them the arc leads back to the path. K = 0: only ``arc`` counts.
        arc: (9,) row of the arc table; added to ``base`` if there is one.
        limit: cost above which the arc is abandoned, s.
        inputs: (L, m), filled as far as the arc was rolled out.
        poses: (L+1, 3), filled as well.
        work: workspace; afterwards it holds the cost of each term.
    """
    steps, path, robot = scene.steps, scene.path, scene.robot
    stage, cost = begin(scene, o, work), 0.0
    goal = path.reference[steps]
    poses[0, 0], poses[0, 1], poses[0, 2] = stage.x, stage.y, stage.heading
    tangent = math.atan2(path.samples[0, 3], path.samples[0, 2])
    for k in range(steps):
        heading = stage.heading
        state = (stage.x, stage.y, heading, stage.s, tangent)
        request_input(scene, base, arc, k, state, stage.i_path, inputs[k])
        limit_input(robot, path.max_speed, scene.step, k, inputs)
        stage = advanced(scene, stage, inputs[k])
        poses[k + 1, 0], poses[k + 1, 1], poses[k + 1, 2] = stage.x, stage.y, stage.heading
        before = inputs[k - 1] if k > 0 else robot.current_input
        more, touches = step_cost(scene, o, stage, inputs[k], before, heading, work)
        cost += more
        if touches:
            cost += _cost_of_stop(scene, o, stage, poses, work)
            return RolloutResult(cost, k)
        # lower bound of the whole cost: the robot is never faster than the reference's maximum
        lost = max(goal - stage.s - (steps - k - 1) * scene.step * path.max_speed, 0.0)
        if cost + (o.progress.final + o.progress.mean * (steps - k - 1)) * lost > limit:
            return RolloutResult(np.inf, steps)
    cost += final_cost(scene, o, stage, work)
    return RolloutResult(cost if cost <= limit else np.inf, steps)


@callee(INNER)
def _cost_of_stop(
    scene: Scene, o: Objective, stage: Stage, poses: Floats, work: Workspace
) -> float:
    """Further cost of an arc that touches a wall at a stage; its further poses stay there.

    The robot would stop before the wall: the time from there on is lost.
    """
    path, steps, k, cost = scene.path, scene.steps, stage.k, 0.0
    braking_steps = stage.speed / scene.robot.fall[0]
    if k <= braking_steps + 2.0:
        cost += _BLOCKED * (2.0 - k / steps)
    s_stop = stage.s - 0.5 * stage.speed * scene.step * braking_steps
    for j in range(k + 1, steps + 1):
        cost += o.progress.mean * max(path.reference[j] - s_stop, 0.0)
        poses[j, 0], poses[j, 1], poses[j, 2] = stage.x, stage.y, stage.heading
    lag = math.hypot(max(path.reference[steps] - s_stop, 0.0), stage.d)
    cost += o.progress.final * lag + 0.5 * o.heading.weight
    work.by_term[PROGRESS] += cost
    return cost


_APART = 0.2
"""Arcs are different if their ends are this far apart, or half as far after a third, m."""


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


class _Search(NamedTuple):
    """All arcs of a search: a base, and a row of the table or of the perturbations."""

    table: Floats
    """(a, 9) arcs to begin with."""
    perturbations: Floats
    """(b, 9), the first of which has no effect."""
    costs: Floats
    """(r,) s."""
    marks: Floats
    """(r, 4) positions (x, y) after a third of the horizon and at its end, m."""
    base_of: Integers
    """(r,) index of the base; −1: none, a row of the table."""
    row_of: Integers
    """(r,) index of the row; −1: no perturbation."""
    bases: Floats
    """(c, L, m) inputs that are perturbed."""
    base_steps: Integers
    """(c,) number of steps that each base has."""
    base_costs: Floats
    """(c,) cost of each base, s."""
    chosen: Integers
    """(j,) the cheapest arcs that are apart."""
    taken: Booleans
    """(r,) arcs that were looked at when these were chosen."""
    inputs: Floats
    """(L, m) of one arc."""
    poses: Floats
    """(L+1, 3) of one arc."""
    no_base: Floats
    """(0, m) base without steps."""
    no_perturbation: Floats
    """(9,)."""


def search_arcs(
    scene: Scene,
    o: Objective,
    warm: Floats,
    table: Floats,
    perturbations: Floats,
    budget: SearchBudget,
    *,
    work: Workspace,
) -> Floats:
    """Inputs (j, L, m) of the cheapest arcs, cheapest first, all some distance apart.

    Args:
        scene: surroundings of the robot.
        o: the objective.
        warm: (K, m) inputs of the last plan; K = 0: there is none.
        table: (a, 9) arcs to begin with.
        perturbations: (b, 9), the first of which has no effect.
        budget: size of the search.
        work: workspace of the objective.
    """
    steps, m = scene.steps, len(scene.robot.current_input)
    num_bases = 1 + budget.rounds * (budget.elite + 1)
    num_arcs = 1 + len(table) + (num_bases - 1) * len(perturbations)
    search = _Search(
        table=table,
        perturbations=perturbations,
        costs=np.full(num_arcs, np.inf),
        marks=np.empty((num_arcs, 4)),
        base_of=np.empty(num_arcs, np.int64),
        row_of=np.empty(num_arcs, np.int64),
        bases=np.empty((num_bases, steps, m)),
        base_steps=np.zeros(num_bases, np.int64),
        base_costs=np.full(num_bases, np.inf),
        chosen=np.empty(max(budget.max_results, budget.elite), np.int64),
        taken=np.empty(num_arcs, np.bool_),
        inputs=np.empty((steps, m)),
        poses=np.empty((steps + 1, 3)),
        no_base=np.empty((0, m)),
        no_perturbation=NO_PERTURBATION.copy(),
    )
    out = np.empty((budget.max_results, steps, m))
    return out[: _search(scene, o, search, warm[:steps], budget, work, out)]


@njit(**KERNEL)
def _search(
    scene: Scene,
    o: Objective,
    s: _Search,
    warm: Floats,
    budget: SearchBudget,
    work: Workspace,
    out: Floats,
) -> int:
    """Kernel of :func:`search_arcs`: the number of arcs in ``out``."""
    num_warm, best = min(warm.shape[0], 1), np.inf
    # the last plan, then the table
    if num_warm:
        s.base_steps[0] = warm.shape[0]
        _copy(warm, s.bases[0])
    n = num_warm + s.table.shape[0]
    for a in range(n):
        s.base_of[a], s.row_of[a] = (0, -1) if a < num_warm else (-1, a - num_warm)
        best = min(best, _try(scene, o, s, a, best + budget.window, work))
    s.base_costs[0] = s.costs[0] if num_warm else np.inf
    # rounds: the best arcs become bases, and every base is perturbed
    filled = 1
    for i_round in range(budget.rounds):
        first = filled if i_round > 0 or not num_warm else 0
        for j in range(_cheapest_apart(s, n, budget.elite, best + budget.window)):
            c = s.chosen[j]
            if c < num_warm:
                continue  # the last plan is a base already
            _roll_again(scene, o, s, c, work)
            _copy(s.inputs, s.bases[filled])
            s.base_steps[filled], s.base_costs[filled] = s.inputs.shape[0], s.costs[c]
            filled += 1
        for b in range(first, filled):
            for p in range(1, s.perturbations.shape[0]):
                s.base_of[n], s.row_of[n] = b, p
                # only improvements of the base
                limit = min(best + budget.window, s.base_costs[b])
                best = min(best, _try(scene, o, s, n, limit, work))
                n += 1
    # the best of all, rolled out again
    count = _cheapest_apart(s, n, budget.max_results, best + budget.window)
    for j in range(count):
        _roll_again(scene, o, s, s.chosen[j], work)
        _copy(s.inputs, out[j])
    return count


@njit(**KERNEL)
def evaluate_inputs(
    scene: Scene,
    o: Objective,
    given: Floats,
    no_perturbation: Floats,
    limited: Floats,
    poses: Floats,
    by_term: Floats,
    costs: Floats,
    slack: Floats,
    work: Workspace,
) -> None:
    """Evaluate inputs (j, K, m), and fill the resulting trajectories and their costs.

    Args:
        scene: surroundings of the robot.
        o: the objective.
        given: (j, K, m); after K steps the trajectory leads back to the path.
        no_perturbation: (9,), see ``arc_table``.
        limited: (j, L, m), filled with the inputs within the limits.
        poses: (j, L+1, 3), filled.
        by_term: (j, T), filled with the summands of the cost.
        costs: (j,), filled, s.
        slack: (j,), filled with the largest violation of a barrier, m.
        work: workspace.
    """
    for j in range(given.shape[0]):
        result = roll_out(scene, o, given[j], no_perturbation, np.inf, limited[j], poses[j], work)
        for k in range(result.stopped + 1, scene.steps):  # the rest after contact with a wall
            _brake_step(scene, limited[j], poses[j], k)
        costs[j] = result.cost
        for t in range(by_term.shape[1]):
            by_term[j, t] = work.by_term[t]
        slack[j] = work.wall_violation[0]
        for kind in range(work.violation.shape[0]):
            for i in range(work.violation.shape[1]):
                slack[j] = max(slack[j], work.violation[kind, i])


@callee(KERNEL)
def _try(scene: Scene, o: Objective, s: _Search, n: int, limit: float, work: Workspace) -> float:
    """Roll out arc ``n`` and record it: its cost."""
    cost = _roll(scene, o, s, n, limit, work)[0]
    third, mark = s.poses.shape[0] // 3, s.marks[n]
    s.costs[n] = cost
    mark[0], mark[1] = s.poses[third, 0], s.poses[third, 1]
    mark[2], mark[3] = s.poses[-1, 0], s.poses[-1, 1]
    return cost


@callee(KERNEL)
def _roll(
    scene: Scene, o: Objective, s: _Search, n: int, limit: float, work: Workspace
) -> tuple[float, int]:
    """(cost of arc ``n``, step at which it touches a wall); fills inputs and poses."""
    b, r = s.base_of[n], s.row_of[n]
    base = s.no_base if b < 0 else s.bases[b, : s.base_steps[b]]
    row = s.no_perturbation if r < 0 else (s.table[r] if b < 0 else s.perturbations[r])
    result = roll_out(scene, o, base, row, limit, s.inputs, s.poses, work)
    return result.cost, result.stopped


@callee(KERNEL)
def _roll_again(scene: Scene, o: Objective, s: _Search, n: int, work: Workspace) -> None:
    """Roll out arc ``n`` again; it brakes in time before a wall."""
    _, stopped = _roll(scene, o, s, n, np.inf, work)
    if stopped < scene.steps:
        square = 0.0
        for i in range(max(scene.robot.n_linear, 1)):
            square += s.inputs[stopped, i] * s.inputs[stopped, i]
        braking_steps = math.ceil(math.sqrt(square) / scene.robot.fall[0])
        for k in range(max(stopped - braking_steps - 1, 0), s.inputs.shape[0]):
            for i in range(s.inputs.shape[1]):
                s.inputs[k, i] = 0.0


@callee(KERNEL)
def _cheapest_apart(s: _Search, arcs: int, count: int, limit: float) -> int:
    """Choose at most ``count`` arcs, cheapest first, each some distance from those before it."""
    n = 0
    for a in range(arcs):
        s.taken[a] = not (s.costs[a] <= limit and s.costs[a] < np.inf)
    while n < count:
        c = -1
        for a in range(arcs):
            if not s.taken[a] and (c < 0 or s.costs[a] < s.costs[c]):
                c = a
        if c < 0:
            break
        s.taken[c] = True
        near = False
        for j in range(n):
            other = s.chosen[j]
            third = math.hypot(s.marks[c, 0] - s.marks[other, 0], s.marks[c, 1] - s.marks[other, 1])
            end = math.hypot(s.marks[c, 2] - s.marks[other, 2], s.marks[c, 3] - s.marks[other, 3])
            near |= third < 0.5 * _APART and end < _APART
        if not near:
            s.chosen[n] = c
            n += 1
    return n


@callee(KERNEL)
def _copy(source: Floats, target: Floats) -> None:
    for k in range(source.shape[0]):
        for i in range(source.shape[1]):
            target[k, i] = source[k, i]


@callee(KERNEL)
def _brake_step(scene: Scene, inputs: Floats, poses: Floats, k: int) -> None:
    """Step ``k`` of braking as plans do, by the table's deceleration."""
    robot, step, m = scene.robot, scene.step, inputs.shape[1]
    n_linear, square = robot.n_linear, 0.0
    for i in range(n_linear):
        square += inputs[k - 1, i] * inputs[k - 1, i]
    speed = math.sqrt(square)
    share = max(1.0 - robot.fall[0] / speed, 0.0) if speed > 0.0 else 0.0
    for i in range(m):
        if i < n_linear:
            inputs[k, i] = share * inputs[k - 1, i]
        else:
            remaining = max(abs(inputs[k - 1, i]) - robot.fall[i], 0.0)
            inputs[k, i] = math.copysign(remaining, inputs[k - 1, i])
    heading = poses[k, 2] + scene.heading_lead * inputs[k, m - 1]
    cos, sin = math.cos(heading), math.sin(heading)
    vy = inputs[k, 1] if n_linear > 1 else 0.0
    poses[k + 1, 0] = poses[k, 0] + step * (cos * inputs[k, 0] - sin * vy)
    poses[k + 1, 1] = poses[k, 1] + step * (sin * inputs[k, 0] + cos * vy)
    poses[k + 1, 2] = poses[k, 2] + step * inputs[k, m - 1]
