"""Clearance from people's bodies, over time."""

from __future__ import annotations

from typing import NamedTuple

from pydantic import Field

from cohelm.config import Model
from cohelm.control.scene import Scene
from cohelm.control.terms.encounter import gap_gradient
from cohelm.control.terms.stage import Encounter, LocalModel, add_square
from cohelm.kernels import INNER, KERNEL, callee

NAME = "person_clearance"
STANDS = 0.2
"""Speed up to which the costs of people grow with the robot's, m/s."""


class PersonClearance(Model):
    """Squared intrusion into the clearance of a person; assumed. See ``robots.clearance``."""

    weight: float = Field(60.0, ge=0.0)
    """1/m², by probability and age of the prediction."""
    standing_share: float = Field(0.4, ge=0.0, le=1.0)
    """Share of all costs of people while the robot stands: they may walk into it anyway."""

    def table(self, scene: Scene) -> PersonClearanceTable:
        """Weight of a step."""
        return PersonClearanceTable(self.weight * scene.step, self.standing_share)


class PersonClearanceTable(NamedTuple):
    """Weight of a step."""

    weight: float
    """s/m²."""
    standing_share: float


@callee(INNER)
def speed_share(t: PersonClearanceTable, speed: float) -> float:
    """Share of the costs of people at a speed of the robot."""
    return t.standing_share + (1.0 - t.standing_share) * min(speed / STANDS, 1.0)


@callee(INNER)
def cost(t: PersonClearanceTable, margin: float, e: Encounter) -> float:
    """Cost of an encounter, s."""
    missing = max(margin - e.gap, 0.0)
    return t.weight * missing * missing


@callee(KERNEL)
def model(
    t: PersonClearanceTable, margin: float, e: Encounter, k: int, share: float, q: LocalModel
) -> None:
    """Add the model of ``share`` of the cost of an encounter at state k."""
    missing = margin - e.gap
    if missing > 0.0:
        gx, gy, ga = gap_gradient(e)
        add_square(q, k, share * t.weight, missing, -gx, -gy, -ga)
