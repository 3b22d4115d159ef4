"""One arc rolled out through the scene, with its cost in seconds.

Costs add up and none is negative, so an arc is abandoned as soon as it costs more than the best one
by more than a window; a perturbation also if it costs more than its base. The result does not
depend on the order of the arcs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.objective import advanced, begin, final_cost, step_cost
from cohelm.control.objective_tables import PROGRESS, Objective, Workspace
from cohelm.control.sampling.arc_inputs import limit_input, request_input
from cohelm.control.scene import Scene
from cohelm.control.terms.stage import Stage
from cohelm.kernels import INNER, KERNEL

_BLOCKED = 1e4
"""Cost of a wall that cannot be avoided any more: above all others."""


class RolloutResult(NamedTuple):
    """Result of an arc."""

    cost: float
    """s; +inf: abandoned."""
    stopped: int
    """Step at which a wall is touched; L if none is."""


@njit(**KERNEL)
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


@njit(**INNER)
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
