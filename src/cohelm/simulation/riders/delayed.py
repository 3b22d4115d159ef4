"""A rider whose hand is late."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import IDEAL, Underlying, steered, underlying

_ROUNDING = 1e-9  # s; times are sums of float steps


class Delayed:
    """What should have been done a while ago; until then the stick is centred."""

    class Parameters(Model):
        """How late, and whose hand."""

        of: Underlying = Field(default_factory=lambda: dict(IDEAL))
        """Who steers."""
        delay: float = Field(0.3, ge=0.0, le=3.0)
        """From seeing to pushing, s (0.3, and 0.6 for the slow: assumed)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.of = underlying(self.parameters.of)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`; the device itself is not late."""
        before: _Memory = memory or _Memory(of=None, times=np.empty(0), meant=np.empty((0, 2)))
        act = self.of.act(view, before.of, rng)
        if act.command is None:
            return act
        times = np.append(before.times, view.time)
        meant = np.vstack([before.meant, act.command.deflection])
        due = int(np.searchsorted(times, view.time - self.parameters.delay + _ROUNDING, "right"))
        push = meant[due - 1] if due else np.zeros(2)
        kept = slice(max(due - 1, 0), None)
        return steered(view, push, _Memory(of=act.memory, times=times[kept], meant=meant[kept]))


@value
class _Memory:
    of: Any
    times: Annotated[Floats, Shape("k")]
    """When it was meant, s."""
    meant: Annotated[Floats, Shape("k 2")]
    """The pushes still to come, after the one that is being made."""
