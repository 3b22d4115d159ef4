"""A rider who steers where they want to go, and does it well."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import steered
from cohelm.simulation.riders.looking import free_way


class Ideal:
    """Pure pursuit of the wanted route (Coulter 1992), with the stick for a steering wheel.

    What stands or walks in the way is steered round where there is room, and else waited for.
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
        width: float = Field(0.85, gt=0.0, le=3.0)
        """Of the way that the rider keeps free, m."""
        far: float = Field(2.5, gt=0.0, le=10.0)
        """How far ahead it should be free, m."""
        near: float = Field(0.9, gt=0.0, le=5.0)
        """At this distance from what is in the way the rider stands, m from the chair's origin."""
        pace: float = Field(0.5, gt=0.0, le=3.0)
        """At which the rider reckons to get on at least, m/s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p = self.parameters
        x, y, heading = view.pose
        remaining = math.hypot(view.goal[0] - x, view.goal[1] - y)
        if remaining <= p.arrived:
            return steered(view, (0.0, 0.0))
        aim = ahead_on(view.route, x, y, p.lookahead) if len(view.route) else view.goal
        dx, dy = aim[0] - x, aim[1] - y
        bearing = math.remainder(math.atan2(dy, dx) - heading, 2.0 * math.pi)
        share = 1.0
        if p.looks:
            far = min(p.far, max(remaining, p.near))
            bearing, free = free_way(
                view, bearing, width=p.width, far=far, speed=max(view.twist[0], p.pace)
            )
            if free < far:
                share = min(max((free - p.near) / (p.far - p.near), 0.0), 1.0)
        forward = p.forward * share * max(math.cos(bearing), 0.0) * min(remaining / p.slowing, 1.0)
        left = min(max(p.turning * bearing, -1.0), 1.0)
        return steered(view, (forward, left))


def ahead_on(route: Floats, x: float, y: float, lookahead: float) -> Floats:
    """The point (2,) of a route (k, 2) that lies ``lookahead`` beyond the one nearest to (x, y)."""
    s = arc_length(route)
    at, _ = nearest_on_polyline(route, x, y)
    at += lookahead
    return np.array([np.interp(at, s, route[:, 0]), np.interp(at, s, route[:, 1])])
