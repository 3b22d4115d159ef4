"""Parts that riders share: stick input, base riders, random intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cohelm.arrays import Floats, value
from cohelm.messages import RiderCommand
from cohelm.plugins import Spec, build
from cohelm.simulation.api import Rider, RiderAct, RiderView

BaseRider = Spec
"""Rider whose input is disturbed."""
IDEAL = {"use": "ideal"}


def base_rider(spec: Mapping[str, Any]) -> Rider:
    """Build the rider that ``spec`` names.

    Raises:
        PluginError, ConfigError: see :func:`cohelm.plugins.build`.
    """
    rider: Rider = build("riders", spec, key="base")
    return rider


def deflected(
    view: RiderView, deflection: Sequence[float] | Floats, memory: Any = None
) -> RiderAct:
    """Deflect the stick by (forward, left), clipped to full deflection."""
    clipped = np.clip(np.asarray(deflection, dtype=np.float64), -1.0, 1.0)
    return RiderAct(command=RiderCommand(heartbeat=view.time, deflection=clipped), memory=memory)


def rotated(deflection: Floats, angle: float) -> Floats:
    """Rotate a deflection (2,) by ``angle`` (rad) to the left."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * deflection[0] - s * deflection[1], s * deflection[0] + c * deflection[1]])


def uniform(bounds: tuple[float, float], rng: np.random.Generator) -> float:
    """Draw a number between two bounds."""
    return float(rng.uniform(*bounds))


@value
class RandomInterval:
    """The current or next interval of a disturbance."""

    begin: float
    """s."""
    end: float
    """s."""
    side: float
    """+1: left, −1: right."""

    def contains(self, time: float) -> bool:
        """Check that ``time``, s, lies in the interval."""
        return self.begin <= time < self.end


def next_interval(
    now: float,
    last: RandomInterval | None,
    rng: np.random.Generator,
    *,
    mean_gap: float,
    duration: tuple[float, float],
) -> RandomInterval:
    """Return the last interval until it is over, then a new one.

    Args:
        now: s.
        last: of the last call; None at first.
        rng: three numbers are drawn for a new interval.
        mean_gap: mean time between two intervals, s; exponential distribution.
        duration: lower and upper bound, s; uniform distribution.
    """
    if last is not None and now < last.end:
        return last
    begin = now + float(rng.exponential(mean_gap))
    return RandomInterval(
        begin=begin,
        end=begin + uniform(duration, rng),
        side=1.0 if rng.random() < 0.5 else -1.0,
    )
