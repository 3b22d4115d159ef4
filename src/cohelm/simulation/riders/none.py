"""No device at all."""

from __future__ import annotations

from typing import Any

import numpy as np

from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView


class NoRider:
    """The chair has no device: nothing is ever sent, and none is missed."""

    class Parameters(Model):
        """None."""

    looks = False

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        return RiderAct(command=None)
