"""Clearance from walls, over time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pydantic import Field

from cohelm.config import Model
from cohelm.control.scene import RobotTable, Scene, WallTable
from cohelm.control.terms.stage import LocalModel, Stage, add_square
from cohelm.kernels import INNER, KERNEL, callee
from cohelm.maps.distance import sample

NAME = "wall_clearance"


class WallClearance(Model):
    """Squared missing share of the clearance to walls; assumed."""

    weight: float = Field(0.5, ge=0.0)
    """Without unit."""
    distance: float = Field(0.1, ge=0.0)
    """Desired gap to walls beyond the rider's clearance, m."""

    def table(self, scene: Scene) -> WallClearanceTable:
        """Weight of a step."""
        distance = self.distance + scene.walls.clearance
        return WallClearanceTable(self.weight * scene.step, max(distance, 1e-6))


class WallClearanceTable(NamedTuple):
    """Weight of a step."""

    weight: float
    """s."""
    distance: float
    """Desired gap, m."""


class WallGap(NamedTuple):
    """Nearest wall at a stage."""

    gap: float
    """Between a disc of the footprint and a wall, m."""
    disc: int
    """Index of that disc."""
    touches: bool
    """Some disc is nearer than its contact margin."""


@callee(INNER)
def nearest_wall(walls: WallTable, robot: RobotTable, stage: Stage) -> WallGap:
    """The smallest gap between the footprint's discs and a wall."""
    grid, discs = walls.grid, robot.discs
    nearest, at, touches = np.inf, 0, False
    for j in range(discs.shape[0]):
        x = stage.x + stage.cos * discs[j, 0] - stage.sin * discs[j, 1]
        y = stage.y + stage.sin * discs[j, 0] + stage.cos * discs[j, 1]
        gap = sample(grid.distance, grid.resolution, grid.X_MG, x, y)[0] - discs[j, 2]
        touches |= gap < walls.margin[j]
        if gap < nearest:
            nearest, at = gap, j
    return WallGap(nearest, at, touches)


@callee(INNER)
def cost(t: WallClearanceTable, gap: float) -> float:
    """Cost of a gap, s."""
    missing = max(t.distance - gap, 0.0) / t.distance
    return t.weight * missing * missing


@callee(KERNEL)
def model(
    t: WallClearanceTable, walls: WallTable, robot: RobotTable, stage: Stage, q: LocalModel
) -> None:
    """Add the model of a stage."""
    nearest = nearest_wall(walls, robot, stage)
    missing = t.distance - nearest.gap
    if t.weight > 0.0 and missing > 0.0:
        gx, gy, ga = gap_gradient(walls, robot, stage, nearest.disc)
        f = -1.0 / t.distance
        add_square(q, stage.k, t.weight, missing / t.distance, f * gx, f * gy, f * ga)


@callee(KERNEL)
def gap_gradient(
    walls: WallTable, robot: RobotTable, stage: Stage, disc: int
) -> tuple[float, float, float]:
    """∂gap/∂(x, y, θ) of a disc."""
    grid, d = walls.grid, robot.discs[disc]
    ax, ay = stage.cos * d[0] - stage.sin * d[1], stage.sin * d[0] + stage.cos * d[1]
    x, y = stage.x + ax, stage.y + ay
    _, gx, gy = sample(grid.distance, grid.resolution, grid.X_MG, x, y)
    return gx, gy, -gx * ay + gy * ax
