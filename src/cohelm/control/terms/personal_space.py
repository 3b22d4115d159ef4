"""Intrusion into personal spaces, over time."""

from __future__ import annotations

from typing import NamedTuple

from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.people_table import PeopleTable
from cohelm.control.scene import Scene
from cohelm.control.terms.encounter import extent_gradients, gap_gradient, person_extent
from cohelm.control.terms.stage import Encounter, LocalModel, add_square
from cohelm.kernels import INNER, KERNEL, callee

NAME = "personal_space"


class PersonalSpaceCost(Model):
    """Squared share of the intrusion into a personal space; assumed."""

    weight: float = Field(0.8, ge=0.0)
    """Without unit, by probability and age of the prediction."""

    def table(self, scene: Scene) -> PersonalSpaceTable:
        """Weight of a step."""
        return PersonalSpaceTable(self.weight * scene.step)


class PersonalSpaceTable(NamedTuple):
    """Weight of a step."""

    weight: float
    """s."""


@callee(INNER)
def cost(t: PersonalSpaceTable, people: PeopleTable, state: Floats, e: Encounter) -> float:
    """Cost of an encounter, s."""
    if t.weight == 0.0 or e.gap >= people.extent:
        return 0.0
    extent = person_extent(people, state, e)
    share = max(extent - e.gap, 0.0) / extent if extent > 0.0 else 0.0
    return t.weight * share * share


@callee(KERNEL)
def model(
    t: PersonalSpaceTable,
    people: PeopleTable,
    state: Floats,
    e: Encounter,
    k: int,
    share: float,
    q: LocalModel,
) -> None:
    """Add the model of ``share`` of the cost of an encounter at state k."""
    if t.weight == 0.0 or e.gap >= people.extent:
        return
    extent = person_extent(people, state, e)
    if extent <= e.gap:
        return
    gx, gy, ga = gap_gradient(e)
    (lx, ly, la), _ = extent_gradients(people, state, e)
    f = e.gap / (extent * extent)
    add_square(
        q, k, share * t.weight, 1.0 - e.gap / extent,
        f * lx - gx / extent, f * ly - gy / extent, f * la - ga / extent,
    )  # fmt: skip
