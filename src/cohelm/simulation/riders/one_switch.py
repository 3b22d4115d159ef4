"""A rider with one button: four directions light up in turn, and the lit one is driven."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, value
from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import IDEAL, Underlying, steered, underlying

DIRECTIONS = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
"""In the order in which they light up: forward, left, back, right."""
_FORWARD, _LEFT, _BACK, _RIGHT = range(4)
_STOP = -1
_ROUNDING = 1e-9  # s; times are sums of float steps


class OneSwitch:
    """Waits for the direction, presses the button, and holds it for as long as it is right.

    While the button is held the lit direction is driven; when it is let go the chair stands and the
    scan begins again at forward.
    """

    class Parameters(Model):
        """The scan, the hand and what it would do with a stick."""

        of: Underlying = Field(default_factory=lambda: {**IDEAL, "slowing": 0.2})
        """Who would steer, if there were a stick; a button does not slow down before the goal."""
        scan: float = Field(1.0, gt=0.0, le=10.0)
        """How long each direction is lit, s: the time to press over 0.65 (Simpson, Koester and
        LoPresti, 2006)."""
        reaction: float = Field(0.65, ge=0.0, le=5.0)
        """From seeing to pressing or letting go, s (assumed)."""
        drive: float = Field(0.6, gt=0.0, le=1.0)
        """Deflection that forward and back mean, share of full (assumed)."""
        spin: float = Field(0.4, gt=0.0, le=1.0)
        """Deflection that left and right mean, share of full (assumed)."""
        off: float = Field(0.5, gt=0.0, le=2.0)
        """A stick this far off forward would mean to turn first, rad (assumed)."""
        on: float = Field(0.25, ge=0.0, le=1.0)
        """A turn ends when it is no more than this, rad (assumed)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.of = underlying(self.parameters.of)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p, now = self.parameters, view.time
        before: _Memory = memory or _Memory(
            of=None, scanned=now, held=_STOP, wanted=_STOP, since=now, right=now
        )
        act = self.of.act(_when_pressed(view, p.reaction), before.of, rng)
        if act.command is None:
            return act
        wanted = self._wanted(act.command.deflection, before.wanted)
        since = before.since if wanted == before.wanted else now
        held, scanned = before.held, before.scanned
        right = now if held == wanted else before.right
        lit, lit_since = self._lit(now - scanned)
        may = now - max(since, scanned + lit_since) >= p.reaction - _ROUNDING
        if held == _STOP and wanted == lit and may:
            held, right = wanted, now
        elif held != _STOP and now - right > p.reaction + _ROUNDING:
            held, scanned = _STOP, now
        push = np.zeros(2) if held == _STOP else DIRECTIONS[held] * np.array([p.drive, p.spin])
        kept = _Memory(
            of=act.memory, scanned=scanned, held=held, wanted=wanted, since=since, right=right
        )
        return steered(view, push, kept)

    def _lit(self, scanning: float) -> tuple[int, float]:
        """The direction that is lit, and after how much of the scan it was, s."""
        count = math.floor((scanning + _ROUNDING) / self.parameters.scan)
        return count % 4, count * self.parameters.scan

    def _wanted(self, push: Floats, before: int) -> int:
        """Which direction comes nearest to what a stick would do."""
        if not push.any():
            return _STOP
        p, aside = self.parameters, math.atan2(push[1], push[0])
        if abs(aside) > math.pi - p.off:
            return _BACK
        side = _LEFT if aside > 0.0 else _RIGHT
        turns_on = before == side and abs(aside) > p.on
        return side if turns_on or abs(aside) > p.off else _FORWARD


def _when_pressed(view: RiderView, reaction: float) -> RiderView:
    """Where the chair will be when the hand has done what is wanted now, as practice tells."""
    x, y, heading = view.pose
    gone, half = view.twist[0] * reaction, heading + view.twist[2] * reaction / 2.0
    pose = np.array(
        [x + gone * math.cos(half), y + gone * math.sin(half), heading + view.twist[2] * reaction]
    )
    return replace(view, pose=pose)


@value
class _Memory:
    of: Any
    scanned: float
    """When the scan began, s."""
    held: int
    """The direction that is driven."""
    wanted: int
    since: float
    """Since when it is wanted, s."""
    right: float
    """When the driven direction was last the wanted one, s."""
