"""Yielding: the rider's way wins where the rider persistently steers otherwise than the chair.

The chair's own plan reports the angle to the motion that the stick asks for.
Its low-pass is the disagreement: a tremor or a short push leaves nothing of it, a rider who goes
round something that the chair does not know does. Above a threshold the chair yields, until both
agree again or the rider has let go for a while.
"""

from __future__ import annotations

import math

from pydantic import Field

from cohelm.arrays import value
from cohelm.config import Model
from cohelm.sharing.intent import SteeringParameters

_LARGEST = 0.5
"""Largest angle that counts, rad: a turn on the spot says no more than a clear turn."""
_LONGEST_GAP = 0.5
"""Time between two calls up to which the disagreement is continued, s."""


class YieldingParameters(Model):
    """Persistence of a disagreement after which the chair yields; assumed."""

    use: bool = True
    """False: the chair never yields, and the rider has the weight η only."""
    begin: float = Field(0.1, gt=0.0, le=1.0)
    """Disagreement from which the chair yields, rad …"""
    end: float = Field(0.05, ge=0.0, le=1.0)
    """… and down to which it still does, rad."""
    docking_begin: float = Field(0.3, gt=0.0, le=1.0)
    """Disagreement from which it yields at the goal, rad; in between it grows with η's fading."""
    time_constant: float = Field(1.0, gt=0.0, le=30.0)
    """Time constant of the low-pass while the stick is deflected, s …"""
    release_time: float = Field(3.0, gt=0.0, le=60.0)
    """… and of its decay once it is centred, s."""
    wall_gap: float = Field(0.02, ge=0.0, le=0.5)
    """Gap to walls from which the rider is helped while the chair yields, m: that of the
    verification. At a larger one the chair turns away from walls that it sees, towards things that
    it does not."""


@value
class YieldingState:
    """Memory of the disagreement between rider and chair."""

    time: float
    """s."""
    disagreement: float = 0.0
    """Angle from the rider's motion to the chair's own choice after the low-pass, rad."""
    yields: bool = False
    """The chair yields."""
    measured: float = math.nan
    """Angle in this tick, for the next call, rad; NaN: not known."""


def update_yielding(
    time: float,
    measured: float,
    memory: YieldingState | None,
    parameters: YieldingParameters,
    *,
    deflected: bool,
    stands: bool,
    docking: float,
) -> YieldingState:
    """Update the disagreement.

    Args:
        time: s.
        measured: angle from the rider's motion to the chair's own choice, rad; NaN: not known.
        memory: result of the last call, None at first.
        parameters: thresholds and time constants.
        deflected: False for a centred stick, which disagrees with nothing.
        stands: the chair stands; a rider whose way leads nowhere gets help sooner.
        docking: share to which η has faded near the goal, 1 far from it.
    """
    p = parameters
    if not p.use or memory is None or not 0.0 <= time - memory.time <= _LONGEST_GAP:
        return YieldingState(time=time)
    elapsed, before = time - memory.time, memory.disagreement
    if not deflected or math.isnan(measured):
        fade = p.time_constant if deflected and stands else p.release_time
        now = before * math.exp(-elapsed / fade)
    else:
        clipped = min(max(measured, -_LARGEST), _LARGEST)
        now = before + (1.0 - math.exp(-elapsed / p.time_constant)) * (clipped - before)
    begin = p.begin + max(p.docking_begin - p.begin, 0.0) * (1.0 - docking)
    limit = p.end if memory.yields else begin
    return YieldingState(time=time, disagreement=now, yields=abs(now) > limit)


def with_literal_stick(steering: SteeringParameters, p: YieldingParameters) -> SteeringParameters:
    """Parameters of steering help while the chair yields: the stick is taken literally.

    The chair was wrong about the rider's destination, so no door or passage attracts it, every
    stick counts as a steady one, and walls turn the chair aside as late as verification allows.
    """
    return steering.model_copy(
        update={
            "attraction": 0.0,
            "clear_time": steering.steady_clear_time,
            "wall_gap": min(p.wall_gap, steering.wall_gap),
        }
    )
