"""A rider who steers where they want to go, and does it well."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import steered
from cohelm.simulation.riders.looking import (
    NOTHING,
    Choice,
    Hand,
    Surroundings,
    best_way,
    seen,
    steering,
    wanted_way,
)


class Ideal:
    """Pure pursuit of the wanted route (Coulter 1992), with the stick for a steering wheel.

    Who knows the size of the chair: what stands or walks in the way is steered round where there is
    room for it, slowly where there is little, and else waited for.
    """

    class Parameters(Model):
        """How the rider steers; assumed."""

        lookahead: float = Field(1.0, gt=0.0, le=5.0)
        """Distance along the route of the point steered for, m."""
        forward: float = Field(0.7, gt=0.0, le=1.0)
        """Deflection forward on a straight way, share of full (the chair's greatest speed)."""
        turning: float = Field(1.2, gt=0.0, le=10.0)
        """Deflection aside for each radian of bearing, 1/rad."""
        slowing: float = Field(1.0, gt=0.0, le=5.0)
        """Distance from the goal at which the rider begins to let go, m."""
        arrived: float = Field(0.15, gt=0.0, le=1.0)
        """Distance from the goal at which the stick is let go, m."""
        looks: bool = True
        """Whether the rider minds who and what is in the way."""
        full_speed: float = Field(0.8, gt=0.0, le=5.0)
        """What the rider takes the chair to do at full deflection forward, m/s …"""
        full_turn: float = Field(1.2, gt=0.0, le=10.0)
        """… and aside, rad/s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p = self.parameters
        x, y, heading = view.pose
        remaining = math.hypot(view.goal[0] - x, view.goal[1] - y)
        if remaining <= p.arrived:
            return steered(view, (0.0, 0.0))
        before: _Memory | None = memory
        things = _about(view, before) if p.looks else NOTHING
        easing = min(remaining / p.slowing, 1.0)
        if not p.looks or not (len(things.points) or len(view.people)):
            aim = ahead_on(view.route, x, y, p.lookahead) if len(view.route) else view.goal
            bearing = math.remainder(math.atan2(aim[1] - y, aim[0] - x) - heading, 2.0 * math.pi)
            kept = _Memory(time=view.time, twist=view.twist, things=things, share=1.0)
            return self._pushed(view, bearing, easing, kept)
        return self._round(view, things, easing, before)

    def _round(
        self, view: RiderView, things: Surroundings, easing: float, before: _Memory | None
    ) -> RiderAct:
        """The push where something is about."""
        p, way = self.parameters, wanted_way(view)
        hand = Hand(
            forward=p.forward,
            turning=p.turning,
            lookahead=p.lookahead,
            full=np.array([p.full_speed, p.full_turn]),
        )
        choice = best_way(
            view,
            way,
            things,
            hand=hand,
            outline=view.outline if len(view.outline) else _CHAIR,
            before=before.choice if before else None,
            look=before.looks if before else 0,
        )
        aside, share = steering(way, choice, p.lookahead) if choice else (0.0, 0.0)
        share = min(share, before.share + _RISES if before else 1.0)
        kept = _Memory(
            time=view.time,
            twist=view.twist,
            things=things,
            share=share,
            choice=choice or (before.choice if before else None),
            looks=before.looks + 1 if before else 1,
        )
        return self._pushed(view, aside, share * easing, kept)

    def _pushed(self, view: RiderView, bearing: float, share: float, kept: _Memory) -> RiderAct:
        p = self.parameters
        forward = p.forward * share * max(math.cos(bearing), 0.0)
        return steered(view, (forward, min(max(p.turning * bearing, -1.0), 1.0)), kept)


@value
class _Memory:
    time: float
    """Of the last call, s."""
    twist: Annotated[Floats, Shape("3")]
    things: Surroundings
    share: float
    """Of the deflection forward."""
    choice: Choice | None = None
    """The way beside the wanted one that was chosen last."""
    looks: int = 0
    """How often ways have been looked at."""


_RISES = 0.1
"""By how much more of the speed is pushed from one call to the next."""
_CHAIR = np.array([[0.65, 0.305], [-0.46, 0.305], [-0.46, -0.305], [0.65, -0.305]])
"""Outline of a chair of which the view says nothing, m: of a usual powered one."""


def _about(view: RiderView, before: _Memory | None) -> Surroundings:
    """What is seen and remembered, where the chair is felt to have gone since the last call."""
    if before is None:
        return seen(view, NOTHING, np.zeros(3))
    gone = 0.5 * (before.twist + view.twist) * (view.time - before.time)
    half = gone[2] / 2.0
    x = gone[0] * math.cos(half) - gone[1] * math.sin(half)
    y = gone[0] * math.sin(half) + gone[1] * math.cos(half)
    return seen(view, before.things, np.array([x, y, gone[2]]))


def ahead_on(route: Floats, x: float, y: float, lookahead: float) -> Floats:
    """The point (2,) of a route (k, 2) that lies ``lookahead`` beyond the one nearest to (x, y)."""
    s = arc_length(route)
    at, _ = nearest_on_polyline(route, x, y)
    at += lookahead
    return np.array([np.interp(at, s, route[:, 0]), np.interp(at, s, route[:, 1])])
