"""Contract of a fault: an effect on the observation, the command or the wheels."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cohelm.arrays import value
from cohelm.messages import Observation, Scan
from cohelm.simulation.faults.fault import Fault


@value
class FaultMemory:
    """Sound input of the recent past, for faults that repeat or delay it."""

    last: Observation | None = None
    """The observation as it was delivered last."""
    recent: tuple[Observation, ...] = ()
    """Sound observations of the last ``HISTORY`` seconds, oldest first."""
    scans: tuple[Scan, ...] = ()
    """The newest sound scans."""
    held: tuple[Observation | None, ...] = ()
    """For each fault, the last sound observation before its onset."""
    held_scans: tuple[tuple[Scan, ...], ...] = ()
    """For each fault, the newest sound scans before its onset."""


@dataclass(frozen=True, slots=True)
class FaultInput:
    """Everything that an effect may use, beside the observation."""

    fault: Fault
    time: float
    """True time, s."""
    last: Observation | None
    """The observation as it was delivered last; None at first, when every sender has sent once."""
    held: Observation
    """The last sound observation before the onset, with the last cloud of each sensor."""
    held_scans: tuple[Scan, ...]
    """The newest sound scans before the onset."""
    recent: tuple[Observation, ...]
    """Sound observations of the last seconds and this one, oldest first."""
    rng: np.random.Generator
    """Goes on from tick to tick."""
    pattern: np.random.Generator
    """The same numbers at every tick."""

    @property
    def size(self) -> float:
        """Magnitude of the fault."""
        return self.fault.size

    @property
    def since(self) -> float:
        """Time since the onset, s."""
        return self.fault.since(self.time)


Effect = Callable[[Observation, FaultInput], Observation]

UNBOUNDED = (-math.inf, math.inf)
SHARE = (0.0, 1.0)
POSITIVE = (0.0, math.inf)


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultKind:
    """One kind of fault; ``effect`` is None where it acts on the chair instead of its senses."""

    text: str
    """Cause, for tables."""
    effect: Effect | None = None
    unit: str = ""
    """Unit of the magnitude; empty: it has none."""
    typical: float = 1.0
    bounds: tuple[float, float] = UNBOUNDED
    intensities: tuple[float, ...] = ()
    """Magnitudes of a benchmark; empty: the typical one alone."""

    def refusal(self, name: str, magnitude: float) -> str:
        """Reason why the kind of this name does not take a magnitude; empty: it does."""
        if not self.unit:
            return f"{name} has no magnitude, got {magnitude:g}"
        low, high = self.bounds
        if low <= magnitude <= high:
            return ""
        bounds = f"be at least {low:g}" if math.isinf(high) else f"lie in [{low:g}, {high:g}]"
        return f"magnitude of {name} must {bounds} {self.unit}, got {magnitude:g}"
