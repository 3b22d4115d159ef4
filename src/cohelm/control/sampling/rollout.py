"""Kernel: one arc rolled out through the scene, with its cost in seconds.

Costs add up and none is negative, so an arc is abandoned as soon as it is dearer than the best one
by more than a window. The result does not depend on the order of the arcs. Blocks are inlined,
because calls that pass the whole state are expensive.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.sampling.interactions import (
    body_gap,
    depth_in_hulls,
    missing_clearance,
    space_intrusion,
)
from cohelm.control.sampling.path_samples import SPACING, heading_error, project_on_path
from cohelm.control.sampling.scene import RobotBody, RolloutScene
from cohelm.robots.contact import BRISK

_LOOKAHEAD = round(1.0 / SPACING)
"""Lookahead of the return to the path: 1 m, in samples."""
_GAIN = 2.5
"""Turn rate per heading error in the return to the path, 1/s."""
_FULL = 2.0 * math.pi
_STANDING = 0.05
"""A robot slower than this stands, m/s."""
_BLOCKED = 1e4
"""Cost of a wall that cannot be avoided any more: above all others."""
_CREDIBLE = 0.05
"""Hypotheses below this probability are no predicted contact."""


class RolloutWeights(NamedTuple):
    """Weights and margins; see ``TrajectorySampler.Parameters``."""

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
    contact: float
    """Time when a body or a wall is first touched, s; else +inf."""
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
    """Roll out one arc; abandoned with cost +inf if it is dearer than ``limit``.

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
    step, steps, path, body = scene.step, scene.steps, scene.path, scene.body
    m, joint = inputs.shape[1], body.translating if body.translating > 1 else 0
    cost, contact, free, final = 0.0, np.inf, 0.0, path.reference[steps]
    final_delay, delay = weights.final_delay / path.pace, weights.mean_delay / (path.pace * steps)
    poses[0] = body.start
    due[:] = 0.0
    x, y, angle = poses[0, 0], poses[0, 1], poses[0, 2]
    middle, soonest = angle, 0.0
    cos, sin = math.cos(angle), math.sin(angle)  # of the middle of the last step
    at, along, aside = project_on_path(path.samples, x, y, 0)
    course = math.atan2(path.samples[0, 3], path.samples[0, 2])
    for k in range(steps):
        _request(scene, base, arc, k, (x, y, angle, along, course), at, inputs[k])
        cost = _limit(body, path.pace, weights.acceleration / step, k, inputs, cost)
        # one step of the unicycle, or of a holonomic robot
        wanted = inputs[k]
        speed, turn = abs(wanted[0]), wanted[m - 1]
        if angle + scene.blur * turn != middle:
            middle = angle + scene.blur * turn
            cos, sin = math.cos(middle), math.sin(middle)
        x += step * wanted[0] * cos
        y += step * wanted[0] * sin
        if joint:
            x -= step * sin * wanted[1]
            y += step * cos * wanted[1]
            speed = math.hypot(wanted[0], wanted[1])
        angle += step * turn
        poses[k + 1, 0], poses[k + 1, 1], poses[k + 1, 2] = x, y, angle
        # progress, turning and distance from the path
        at, along, aside = project_on_path(path.samples, x, y, at)
        lag = max(path.reference[k + 1] - along, 0.0)
        cost += delay * lag
        cost += step * (weights.turning * turn * turn + weights.path_distance * aside * aside)
        # walls, only after a distance in which none can be near
        free -= speed * step
        if free <= 0.0:
            free, touch, missing = missing_clearance(
                scene.walls, body, x, y, angle, weights.clearance
            )
            cost += step * weights.wall * missing
            if touch:
                contact = min(contact, (k + 1) * step)
                braking = speed / body.fall[0]
                if k <= braking + 1.0:
                    cost += _BLOCKED * (2.0 - k / steps)
                # the robot would stop before the wall: the time from here on is lost
                stop = along - 0.5 * speed * step * braking
                for j in range(k + 1, steps):
                    cost += delay * max(path.reference[j + 1] - stop, 0.0)
                    poses[j + 1] = poses[k + 1]
                lag = math.hypot(max(final - stop, 0.0), aside)
                total = cost + final_delay * lag + 0.5 * weights.final_heading
                return RolloutResult(total, contact, k)
        # people and groups
        social, soonest, contact = _people(scene, weights, k, (x, y, angle), due, soonest, contact)
        if scene.groups.support.shape[0]:
            depth = depth_in_hulls(scene.groups, body.capsule, x, y, angle, k + 1)
            social += weights.fade[k + 1] * weights.group_space * depth
        cost += step * social * (weights.standing_share if speed < _STANDING else 1.0)
        # lower bound of the whole cost: the robot is never faster than the reference's pace
        lost = max(final - along - (steps - k - 1) * step * path.pace, 0.0)
        if cost + (final_delay + delay * (steps - k - 1)) * lost > limit:
            return RolloutResult(np.inf, contact, steps)
    cost += final_delay * math.hypot(max(final - along, 0.0), aside)
    cost += weights.final_heading * heading_error(path, joint, x, y, angle, at)
    return RolloutResult(cost if cost <= limit else np.inf, contact, steps)


