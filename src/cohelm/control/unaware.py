"""Time for which people have been walking into the robot: those who keep to it do not see it.

People who see the robot soon leave a course into it. Only for those who do not are the brakes used
while they come from behind, see ``Verification.unaware_after``.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats
from cohelm.control.api import LocalProblem
from cohelm.control.planner_memory import PlannerMemory, remembered
from cohelm.kernels import CACHED
from cohelm.robots.capsule import gap_to_disc
from cohelm.robots.contact_kernel import WALKING

_AHEAD = 2.0
"""Time within which a course must lead into the robot, s."""
_TESTS = 20
"""Number of tests in that time."""
_CLOSING = 0.5
"""Relative speed from which somebody is on a course into the robot, m/s: who follows at its own
pace sees it."""
_CLOSE = 0.05
"""Gap that counts as contact, m."""
_FORGETS = 2.0
"""Speed at which that time falls off the course, as a multiple of its growth."""


def times_on_course(problem: LocalProblem, memory: PlannerMemory | None) -> Floats:
    """Times (n,) for which people have been on a course into the robot, s."""
    on = _on_course(
        problem.robot.capsule,
        problem.pose,
        problem.twist,
        problem.people.mean,
        problem.people.radius,
    )
    if memory is None:
        return np.zeros(len(on))
    elapsed = max(problem.time - memory.input_time, 0.0)
    before = remembered(memory, problem.people, memory.person_courses)
    return np.where(on, before + elapsed, np.maximum(before - _FORGETS * elapsed, 0.0))


@njit(**CACHED)
def _on_course(
    capsule: Floats, pose: Floats, twist: Floats, people: Floats, radius: Floats
) -> Booleans:
    """Mask (n,) of walking people who touch the robot soon if both go straight on."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    vx, vy = cos * twist[0] - sin * twist[1], sin * twist[0] + cos * twist[1]
    out, at = np.zeros(people.shape[0], dtype=np.bool_), pose.copy()
    for i in range(people.shape[0]):
        closing = math.hypot(people[i, 2] - vx, people[i, 3] - vy)
        if math.hypot(people[i, 2], people[i, 3]) < WALKING or closing < _CLOSING:
            continue
        for k in range(1, _TESTS + 1):
            time = _AHEAD * k / _TESTS
            at[0], at[1] = pose[0] + time * vx, pose[1] + time * vy
            x, y = people[i, 0] + time * people[i, 2], people[i, 1] + time * people[i, 3]
            if gap_to_disc(capsule, at, x, y, radius[i]) < _CLOSE:
                out[i] = True
                break
    return out


def near_ahead(problem: LocalProblem, near: float) -> Booleans:
    """Mask (n,) of people nearer than ``near``, m, in the direction of the robot's motion."""
    away = problem.people.mean[:, :2] - problem.pose[:2]
    distance = np.hypot(away[:, 0], away[:, 1])
    vx, vy, heading = problem.twist[0], problem.twist[1], problem.pose[2]
    cos, sin = math.cos(heading), math.sin(heading)
    along = away @ np.array([cos * vx - sin * vy, sin * vx + cos * vy])
    ahead: Booleans = (along > 0.5 * distance * math.hypot(vx, vy)) & (distance < near)
    return ahead
