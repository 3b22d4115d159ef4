"""Speeds and accelerations that the robot can do: the set U of Xu et al., eq. (11)."""

from __future__ import annotations

import functools

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Measure, Motion, Rows


class InputLimits:
    """Hard bounds on inputs and on their change; linear, so exact in the quadratic program.

    Where the robot is beyond a bound already (a limit lowered in mid-ride) the bound opens as far
    as braking needs, so that the problem stays feasible.
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
        return Measure(slack=np.empty(0))

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, measure: Measure
    ) -> Rows:
        """Rise and fall of every input at every step, (N·m,); lowest and highest inputs."""
        del sensitivity, measure
        low, high, rise, fall = self.bounds(problem, motion)
        n, m = motion.inputs.shape
        change = np.diff(np.vstack([motion.last_input, motion.inputs]), axis=0)
        return Rows(
            margin=(change + fall).ravel(),
            room=(rise - change).ravel(),
            jacobian=_changes(n, m),
            group=np.full(n * m, -1),
            key=np.arange(n * m),
            keys=n * m,
            low=(low - motion.inputs).ravel(),
            high=(high - motion.inputs).ravel(),
        )

    def bounds(
        self, problem: LocalProblem, motion: Motion
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """(lowest, highest input, greatest rise, greatest fall) of each step, (N, m) each."""
        low, high, rise, fall = problem.input_bounds()
        n = len(motion.inputs)
        times = np.full((n, 1), motion.step)
        times[0] = self.parameters.tick
        elapsed = np.cumsum(times, axis=0)
        highest = np.maximum(high, motion.last_input - fall * elapsed)
        lowest = np.minimum(low, motion.last_input + rise * elapsed)
        return lowest, highest, rise * times, fall * times


@functools.lru_cache(maxsize=64)
def _changes(steps: int, inputs: int) -> Floats:
    """d(u_k − u_{k−1})/du, (N·m, N·m)."""
    size = steps * inputs
    return np.eye(size) - np.eye(size, k=-inputs)
