"""A rider who lets the chair drive, as long as it goes where they want."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import value
from cohelm.config import Model
from cohelm.geometry import nearest_on_polyline
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import IDEAL, Underlying, steered, underlying
from cohelm.simulation.riders.ideal import ahead_on

_MOVES = 0.1  # m/s


class Reluctant:
    """Takes the stick when the chair goes astray, or stands too long; lets go when it is right."""

    class Parameters(Model):
        """What is astray, and whose hand; assumed."""

        of: Underlying = Field(default_factory=lambda: dict(IDEAL))
        """Who steers then."""
        away: float = Field(0.8, gt=0.0, le=10.0)
        """Distance from the wanted route beyond which the chair is astray, m …"""
        angle: float = Field(0.8, gt=0.0, le=3.15)
        """… or driving this far off the wanted direction, rad …"""
        suffers: float = Field(1.0, ge=0.0, le=30.0)
        """… for this long, s."""
        waits: float = Field(5.0, ge=0.0, le=300.0)
        """How long a chair may stand short of the goal, and how long they drive it then, s."""
        content: float = Field(0.5, gt=0.0, le=1.0)
        """The stick is let go when distance and angle are within this share of those."""
        lookahead: float = Field(1.0, gt=0.0, le=5.0)
        """How far ahead on the route the wanted direction points, m."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.of = underlying(self.parameters.of)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p, now = self.parameters, view.time
        before: _Memory = memory or _Memory(
            of=None, right=now, moved=now, steers=False, until=-math.inf
        )
        act = self.of.act(view, before.of, rng)
        if act.command is None:
            return act
        moves = math.hypot(view.twist[0], view.twist[1]) >= _MOVES
        astray = self._astray(view, moves=moves)
        right = now if astray <= (p.content if before.steers else 1.0) else before.right
        moved = now if moves else before.moved
        stood = now - moved > p.waits
        until = now + p.waits if stood else before.until
        if before.steers:
            steers = now < until or not (moves and right == now)
        else:
            steers = stood or now - right > p.suffers
        push = act.command.deflection if steers else np.zeros(2)
        kept = _Memory(of=act.memory, right=right, moved=moved, steers=steers, until=until)
        return steered(view, push, kept)

    def _astray(self, view: RiderView, *, moves: bool) -> float:
        """How far the chair is off the wanted way; 1 is as far as may be."""
        p, (x, y, heading) = self.parameters, view.pose
        away, aim = 0.0, view.goal
        if len(view.route):
            _, away = nearest_on_polyline(view.route, x, y)
            aim = ahead_on(view.route, x, y, p.lookahead)
        if not moves or math.hypot(view.goal[0] - x, view.goal[1] - y) < p.lookahead:
            return away / p.away
        travels = heading + (math.pi if view.twist[0] < 0.0 else 0.0)
        off = math.remainder(math.atan2(aim[1] - y, aim[0] - x) - travels, 2.0 * math.pi)
        return max(away / p.away, abs(off) / p.angle)


@value
class _Memory:
    of: Any
    right: float
    """When the chair last went the wanted way, s."""
    moved: float
    """When it last moved, s."""
    steers: bool
    until: float
    """Until when they steer a chair that had stood, however right it goes, s."""
