"""Progress: the time lost against the reference, in seconds."""

from __future__ import annotations

import math
from typing import NamedTuple

from pydantic import Field

from cohelm.config import Model
from cohelm.control.path import PathTable
from cohelm.control.scene import Scene
from cohelm.control.terms.stage import LocalModel, Stage, add_curvature, add_slope
from cohelm.kernels import INNER, KERNEL, callee

NAME = "progress"
_SMOOTH = 1e-3
"""Distance from the end of the reference at which its norm is rounded, m."""
_NEAR = 0.02
"""Distance from the kink of a cost below which its parabola is not narrower, m."""


class Progress(Model):
    """Seconds behind the reference along the path; assumed."""

    final: float = Field(1.0, ge=0.0)
    """Cost of a second lost at the end of the horizon."""
    mean: float = Field(1.0, ge=0.0)
    """Cost of a second lost on average over the horizon: sooner is better."""

    def table(self, scene: Scene) -> ProgressTable:
        """Weights per metre."""
        speed = scene.path.max_speed
        return ProgressTable(self.mean / (speed * scene.steps), self.final / speed)


class ProgressTable(NamedTuple):
    """Weights of a metre."""

    mean: float
    """At each step, s/m."""
    final: float
    """At the end of the horizon, s/m."""


@callee(INNER)
def cost(t: ProgressTable, path: PathTable, stage: Stage) -> float:
    """Cost of a stage, s."""
    lag: float = max(path.reference[stage.k] - stage.s, 0.0)
    return t.mean * lag


@callee(INNER)
def final_cost(t: ProgressTable, path: PathTable, stage: Stage) -> float:
    """Cost of the last state: its distance from the end of the reference, s."""
    lag = max(path.reference[stage.k] - stage.s, 0.0)
    return t.final * (math.sqrt(lag * lag + stage.d * stage.d + _SMOOTH * _SMOOTH) - _SMOOTH)


@callee(KERNEL)
def model(t: ProgressTable, path: PathTable, stage: Stage, q: LocalModel) -> None:
    """Add the model of a stage: the parabola through it that lies above the hinge.

    With a linear model the step overshoots the hinge. Outside a bend, between the normals of two
    segments, the arc length is constant; the model keeps the slope of a smooth path there, or the
    robot would not know that going on is worth it.
    """
    if path.reference[stage.k] > stage.s:
        tx, ty = path.samples[stage.i_path, 2], path.samples[stage.i_path, 3]
        lag = path.reference[stage.k] - stage.s
        add_slope(q, stage.k, -t.mean, tx, ty, 0.0)
        add_curvature(q, stage.k, t.mean / max(lag, _NEAR), tx, ty, 0.0)


@callee(KERNEL)
def final_model(t: ProgressTable, path: PathTable, stage: Stage, q: LocalModel) -> None:
    """Add the model of the last state: the parabola through it that lies above the norm."""
    lag = max(path.reference[stage.k] - stage.s, 0.0)
    norm = math.sqrt(lag * lag + stage.d * stage.d + _SMOOTH * _SMOOTH)
    tx, ty = path.samples[stage.i_path, 2], path.samples[stage.i_path, 3]
    slope, size = t.final / norm, t.final / max(norm, _NEAR)
    add_slope(q, stage.k, slope, stage.d * -ty - lag * tx, stage.d * tx - lag * ty, 0.0)
    add_curvature(q, stage.k, size, -ty, tx, 0.0)
    if lag > 0.0:
        add_curvature(q, stage.k, size, tx, ty, 0.0)
