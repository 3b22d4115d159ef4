"""Distance from the path."""

from __future__ import annotations

from typing import NamedTuple

from pydantic import Field

from cohelm.config import Model
from cohelm.control.path import PathTable
from cohelm.control.scene import Scene
from cohelm.control.terms.stage import LocalModel, Stage, add_square
from cohelm.kernels import INNER, KERNEL, callee

NAME = "path_distance"


class PathDistance(Model):
    """Squared distance from the path; assumed."""

    weight: float = Field(0.08, ge=0.0)
    """1/m²: small, a detour is no fault."""

    def table(self, scene: Scene) -> PathDistanceTable:
        """Weight of a step."""
        return PathDistanceTable(self.weight * scene.step)


class PathDistanceTable(NamedTuple):
    """Weight of a step."""

    weight: float
    """s/m²."""


@callee(INNER)
def cost(t: PathDistanceTable, stage: Stage) -> float:
    """Cost of a stage, s."""
    return t.weight * stage.d * stage.d


@callee(KERNEL)
def model(t: PathDistanceTable, path: PathTable, stage: Stage, q: LocalModel) -> None:
    """Add the model of a stage."""
    if t.weight > 0.0:
        tx, ty = path.samples[stage.i_path, 2], path.samples[stage.i_path, 3]
        add_square(q, stage.k, t.weight, stage.d, -ty, tx, 0.0)
