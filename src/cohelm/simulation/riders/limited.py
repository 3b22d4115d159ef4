"""Riders whose device or attention is limited: eight directions, spells without a look ahead."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import replace, value
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.disturbances import Disturbance, IntervalDisturbance
from cohelm.simulation.riders.rider_input import (
    RandomInterval,
    base_rider,
    deflected,
    next_interval,
)

_EIGHTH = math.pi / 4.0


class EightDirections:
    """Device with eight directions and one deflection, as a switched joystick."""

    class Parameters(Disturbance):
        """Deflection and base rider; assumed."""

        deflection: float = Field(0.5, gt=0.0, le=1.0)
        """Deflection in the chosen direction, share of full."""
        threshold: float = Field(0.1, ge=0.0, lt=1.0)
        """Deflection of the base rider below which the device is released, share of full."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.base = base_rider(self.parameters.base)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p = self.parameters
        act = self.base.act(view, memory, rng)
        if act.command is None:
            return act
        forward, left = act.command.deflection
        if math.hypot(forward, left) < p.threshold:
            return deflected(view, (0.0, 0.0), act.memory)
        angle = _EIGHTH * round(math.atan2(left, forward) / _EIGHTH)
        chosen = (p.deflection * math.cos(angle), p.deflection * math.sin(angle))
        return deflected(view, chosen, act.memory)


class LookingAway:
    """A rider who from time to time sees no people, and drives on along the route."""

    class Parameters(IntervalDisturbance):
        """Frequency, duration and base rider; assumed."""

        mean_gap: float = Field(3.0, gt=0.0, le=600.0)
        duration: tuple[float, float] = (3.0, 6.0)

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.base = base_rider(self.parameters.base)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`; walls and objects are seen throughout."""
        p = self.parameters
        last: _LookMemory | None = memory
        interval = next_interval(
            view.time,
            last.interval if last else None,
            rng,
            mean_gap=p.mean_gap,
            duration=p.duration,
        )
        if interval.contains(view.time):
            view = replace(view, people=np.empty((0, 5)))
        act = self.base.act(view, last.base if last else None, rng)
        return replace(act, memory=_LookMemory(base=act.memory, interval=interval))


@value
class _LookMemory:
    base: Any
    interval: RandomInterval
