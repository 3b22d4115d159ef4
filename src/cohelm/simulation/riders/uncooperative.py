"""A rider who now and then steers away from the way, whatever the chair does."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from pydantic import Field, model_validator

from cohelm.arrays import value
from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import IDEAL, Underlying, steered, turned, underlying
from cohelm.simulation.riders.spells import Spell, spell


class Uncooperative:
    """In spells, the stick goes to one side of where it should.

    One who wants to go elsewhere altogether is any rider with a ``rider_goal`` of their own.
    """

    class Parameters(Model):
        """How often, how long and how far, and whose hand; assumed."""

        of: Underlying = Field(default_factory=lambda: dict(IDEAL))
        """Who steers in between."""
        every: float = Field(6.0, gt=0.0, le=600.0)
        """Mean time from one spell to the next, s."""
        lasts: tuple[float, float] = (1.0, 3.0)
        """Range of their lengths, s."""
        turn: float = Field(1.2, ge=0.0, le=3.15)
        """How far aside of the right push the stick is held, rad."""

        @model_validator(mode="after")
        def _in_order(self) -> Self:
            if not 0.0 < self.lasts[0] <= self.lasts[1] <= 60.0:
                raise ValueError("lasts must be [shortest, longest] with 0 < both ≤ 60 s")
            return self

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.of = underlying(self.parameters.of)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p = self.parameters
        before: _Memory | None = memory
        act = self.of.act(view, before.of if before else None, rng)
        mood = spell(view.time, before.mood if before else None, rng, every=p.every, lasts=p.lasts)
        if act.command is None:
            return act
        push = act.command.deflection
        if mood.holds(view.time):
            push = turned(push, mood.side * p.turn)
        return steered(view, push, _Memory(of=act.memory, mood=mood))


@value
class _Memory:
    of: Any
    mood: Spell
