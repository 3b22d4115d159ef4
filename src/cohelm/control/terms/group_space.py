"""Intrusion into the spaces of groups: no passage between people who belong together."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.scene import GroupTable, Scene
from cohelm.control.terms.stage import LocalModel, Stage, add_square
from cohelm.kernels import INNER, KERNEL, callee

NAME = "group_space"
_ROUNDING = 1e-9


class GroupSpace(Model):
    """Squared depth of the robot in the hull of a group; assumed."""

    weight: float = Field(60.0, ge=0.0)
    """1/m²: driving between people 1.8 m apart costs more than waiting for the whole horizon."""

    def table(self, scene: Scene) -> GroupSpaceTable:
        """Weight of a step, and the robot as a disc."""
        capsule = scene.robot.capsule
        mx, my = 0.5 * (capsule[0] + capsule[2]), 0.5 * (capsule[1] + capsule[3])
        return GroupSpaceTable(self.weight * scene.step, float(mx), float(my), float(capsule[4]))


class GroupSpaceTable(NamedTuple):
    """Weight of a step, and the robot as a disc about the middle of its spine."""

    weight: float
    """s/m²."""
    x: float
    """Of the middle in the robot frame, m."""
    y: float
    radius: float
    """m."""


@callee(INNER)
def cost(t: GroupSpaceTable, groups: GroupTable, stage: Stage) -> float:
    """Cost of a stage, s: the sum over all groups."""
    total = 0.0
    reach = math.hypot(t.x, t.y) + t.radius + _ROUNDING
    for g in range(groups.support.shape[0]):
        disc = groups.disc[g, stage.k]
        dx, dy = stage.x - disc[0], stage.y - disc[1]
        if dx * dx + dy * dy < (disc[2] + reach) * (disc[2] + reach):
            depth, _ = _depth(t, groups.support[g, stage.k], groups.normal, stage)
            total += t.weight * depth * depth
    return total


@callee(KERNEL)
def model(
    t: GroupSpaceTable, groups: GroupTable, stage: Stage, share: float, q: LocalModel
) -> None:
    """Add the model of ``share`` of the cost of a stage."""
    for g in range(groups.support.shape[0]):
        depth, j = _depth(t, groups.support[g, stage.k], groups.normal, stage)
        if depth > 0.0:
            ux, uy = groups.normal[j, 0], groups.normal[j, 1]
            arm_x = stage.cos * t.x - stage.sin * t.y
            arm_y = stage.sin * t.x + stage.cos * t.y
            turned = ux * arm_y - uy * arm_x
            add_square(q, stage.k, share * t.weight, depth, -ux, -uy, turned)


@callee(INNER)
def _depth(t: GroupSpaceTable, support: Floats, normal: Floats, stage: Stage) -> tuple[float, int]:
    """(depth in a hull, ≥ 0: the shortest distance to its border; index of that normal)."""
    x = stage.x + stage.cos * t.x - stage.sin * t.y
    y = stage.y + stage.sin * t.x + stage.cos * t.y
    depth, nearest = np.inf, 0
    for j in range(normal.shape[0]):
        inner = support[j] - x * normal[j, 0] - y * normal[j, 1] + t.radius
        if inner < depth:
            depth, nearest = inner, j
        if depth <= 0.0:
            break
    return max(depth, 0.0), nearest
