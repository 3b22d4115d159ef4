"""A rider whose device falls silent now and then."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from pydantic import Field, model_validator

from cohelm.arrays import value
from cohelm.config import Model
from cohelm.messages import RiderCommand
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import IDEAL, Underlying, underlying
from cohelm.simulation.riders.spells import Spell, spell


class Dropout:
    """While the device is silent, the last that was heard of it is all there is."""

    class Parameters(Model):
        """How often and how long, and whose hand; assumed."""

        of: Underlying = Field(default_factory=lambda: dict(IDEAL))
        """Who steers."""
        every: float = Field(8.0, gt=0.0, le=600.0)
        """Mean time from one silence to the next, s."""
        lasts: tuple[float, float] = (0.2, 2.0)
        """Range of their lengths, s."""

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
        silence = spell(
            view.time, before.silence if before else None, rng, every=p.every, lasts=p.lasts
        )
        if act.command is None:
            return act
        heard = act.command
        if before is not None and silence.holds(view.time):
            heard = before.heard
        kept = _Memory(of=act.memory, silence=silence, heard=heard)
        return RiderAct(command=heard, memory=kept)


@value
class _Memory:
    of: Any
    silence: Spell
    heard: RiderCommand
