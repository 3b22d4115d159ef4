"""Discrete-time control barriers (DCBF), Xu et al., eq. (9), on bodies, social spaces and walls.

    h_{k+1} − (1 − γ) h_k ≥ 0,   0 < γ ≤ 1,   h saturated at 1 m

Every barrier is soft: the largest violation s of a person's rows, or of a disc's, is priced
l1·s + ½ l2·s². h saturates, so that a person farther away constrains nothing.

- **bodies**: h = gap − clearance(t), see ``robots.clearance``; γ = 1 is a plain distance.
- **social space**: h = gap − l_i − l, eq. (8) with radii and clearance of the bodies added.
- **walls**: h = gap of a disc − the rider's clearance. Walls stand still, hence γ = 1.
"""

from __future__ import annotations

from typing import ClassVar, NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.config import Model
from cohelm.control.scene import Scene
from cohelm.kernels import CACHED, INNER, callee

REACH = 1.0
"""h saturates here, m."""
MOST_LIKELY = 1.0
"""Probability at which only the most likely hypothesis of each person constrains."""
_NO_HYPOTHESES = np.zeros(0, np.bool_)


class Price(Model):
    """Price of the violation of a barrier; assumed."""

    l1: float = Field(2.0, ge=0.0)
    """Price of the largest violation, s/m."""
    l2: float = Field(2.0, ge=0.0)
    """Price of its square, s/m²."""

    @property
    def is_active(self) -> bool:
        """A violation has a price."""
        return self.l1 > 0.0 or self.l2 > 0.0


class WallBarrier(Price):
    """The barrier of walls."""

    gamma: ClassVar[float] = 1.0
    """γ of eq. (9): walls stand still, so approaching one is no fault."""

    def table(self) -> BarrierTable:
        """The barrier for walls; no hypotheses constrain."""
        return BarrierTable(1.0 - self.gamma, self.l1, self.l2, _NO_HYPOTHESES, self.is_active, 2)


class Barrier(Price):
    """A barrier of people."""

    gamma: float = Field(0.3, gt=0.0, le=1.0)
    """γ of eq. (9), per step of the plan."""

    def table(
        self, scene: Scene, *, min_probability: float = MOST_LIKELY, norm: int = 2
    ) -> BarrierTable:
        """The barrier for people.

        Args:
            scene: with the people.
            min_probability: from which a hypothesis constrains; a person's most likely one always
                does.
            norm: of the distance: 2, 1, or 0 for the largest component.
        """
        people = scene.people
        binds = _binding(people.weight, people.person, people.num_people, min_probability)
        return BarrierTable(1.0 - self.gamma, self.l1, self.l2, binds, self.is_active, norm)

    def coarser(self, table: BarrierTable, stride: int) -> BarrierTable:
        """The table for ``stride`` steps of the plan in one."""
        return table._replace(keep=(1.0 - self.gamma) ** stride)


class BarrierTable(NamedTuple):
    """A barrier for compiled code."""

    keep: float
    """1 − γ, to the power of the steps in one."""
    l1: float
    l2: float
    binds: Booleans
    """(P,) hypotheses that constrain."""
    active: bool
    norm: int
    """Of the distance: 2, 1, or 0 for the largest component."""


@njit(**CACHED)
def _binding(weight: Floats, person: Integers, count: int, min_probability: float) -> Booleans:
    """Mask (P,) of the most likely hypothesis of each person, and of all above a probability."""
    likeliest = np.full(count, -1)
    for q in range(weight.shape[0]):
        i = person[q]
        if likeliest[i] < 0 or weight[q] > weight[likeliest[i]]:
            likeliest[i] = q
    out = np.zeros(weight.shape[0], np.bool_)
    for q in range(weight.shape[0]):
        out[q] = weight[q] >= min_probability or likeliest[person[q]] == q
    return out


@callee(INNER)
def price(t: BarrierTable, violation: float) -> float:
    """Price of the largest violation of a person or disc, s."""
    return t.l1 * violation + 0.5 * t.l2 * violation * violation
