"""Spells that come over somebody now and then."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import value
from cohelm.simulation.riders.hand import drawn


@value
class Spell:
    """When the present one, or the next, begins and ends, and to which side it goes."""

    begins: float
    """s."""
    ends: float
    """s."""
    side: float
    """+1: left, −1: right."""

    def holds(self, now: float) -> bool:
        """Whether it is on."""
        return self.begins <= now < self.ends


def spell(
    now: float,
    last: Spell | None,
    rng: np.random.Generator,
    *,
    every: float,
    lasts: tuple[float, float],
) -> Spell:
    """The spell to reckon with now: the last one until it is over, then a new one.

    Args:
        now: s.
        last: the last call's; None at first.
        rng: three numbers are drawn where a new one is needed.
        every: mean time from the end of one to the beginning of the next, s; exponential.
        lasts: least and greatest length, s.
    """
    if last is not None and now < last.ends:
        return last
    begins = now + float(rng.exponential(every))
    return Spell(
        begins=begins,
        ends=begins + drawn(lasts, rng),
        side=1.0 if rng.random() < 0.5 else -1.0,
    )
