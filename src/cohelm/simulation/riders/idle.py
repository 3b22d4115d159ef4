"""A rider who leaves the stick alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import steered


class Idle:
    """The device is alive and centred."""

    class Parameters(Model):
        """None."""

    looks = False

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        return steered(view, (0.0, 0.0))
