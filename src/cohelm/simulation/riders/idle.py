"""A rider who leaves the stick alone."""

from __future__ import annotations

import numpy as np

from cohelm.config import Model
from cohelm.messages import RiderCommand
from cohelm.simulation.api import RiderView


class Idle:
    """The device is alive and centred."""

    class Parameters(Model):
        """None."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def command(self, view: RiderView, rng: np.random.Generator) -> RiderCommand | None:
        """See :meth:`cohelm.simulation.api.Rider.command`."""
        return RiderCommand(heartbeat=view.time, deflection=np.zeros(2))
