"""Slack is not safety: a plan is checked against bodies and walls before it may be used.

Bodies are tested swept between steps (0.1 s at 2.4 m/s of closing speed is 0.24 m), and a command is
accepted only if braking after it stays clear of walls and of the people's predicted bodies.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.constraints.bodies import flattened
from cohelm.control.constraints.separation import nearest_on_spine
from cohelm.maps.distance import sample

_SUBSTEPS = 4
_STANDING = 0.02


def first_contact(problem: LocalProblem, motion: Motion, *, margin: float) -> float:
    """When the motion would first touch a wall or, while moving, a predicted body, s; else +inf.

    Args:
        problem: walls, people and their predictions.
        motion: what is to be checked; beyond the predictions' end people keep their last velocity.
        margin: distance that counts as contact, m; never more than there is at the start, so that
            a chair that stands close to something may leave.
    """
    predictions, walls = problem.predictions, problem.walls
    hypotheses = predictions.mean.shape[1]
    return _first_contact(
        problem.robot.capsule,
        problem.robot.discs,
        motion.poses,
        motion.step,
        flattened(predictions.mean),
        flattened(predictions.velocity),
        np.repeat(problem.people.radius, hypotheses),
        predictions.step,
        walls.distance,
        walls.resolution,
        walls.X_MG,
        margin,
    )


def braking(problem: LocalProblem, motion: Motion, *, after: float, deceleration: float) -> Motion:
    """The motion's first input held for ``after``, then braking to a stand along the same arc.

    Args:
        problem: where the robot is.
        motion: the plan.
        after: how long the first input holds, s.
        deceleration: of braking, m/s².
    """
    step = 0.05
    first = motion.inputs[0]
    speed = abs(float(first[0]))
    hold = math.ceil(after / step - 1e-9)
    count = hold + math.ceil(speed / (deceleration * step)) + 1
    fading = np.clip(1.0 - np.arange(count - hold) * deceleration * step / max(speed, 1e-9), 0, 1)
    if speed < _STANDING:
        fading = np.clip(1.0 - np.arange(count - hold) * 0.5, 0, 1)
    share = np.concatenate([np.ones(hold), fading])
    inputs = share[:, None] * first
    poses = problem.robot.motion.rollout(problem.pose, inputs, step)
    return Motion(step=step, poses=poses, inputs=inputs, last_input=motion.last_input)


@njit(cache=True)
def _first_contact(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    discs: Floats,
    poses: Floats,
    step: float,
    positions: Floats,
    velocities: Floats,
    radius: Floats,
    person_step: float,
    distance: Floats32,
    resolution: float,
    X_MG: Floats,
    margin: float,
) -> float:
    people, known = positions.shape[0], positions.shape[1]
    pose = poses[0].copy()
    wall_margin = margin
    for j in range(discs.shape[0]):
        wall_margin = min(wall_margin, _wall_gap(discs[j], pose, distance, resolution, X_MG) - 1e-6)
    body_margin = np.empty(people)
    for i in range(people):
        d = nearest_on_spine(capsule, pose, positions[i, 0, 0], positions[i, 0, 1])[0]
        body_margin[i] = min(margin, d - capsule[4] - radius[i] - 1e-6)
    for k in range(poses.shape[0] - 1):
        moving = math.hypot(poses[k + 1, 0] - poses[k, 0], poses[k + 1, 1] - poses[k, 1])
        turning = abs(poses[k + 1, 2] - poses[k, 2])
        if moving < _STANDING * step and turning < _STANDING * step:
            continue
        for s in range(1, _SUBSTEPS + 1):
            share = s / _SUBSTEPS
            time = (k + share) * step
            for a in range(3):
                pose[a] = poses[k, a] + share * (poses[k + 1, a] - poses[k, a])
            for j in range(discs.shape[0]):
                if _wall_gap(discs[j], pose, distance, resolution, X_MG) < wall_margin:
                    return time
            at = time / person_step
            m = min(int(at), known - 1)
            rest = (at - m) * person_step
            for i in range(people):
                x = positions[i, m, 0] + rest * velocities[i, m, 0]
                y = positions[i, m, 1] + rest * velocities[i, m, 1]
                d = nearest_on_spine(capsule, pose, x, y)[0]
                if d - capsule[4] - radius[i] < body_margin[i]:
                    return time
    return np.inf


@njit(cache=True)
def _wall_gap(
    disc: Floats, pose: Floats, distance: Floats32, resolution: float, X_MG: Floats
) -> float:
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    x = pose[0] + cos * disc[0] - sin * disc[1]
    y = pose[1] + sin * disc[0] + cos * disc[1]
    return sample(distance, resolution, X_MG, x, y)[0] - disc[2]
