"""Help towards a believed destination: a bounded addition to the rider's turn.

It grows with the certainty of the belief, and is nothing at once where the stick turns the other
way, is centred or pulled back. It never sets a destination.
"""

from __future__ import annotations

from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model


class BeliefHelpParameters(Model):
    """Bounds of the help; assumed. It is off by default."""

    use: bool = False
    """Help a rider without a destination towards the place that is believed most."""
    begin: float = Field(0.7, ge=0.5, lt=1.0)
    """Probability from which the chair helps …"""
    full: float = Field(0.95, gt=0.5, le=1.0)
    """… and from which it does so fully."""
    gain: float = Field(0.6, gt=0.0, le=5.0)
    """Turn per angle to the way, full deflections per rad."""
    largest: float = Field(0.3, gt=0.0, le=1.0)
    """Largest turn that the chair makes by itself, share of full deflection."""
    opposed: float = Field(0.03, ge=0.0, le=1.0)
    """Deflection to the other side from which the rider disagrees, share of full."""


def helped_deflection(
    deflection: Floats, certainty: float, angle: float, parameters: BeliefHelpParameters
) -> Floats:
    """The deflection (2,) with the help; the rider's own where there is none.

    Args:
        deflection: (forward, left) of the rider.
        certainty: probability of the believed place.
        angle: from the chair's heading to the way there, rad.
        parameters: bounds.
    """
    p, (forward, left) = parameters, deflection.tolist()
    weight = min(max((certainty - p.begin) / max(p.full - p.begin, 1e-9), 0.0), 1.0)
    if not p.use or forward <= 0.0 or weight == 0.0:
        return deflection
    turn = min(max(p.gain * angle, -p.largest), p.largest) * weight
    opposed = left * turn < 0.0 and abs(left) > p.opposed
    if opposed or abs(left) >= abs(turn):
        return deflection
    out = deflection.copy()
    out[1] = turn
    return out
