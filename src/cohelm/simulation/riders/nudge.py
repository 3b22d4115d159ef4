"""A rider who once pushes the stick to one side."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from pydantic import Field

from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import steered


class Nudge:
    """Centred, but for one push: at a moment, or on the way towards a place."""

    class Parameters(Model):
        """When, where to and how hard; assumed."""

        at: float = Field(5.0, ge=0.0)
        """When the push begins, s; of no account where ``near`` is given."""
        duration: float = Field(1.5, gt=0.0)
        """How long it lasts, s; of no account where ``near`` is given."""
        near: tuple[float, float] | None = None
        """Push on the way towards this place instead, (x, y) in the map frame, m."""
        within: float = Field(2.5, gt=0.0)
        """The push begins at this distance from ``near``, m …"""
        until: float = Field(1.0, ge=0.0)
        """… and ends at this one, or when the place is no longer ahead, m."""
        side: Literal["left", "right"] = "left"
        """Where the push goes."""
        forward: float = Field(0.8, ge=-1.0, le=1.0)
        """Deflection forward, share of full."""
        aside: float = Field(0.6, ge=0.0, le=1.0)
        """Deflection to the side, share of full."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p = self.parameters
        left = p.aside if p.side == "left" else -p.aside
        deflection = (p.forward, left) if self._pushes(view) else (0.0, 0.0)
        return steered(view, deflection)

    def _pushes(self, view: RiderView) -> bool:
        p = self.parameters
        if p.near is None:
            return p.at - 1e-9 <= view.time < p.at + p.duration - 1e-9
        x, y, heading = view.pose
        dx, dy = p.near[0] - x, p.near[1] - y
        ahead = dx * math.cos(heading) + dy * math.sin(heading) > 0.0
        return ahead and p.until <= math.hypot(dx, dy) <= p.within
