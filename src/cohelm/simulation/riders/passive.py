"""Riders who hardly steer: no device, an idle stick, a single push."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from pydantic import Field

from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.rider_input import deflected


class NoRider:
    """A chair without a device: no message is sent, and none is expected."""

    class Parameters(Model):
        """None."""

    needs_view = False

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        return RiderAct(command=None)


class Idle:
    """A device that is alive and centred."""

    class Parameters(Model):
        """None."""

    needs_view = False

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        return deflected(view, (0.0, 0.0))


class Nudge:
    """A centred stick with a single push, at a given time or near a given place."""

    class Parameters(Model):
        """Time, place and size of the push; assumed."""

        at: float = Field(5.0, ge=0.0)
        """Start of the push, s; ignored if ``near`` is given."""
        duration: float = Field(1.5, gt=0.0)
        """Duration of the push, s; ignored if ``near`` is given."""
        near: tuple[float, float] | None = None
        """Push while approaching this place instead, (x, y) in the map frame, m."""
        within: float = Field(2.5, gt=0.0)
        """Distance from ``near`` at which the push begins, m …"""
        until: float = Field(1.0, ge=0.0)
        """… and at which it ends, or when the place is no longer ahead, m."""
        side: Literal["left", "right"] = "left"
        """Side of the push."""
        forward: float = Field(0.8, ge=-1.0, le=1.0)
        """Forward deflection, share of full."""
        lateral: float = Field(0.6, ge=0.0, le=1.0)
        """Lateral deflection, share of full."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p = self.parameters
        left = p.lateral if p.side == "left" else -p.lateral
        return deflected(view, (p.forward, left) if self._is_active(view) else (0.0, 0.0))

    def _is_active(self, view: RiderView) -> bool:
        p = self.parameters
        if p.near is None:
            return p.at - 1e-9 <= view.time < p.at + p.duration - 1e-9
        x, y, heading = view.pose
        dx, dy = p.near[0] - x, p.near[1] - y
        ahead = dx * math.cos(heading) + dy * math.sin(heading) > 0.0
        return ahead and p.until <= math.hypot(dx, dy) <= p.within