@njit(cache=True, error_model="numpy", inline="always")
def _request(  # noqa: PLR0917  # a kernel takes plain arrays
    scene: RolloutScene,
    base: Floats,
    arc: Floats,
    k: int,
    state: tuple[float, float, float, float, float],
    at: int,
    wanted: Floats,
) -> None:
    """Fill ``wanted`` (m,) with the input that the arc requests at step k.

    state: (x, y, heading, arc length on the path, course of the path at the start).
    at: nearest sample of the path.
    """
    path, body = scene.path, scene.body
    samples, pace = path.samples, path.pace
    joint = body.translating if body.translating > 1 else 0
    x, y, angle, along, course = state
    known, share = base.shape[0], k / scene.steps
    if share >= arc[8] or (known > 0 and k >= known):
        # back to the path, towards a point ahead on it
        ahead = min(at + _LOOKAHEAD, samples.shape[0] - 1)
        dx, dy = samples[ahead, 0] - x, samples[ahead, 1] - y
        speed = min(max(arc[4], 0.0), 1.0) if known == 0 else 1.0
        speed = min(speed * pace, max(path.reference[scene.steps] - along, 0.0) / scene.step)
        if joint:
            towards = math.atan2(dy, dx) - angle
            wanted[0], wanted[1] = speed * math.cos(towards), speed * math.sin(towards)
        else:
            error = math.atan2(dy, dx) - angle
            error -= _FULL * round(error / _FULL)
            wanted[0] = speed * max(math.cos(error), 0.0)
            wanted[1] = _GAIN * error
        turns = joint > 0
    else:
        # one of three segments, absolute or added to the base
        part = 0 if share < arc[6] else (2 if share < arc[7] else 4)
        speed, turn = arc[part], arc[part + 1]
        turns = joint > 0 and known == 0
        if known > 0:
            wanted[:] = base[k]
            wanted[0] += speed * pace
            wanted[1] += turn * body.high[1]
        elif joint:
            wanted[0] = speed * pace * math.cos(course + turn * math.pi - angle)
            wanted[1] = speed * pace * math.sin(course + turn * math.pi - angle)
        else:
            wanted[0] = speed * (pace if speed > 0.0 else -body.low[0])
            wanted[1] = turn * body.high[1]
    if turns:  # a holonomic robot turns to the path's heading meanwhile
        error = math.atan2(path.heading[at, 1], path.heading[at, 0]) - angle
        wanted[2] = 0.5 * _GAIN * (error - _FULL * round(error / _FULL))


@njit(cache=True, error_model="numpy", inline="always")
def _limit(  # a kernel takes plain arrays
    body: RobotBody, pace: float, weight: float, k: int, inputs: Floats, cost: float
) -> float:
    """Reduce the input at step k to the limits; the cost with that of its change.

    The first step allows half a change, because the next decision comes before its end.
    """
    wanted, m = inputs[k], inputs.shape[1]
    joint = body.translating if body.translating > 1 else 0
    half = 0.5 if k == 0 else 1.0
    # each input within its bounds, then the speed
    square = 0.0
    for i in range(m):
        most = min(body.high[i], pace) if i == 0 else body.high[i]
        wanted[i] = min(max(wanted[i], body.low[i]), most)
        square += wanted[i] * wanted[i] if i < joint else 0.0
    top = min(body.top_speed, pace)
    shorter = min(1.0, top / math.sqrt(square)) if square > 0.0 else 1.0
    # the share of a joint change that keeps every component within its acceleration
    part_of = 1.0
    for i in range(joint):
        wanted[i] *= shorter
        change = wanted[i] - (inputs[k - 1, i] if k > 0 else body.now[i])
        most = half * (body.rise[i] if change > 0.0 else body.fall[i])
        if abs(change) > most:
            part_of = min(part_of, most / abs(change))
    for i in range(m):
        before = inputs[k - 1, i] if k > 0 else body.now[i]
        change = wanted[i] - before
        if i < joint:
            change *= part_of
        else:
            change = min(max(change, -half * body.fall[i]), half * body.rise[i])
        wanted[i] = before + change
        cost += weight * change * change
    return cost


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
    people, body, step = scene.people, scene.body, scene.step
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
        apart = math.sqrt(dx * dx + dy * dy) - body.around - people.radius[i] - widest
        if apart > 0.0:
            fastest = people.fastest[i] + body.top_speed + 0.01
            due[i] = k + 2 + int(apart / (step * fastest))
            soonest = min(soonest, due[i])
            continue
        soonest = 0.0
        gap, nx, ny = body_gap(body.capsule, angle, dx, dy)
        gap -= people.radius[i]
        likely = people.weight[i] * weights.fade[k + 1]
        if gap < 0.0 and people.weight[i] > _CREDIBLE:
            contact = min(contact, (k + 1) * step)
        # about a standing person only the deviation grows
        margin = weights.margin[k + 1] - weights.standing_margin
        margin = margin * min(people.fastest[i] / BRISK, 1.0)
        margin += weights.standing_margin + weights.deviations * states[i, k + 1, 7]
        margin = min(margin, weights.max_margin)
        if gap < margin:
            cost += likely * weights.contact * (margin - gap) * (margin - gap)
        if gap < extent:
            intrusion = space_intrusion(people, states[i, k + 1], gap, nx, ny)
            cost += likely * weights.personal_space * intrusion
    return cost, soonest, contact
