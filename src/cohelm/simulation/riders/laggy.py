"""A rider whose hand often stays where it was."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import IDEAL, Underlying, steered, underlying


class Laggy:
    """The last command again, more often than not; after the pilots of Reddy et al. (2018)."""

    class Parameters(Model):
        """How often, and whose hand."""

        of: Underlying = Field(default_factory=lambda: dict(IDEAL))
        """Who steers."""
        repeats: float = Field(0.8, ge=0.0, lt=1.0)
        """Probability that a command is the last one again, for each of 20 a second (0.8 and 0.85
        in programs after Reddy, Dragan and Levine, 2018)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.of = underlying(self.parameters.of)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        before: _Memory | None = memory
        act = self.of.act(view, before.of if before else None, rng)
        repeats = rng.random() < self.parameters.repeats
        if act.command is None:
            return act
        stays = before is not None and repeats
        push = before.sent if before is not None and stays else act.command.deflection
        return steered(view, push, _Memory(of=act.memory, sent=push))


@value
class _Memory:
    of: Any
    sent: Annotated[Floats, Shape("2")]
