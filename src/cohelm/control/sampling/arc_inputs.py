"""Inputs of an arc: the one that it requests at a step, and its limits; inlined into rollouts."""

from __future__ import annotations

import math

from numba import njit

from cohelm.arrays import Floats
from cohelm.control.path import SPACING
from cohelm.control.sampling.arc_table import END_1, END_2, RETURN, SPEED_3
from cohelm.control.scene import RobotTable, Scene
from cohelm.kernels import INNER

_LOOKAHEAD = round(1.0 / SPACING)
"""Lookahead of the return to the path: 1 m, in samples."""
_GAIN = 2.5
"""Turn rate per heading error in the return to the path, 1/s."""
_FULL = 2.0 * math.pi


@njit(**INNER)
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


@njit(**INNER)
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


@njit(**INNER)
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
