"""Kernel: one arc rolled out through the scene, with its cost in seconds.

Costs add up and none is negative, so an arc is abandoned as soon as it costs more than the best one
by more than a window. The result does not depend on the order of the arcs. Blocks are inlined,
because calls that pass the whole state are expensive.

Names: s and d are the arc length along the path and the signed distance from it (Frenet
coordinates), ``i_path`` is the nearest sample of the path.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.sampling.arc_inputs import limit_input, request_input
from cohelm.control.sampling.interactions import (
    capsule_gap,
    depth_in_hulls,
    missing_clearance,
    space_intrusion,
)
from cohelm.control.sampling.path_samples import heading_cost, project_on_path
from cohelm.control.sampling.scene import RolloutScene
from cohelm.robots.contact import BRISK

_STANDING = 0.05
"""A robot slower than this stands, m/s."""
_BLOCKED = 1e4
"""Cost of a wall that cannot be avoided any more: above all others."""
_CREDIBLE = 0.05
"""Hypotheses below this probability are no predicted contact."""


class RolloutWeights(NamedTuple):
    """Weights and margins; those without a text are fields of ``TrajectorySampler.Parameters``."""

    final_delay: float
    mean_delay: float
    path_distance: float
    final_heading: float
    turning: float
    acceleration: float
    contact: float
    standing_share: float
    fade: Floats
    """(N+1,) weight of the predictions for each step."""
    margin: Floats
    """(N+1,) gap to people below which the contact cost counts, m."""
    standing_margin: float
    """Gap to standing people, m."""
    deviations: float
    """Factor on the deviation of a prediction, added to the margin."""
    max_margin: float
    """Upper bound of both margins, m."""
    personal_space: float
    group_space: float
    wall: float
    clearance: float
    """Gap to walls below which they have a cost, m."""


class RolloutResult(NamedTuple):
    """Result of an arc."""

    cost: float
    """s; +inf: abandoned."""
    contact: float
    """Time when a person or a wall is first touched, s; else +inf."""
    stopped: int
    """Step at which a wall is touched; N if none is."""


@njit(cache=True, error_model="numpy")
def roll_out(  # noqa: PLR0917  # a kernel takes plain arrays
    scene: RolloutScene,
    weights: RolloutWeights,
    base: Floats,
    arc: Floats,
    limit: float,
    inputs: Floats,
    poses: Floats,
    due: Floats,
) -> RolloutResult:
    """Roll out one arc; abandoned with cost +inf if it costs more than ``limit``.

    Args:
        scene: surroundings of the robot.
        weights: of the costs.
        base: (L, m) inputs; after them the arc leads back to the path. L = 0: only ``arc`` counts.
        arc: (9,) row of the arc table; added to ``base`` if there is one.
        limit: cost above which the arc is abandoned, s.
        inputs: (N, m), filled as far as the arc was rolled out.
        poses: (N+1, 3), filled as well.
        due: (P,) workspace.
    """
    step, steps, path, robot = scene.step, scene.steps, scene.path, scene.robot
    m, holonomic = inputs.shape[1], robot.n_linear > 1
    cost, contact, free, s_goal = 0.0, np.inf, 0.0, path.reference[steps]
    # costs of one metre behind the reference
    final_delay = weights.final_delay / path.max_speed
    delay = weights.mean_delay / (path.max_speed * steps)
    poses[0] = robot.start
    due[:] = 0.0
    x, y, angle = poses[0, 0], poses[0, 1], poses[0, 2]
    # heading of the last step's translation
    course, soonest = angle, 0.0
    cos, sin = math.cos(course), math.sin(course)
    i_path, s, d = project_on_path(path.samples, x, y, 0)
    first_tangent = math.atan2(path.samples[0, 3], path.samples[0, 2])
    for k in range(steps):
        request_input(scene, base, arc, k, (x, y, angle, s, first_tangent), i_path, inputs[k])
        cost = limit_input(robot, path.max_speed, weights.acceleration / step, k, inputs, cost)
        # one step of the unicycle, or of a holonomic robot
        u = inputs[k]
        speed, turn_rate = abs(u[0]), u[m - 1]
        if angle + scene.heading_lead * turn_rate != course:
            course = angle + scene.heading_lead * turn_rate
            cos, sin = math.cos(course), math.sin(course)
        x += step * u[0] * cos
        y += step * u[0] * sin
        if holonomic:
            x -= step * sin * u[1]
            y += step * cos * u[1]
            speed = math.hypot(u[0], u[1])
        angle += step * turn_rate
        poses[k + 1, 0], poses[k + 1, 1], poses[k + 1, 2] = x, y, angle
        # progress, turning and distance from the path
        i_path, s, d = project_on_path(path.samples, x, y, i_path)
        lag = max(path.reference[k + 1] - s, 0.0)
        cost += delay * lag
        cost += step * (weights.turning * turn_rate * turn_rate + weights.path_distance * d * d)
        # walls, only after a distance in which none can be near
        free -= speed * step
        if free <= 0.0:
            free, touches, missing = missing_clearance(
                scene.walls, robot, x, y, angle, weights.clearance
            )
            cost += step * weights.wall * missing
            if touches:
                contact = min(contact, (k + 1) * step)
                cost = _wall_stop_cost(scene, weights, k, speed, (s, d), poses, cost)
                return RolloutResult(cost, contact, k)
        # people and groups
        social, soonest, contact = _people(scene, weights, k, (x, y, angle), due, soonest, contact)
        if scene.groups.support.shape[0]:
            depth = depth_in_hulls(scene.groups, robot.capsule, x, y, angle, k + 1)
            social += weights.fade[k + 1] * weights.group_space * depth
        cost += step * social * (weights.standing_share if speed < _STANDING else 1.0)
        # lower bound of the whole cost: the robot is never faster than the reference's maximum
        lost = max(s_goal - s - (steps - k - 1) * step * path.max_speed, 0.0)
        if cost + (final_delay + delay * (steps - k - 1)) * lost > limit:
            return RolloutResult(np.inf, contact, steps)
    cost += final_delay * math.hypot(max(s_goal - s, 0.0), d)
    cost += weights.final_heading * heading_cost(path, holonomic, x, y, angle, i_path)
    return RolloutResult(cost if cost <= limit else np.inf, contact, steps)


@njit(cache=True, error_model="numpy", inline="always")
def _wall_stop_cost(  # noqa: PLR0917  # a kernel takes plain arrays
    scene: RolloutScene,
    weights: RolloutWeights,
    k: int,
    speed: float,
    frenet: tuple[float, float],
    poses: Floats,
    cost: float,
) -> float:
    """Whole cost of an arc that touches a wall at step k; its further poses stay there.

    The robot would stop before the wall: the time from there on is lost.
    frenet: (s, d) at the contact.
    """
    step, steps, path = scene.step, scene.steps, scene.path
    s, d = frenet
    final_delay = weights.final_delay / path.max_speed
    delay = weights.mean_delay / (path.max_speed * steps)
    braking_steps = speed / scene.robot.fall[0]
    if k <= braking_steps + 1.0:
        cost += _BLOCKED * (2.0 - k / steps)
    s_stop = s - 0.5 * speed * step * braking_steps
    for j in range(k + 1, steps):
        cost += delay * max(path.reference[j + 1] - s_stop, 0.0)
        poses[j + 1] = poses[k + 1]
    lag = math.hypot(max(path.reference[steps] - s_stop, 0.0), d)
    total: float = cost + final_delay * lag + 0.5 * weights.final_heading
    return total


@njit(cache=True, error_model="numpy", inline="always")
def _people(  # noqa: PLR0917  # a kernel takes plain arrays
    scene: RolloutScene,
    weights: RolloutWeights,
    k: int,
    pose: tuple[float, float, float],
    due: Floats,
    soonest: float,
    contact: float,
) -> tuple[float, float, float]:
    """(cost of all people at step k + 1, first step when one is due again, first contact, s).

    due: (P,) step before which each person cannot be near; updated.
    """
    people, robot, step = scene.people, scene.robot, scene.step
    states = people.states
    extent = people.extent if weights.personal_space > 0.0 else 0.0
    widest = max(weights.max_margin, extent)
    x, y, angle = pose
    cost = 0.0
    if k + 1 >= soonest:
        soonest = np.inf
    for i in range(states.shape[0] if soonest == np.inf else 0):
        if k + 1 < due[i]:
            soonest = min(soonest, due[i])
            continue
        # far people are skipped for as long as both speeds allow
        dx, dy = states[i, k + 1, 0] - x, states[i, k + 1, 1] - y
        excess = math.sqrt(dx * dx + dy * dy) - robot.outer_radius - people.radius[i] - widest
        if excess > 0.0:
            closing_speed = people.fastest[i] + robot.top_speed + 0.01
            due[i] = k + 2 + int(excess / (step * closing_speed))
            soonest = min(soonest, due[i])
            continue
        soonest = 0.0
        gap, nx, ny = capsule_gap(robot.capsule, angle, dx, dy)
        gap -= people.radius[i]
        weight = people.weight[i] * weights.fade[k + 1]
        if gap < 0.0 and people.weight[i] > _CREDIBLE:
            contact = min(contact, (k + 1) * step)
        # about a standing person only the deviation grows
        margin = weights.margin[k + 1] - weights.standing_margin
        margin = margin * min(people.fastest[i] / BRISK, 1.0)
        margin += weights.standing_margin + weights.deviations * states[i, k + 1, 7]
        margin = min(margin, weights.max_margin)
        if gap < margin:
            cost += weight * weights.contact * (margin - gap) * (margin - gap)
        if gap < extent:
            intrusion = space_intrusion(people, states[i, k + 1], gap, nx, ny)
            cost += weight * weights.personal_space * intrusion
    return cost, soonest, contact
