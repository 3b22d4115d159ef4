"""A rider whose hand trembles."""

from __future__ import annotations

import math
from typing import Any, Self

import numpy as np
from pydantic import Field, model_validator

from cohelm.arrays import value
from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import IDEAL, Underlying, drawn, steered, underlying


class Tremor:
    """A sinusoid upon the stick, along a line of its own; drawn once for a ride.

    The stick is read 20 times a second: a tremor above 10 Hz appears as far below it.
    """

    class Parameters(Model):
        """How fast and how far, and whose hand."""

        of: Underlying = Field(default_factory=lambda: dict(IDEAL))
        """Who steers."""
        frequency: tuple[float, float] = (3.0, 12.0)
        """Range it is drawn from, Hz: Parkinson's disease 3–8, essential tremor 4–12 (Luft et al.,
        Sensors 2019)."""
        amplitude: tuple[float, float] = (0.05, 0.4)
        """Range it is drawn from, share of full deflection (assumed)."""

        @model_validator(mode="after")
        def _in_order(self) -> Self:
            if not 0.0 < self.frequency[0] <= self.frequency[1] <= 20.0:
                raise ValueError("frequency must be [lowest, highest] with 0 < both ≤ 20 Hz")
            if not 0.0 <= self.amplitude[0] <= self.amplitude[1] <= 1.0:
                raise ValueError("amplitude must be [lowest, highest] with 0 ≤ both ≤ 1")
            return self

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.of = underlying(self.parameters.of)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`; a stick that is let go does not shake."""
        shake: _Memory = memory or self._drawn(rng)
        act = self.of.act(view, shake.of, rng)
        if act.command is None:
            return act
        push = act.command.deflection
        if push.any():
            swing = shake.amplitude * math.sin(
                2.0 * math.pi * shake.frequency * view.time + shake.phase
            )
            push = push + swing * np.array([math.cos(shake.along), math.sin(shake.along)])
        kept = _Memory(
            of=act.memory,
            frequency=shake.frequency,
            amplitude=shake.amplitude,
            phase=shake.phase,
            along=shake.along,
        )
        return steered(view, push, kept)

    def _drawn(self, rng: np.random.Generator) -> _Memory:
        p = self.parameters
        return _Memory(
            of=None,
            frequency=drawn(p.frequency, rng),
            amplitude=drawn(p.amplitude, rng),
            phase=drawn((-math.pi, math.pi), rng),
            along=drawn((0.0, math.pi), rng),
        )


@value
class _Memory:
    of: Any
    frequency: float
    amplitude: float
    phase: float
    along: float
    """Direction in which the hand shakes, from forward to the left, rad."""
