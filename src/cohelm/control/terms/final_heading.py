"""Heading at the end of the horizon: towards the path ahead."""

from __future__ import annotations

import math
from typing import NamedTuple

from pydantic import Field

from cohelm.config import Model
from cohelm.control.path import SPACING, PathTable
from cohelm.control.scene import Scene
from cohelm.control.terms.stage import LocalModel, Stage, add_curvature, add_slope
from cohelm.kernels import INNER, KERNEL, callee

NAME = "final_heading"
_AIM = round(2.0 / SPACING)
"""Lookahead: 2 m, in samples."""


class FinalHeading(Model):
    """1 − cos of the final angle between the heading and the path ahead; assumed."""

    weight: float = Field(1.0, ge=0.0)
    """s. A robot that cannot move sideways needs it: a turn that is left costs time later."""

    def table(self, scene: Scene) -> FinalHeadingTable:
        """Weight and kind of robot."""
        return FinalHeadingTable(self.weight, scene.robot.n_linear > 1)


class FinalHeadingTable(NamedTuple):
    """Weight and kind of robot."""

    weight: float
    """s."""
    holonomic: bool
    """Only the path's own heading counts."""


@callee(INNER)
def _error(t: FinalHeadingTable, path: PathTable, stage: Stage) -> tuple[float, float, float]:
    """(heading error, rad; its derivatives by x and y, rad/m); that by the heading is 1."""
    ahead = min(stage.i_path + _AIM, path.samples.shape[0] - 1)
    if t.holonomic:
        wanted = math.atan2(path.heading[ahead, 1], path.heading[ahead, 0])
        return stage.heading - wanted, 0.0, 0.0
    dx, dy = path.samples[ahead, 0] - stage.x, path.samples[ahead, 1] - stage.y
    square = max(dx * dx + dy * dy, 1e-9)
    wanted, i = math.atan2(dy, dx), stage.i_path
    along = path.heading[i, 0] * path.samples[i, 2] + path.heading[i, 1] * path.samples[i, 3]
    if along < 0.0:  # the path is driven backwards
        wanted += math.pi
    return stage.heading - wanted, -dy / square, dx / square


@callee(INNER)
def final_cost(t: FinalHeadingTable, path: PathTable, stage: Stage) -> float:
    """Cost of the last state, s."""
    return t.weight * (1.0 - math.cos(_error(t, path, stage)[0]))


@callee(KERNEL)
def final_model(t: FinalHeadingTable, path: PathTable, stage: Stage, q: LocalModel) -> None:
    """Add the model of the last state: 1 − cos e = ½ (2 sin e/2)²."""
    error, ex, ey = _error(t, path, stage)
    add_slope(q, stage.k, t.weight * math.sin(error), ex, ey, 1.0)
    half = math.cos(0.5 * error)
    add_curvature(q, stage.k, t.weight * half * half, ex, ey, 1.0)
