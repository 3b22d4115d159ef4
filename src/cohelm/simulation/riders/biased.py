"""A rider who does not see straight ahead where it is."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import IDEAL, Underlying, underlying


class Biased:
    """Takes the chair to be headed elsewhere than it is, and so steers to one side of the way."""

    class Parameters(Model):
        """By how much, and whose hand."""

        of: Underlying = Field(default_factory=lambda: dict(IDEAL))
        """Who steers."""
        offset: float = Field(0.26, ge=-1.0, le=1.0)
        """How far to the left of where they want to go they steer, rad (15°, assumed)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.of = underlying(self.parameters.of)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`; what is about is seen where it is."""
        offset = np.array([0.0, 0.0, self.parameters.offset])
        return self.of.act(replace(view, pose=view.pose - offset), memory, rng)
