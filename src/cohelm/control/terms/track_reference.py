"""Tracking of the reference's poses: Xu et al., eq. (12)."""

from __future__ import annotations

from typing import NamedTuple

from pydantic import Field

from cohelm.config import Model
from cohelm.control.path import PathTable
from cohelm.control.scene import Scene
from cohelm.control.terms.stage import LocalModel, Stage, add_square
from cohelm.kernels import INNER, KERNEL, callee

NAME = "track_reference"


class TrackReference(Model):
    """(x − x̂)ᵀ Q_s (x − x̂), Xu et al., eq. (12), at steps 1…N; the last one weighs more (J_N)."""

    position: float = Field(0.0, ge=0.0)
    """Weight of the distance to the reference, 1/m² per second."""
    heading: float = Field(0.0, ge=0.0)
    """Weight of the heading error, 1/rad² per second."""
    terminal: float = Field(4.0, ge=0.0)
    """Additional weight of the last state, s."""

    def table(self, scene: Scene) -> TrackTable:
        """Weights."""
        return TrackTable(
            self.position, self.heading, scene.step, scene.step + self.terminal, scene.steps
        )


class TrackTable(NamedTuple):
    """Weights, and the duration by which a state counts."""

    position: float
    heading: float
    step: float
    last: float
    """s."""
    steps: int


@callee(INNER)
def cost(t: TrackTable, path: PathTable, stage: Stage) -> float:
    """Cost of a stage."""
    if t.position == 0.0 and t.heading == 0.0:
        return 0.0
    duration = t.last if stage.k == t.steps else t.step
    dx, dy = stage.x - path.poses[stage.k, 0], stage.y - path.poses[stage.k, 1]
    turn = stage.heading - path.poses[stage.k, 2]
    square: float = t.position * (dx * dx + dy * dy) + t.heading * turn * turn
    return duration * square


@callee(KERNEL)
def model(t: TrackTable, path: PathTable, stage: Stage, q: LocalModel) -> None:
    """Add the model of a stage."""
    if t.position == 0.0 and t.heading == 0.0:
        return
    duration, k = t.last if stage.k == t.steps else t.step, stage.k
    add_square(q, k, duration * t.position, stage.x - path.poses[k, 0], 1.0, 0.0, 0.0)
    add_square(q, k, duration * t.position, stage.y - path.poses[k, 1], 0.0, 1.0, 0.0)
    add_square(q, k, duration * t.heading, stage.heading - path.poses[k, 2], 0.0, 0.0, 1.0)
