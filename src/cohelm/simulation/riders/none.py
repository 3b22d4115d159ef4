"""No device at all."""

from __future__ import annotations

import numpy as np

from cohelm.config import Model
from cohelm.messages import RiderCommand
from cohelm.simulation.api import RiderView


class NoRider:
    """The chair has no device: nothing is ever sent, and none is missed."""

    class Parameters(Model):
        """None."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def command(self, view: RiderView, rng: np.random.Generator) -> RiderCommand | None:
        """See :meth:`cohelm.simulation.api.Rider.command`."""
        return None
