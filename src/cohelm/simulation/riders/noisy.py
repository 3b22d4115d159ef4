"""A rider whose hand now and then jerks."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import Field

from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import IDEAL, Underlying, steered, underlying


class Noisy:
    """Now and then one axis of the stick is anywhere; after the pilots of Reddy et al. (2018)."""

    class Parameters(Model):
        """How often, and whose hand."""

        of: Underlying = Field(default_factory=lambda: dict(IDEAL))
        """Who steers."""
        jerks: float = Field(0.15, ge=0.0, le=1.0)
        """Probability that one axis of a command is random, for each of 20 a second (0.15 in
        programs after Reddy, Dragan and Levine, 2018)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.of = underlying(self.parameters.of)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`; a stick that is let go does not jerk."""
        act = self.of.act(view, memory, rng)
        jerks, axis, anywhere = rng.random(), int(rng.integers(2)), rng.uniform(-1.0, 1.0)
        if act.command is None or not act.command.deflection.any():
            return act
        push = act.command.deflection.copy()
        if jerks < self.parameters.jerks:
            push[axis] = anywhere
        return steered(view, push, act.memory)
