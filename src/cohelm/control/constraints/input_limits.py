"""Speeds and accelerations that the robot can do: the set U of Xu et al., eq. (11)."""

from __future__ import annotations

import functools

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Integers, read_only
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Measure, Motion, Rows
from cohelm.robots import Kinematics

_FAR = 1e6
"""No bound, m/s."""
_NOTHING = Measure(slack=np.empty(0))


class InputLimits:
    """Hard bounds on inputs and on their change; linear, so exact in the quadratic program.

    A velocity over the floor with two components is bounded by the facets of a polygon besides, see
    ``Kinematics.facets``. Where the robot is beyond a bound already (a limit lowered in mid-ride)
    the bound opens as far as braking needs, so that the problem stays feasible.
    """

    class Parameters(Model):
        """How fast the first input may follow on what the wheels do now."""

        tick: float = Field(0.05, gt=0.0, le=1.0)
        """Time between two commands, s: the first change must fit into it."""

    name = "input_limits"
    l1 = 0.0
    l2 = 0.0

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def measure(self, problem: LocalProblem, motion: Motion) -> Measure:
        """Nothing yields: these bounds are hard, and no barrier."""
        del problem, motion
        return _NOTHING

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, measure: Measure
    ) -> Rows:
        """Rise and fall of every input at every step, the facets; lowest and highest inputs."""
        del sensitivity, measure
        kinematics = problem.robot.motion
        jacobian, key, hard = _constant(len(motion.inputs), kinematics)
        margin, room, low, high = _left_of(
            *problem.input_bounds(),
            motion.last_input,
            motion.inputs,
            motion.step,
            self.parameters.tick,
        )
        if len(kinematics.facets):
            excess = motion.inputs @ kinematics.facets.T
            slower = (self.fastest(problem, motion) - excess).ravel()
            margin = np.concatenate([margin, slower])
            room = np.concatenate([room, np.full(len(slower), _FAR)])
        return Rows(
            margin=margin,
            room=room,
            jacobian=jacobian,
            group=hard,
            key=key,
            keys=len(key),
            low=low,
            high=high,
        )

    def bounds(
        self, problem: LocalProblem, motion: Motion
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """(lowest, highest input, greatest rise, greatest fall) of each step, (N, m) each."""
        limits = problem.input_bounds()
        return _bounds(
            *limits, motion.last_input, len(motion.inputs), motion.step, self.parameters.tick
        )

    def fastest(self, problem: LocalProblem, motion: Motion) -> Floats:
        """What each facet's F u may be at each step, (N, f): the top speed, or braking to it."""
        kinematics, now = problem.robot.motion, motion.last_input
        _, _, rise, fall = problem.input_bounds()
        since = self.parameters.tick + motion.step * np.arange(len(motion.inputs))[:, None]
        braking = np.maximum(now - fall * since, 0.0) + np.minimum(now + rise * since, 0.0)
        return np.asarray(np.maximum(braking @ kinematics.facets.T, problem.top_speed))


@functools.lru_cache(maxsize=64)
def _constant(steps: int, kinematics: Kinematics) -> tuple[Floats, Integers, Integers]:
    """d(u_k − u_{k−1})/du, (N·m, N·m), and −F by blocks; the rows' keys and groups."""
    m = kinematics.inputs
    changes = np.eye(steps * m) - np.eye(steps * m, k=-m)
    jacobian = np.concatenate([changes, -np.kron(np.eye(steps), kinematics.facets)])
    count = len(jacobian)
    return read_only(jacobian), read_only(np.arange(count)), read_only(np.full(count, -1))


@njit(cache=True)
def _bounds(  # noqa: PLR0917  # a kernel takes plain arrays
    low: Floats,
    high: Floats,
    rise: Floats,
    fall: Floats,
    now: Floats,
    steps: int,
    step: float,
    tick: float,
) -> tuple[Floats, Floats, Floats, Floats]:
    m = len(now)
    lowest, highest = np.empty((steps, m)), np.empty((steps, m))
    faster, slower = np.empty((steps, m)), np.empty((steps, m))
    for k in range(steps):
        time = tick if k == 0 else step
        since = tick + k * step
        for i in range(m):
            highest[k, i] = max(high[i], now[i] - fall[i] * since)
            lowest[k, i] = min(low[i], now[i] + rise[i] * since)
            faster[k, i] = rise[i] * time
            slower[k, i] = fall[i] * time
    return lowest, highest, faster, slower


@njit(cache=True)
def _left_of(  # noqa: PLR0917  # a kernel takes plain arrays
    low: Floats,
    high: Floats,
    rise: Floats,
    fall: Floats,
    now: Floats,
    inputs: Floats,
    step: float,
    tick: float,
) -> tuple[Floats, Floats, Floats, Floats]:
    """``_left`` of ``_bounds``."""
    lowest, highest, faster, slower = _bounds(
        low, high, rise, fall, now, inputs.shape[0], step, tick
    )
    return _left(lowest, highest, faster, slower, now, inputs)


@njit(cache=True)
def _left(
    low: Floats, high: Floats, rise: Floats, fall: Floats, now: Floats, inputs: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """(margin, room) of each change and (least, greatest) change of each input, (N·m,) each."""
    steps, m = inputs.shape
    margin, room = np.empty(steps * m), np.empty(steps * m)
    least, greatest = np.empty(steps * m), np.empty(steps * m)
    for k in range(steps):
        for i in range(m):
            at = k * m + i
            change = inputs[k, i] - (inputs[k - 1, i] if k > 0 else now[i])
            margin[at] = change + fall[k, i]
            room[at] = rise[k, i] - change
            least[at] = low[k, i] - inputs[k, i]
            greatest[at] = high[k, i] - inputs[k, i]
    return margin, room, least, greatest
