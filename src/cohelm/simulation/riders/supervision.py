"""Riders who let the chair drive and intervene: off the desired route, or for people."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Booleans, Floats, value
from cohelm.config import Model
from cohelm.geometry import nearest_on_polyline
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.ideal import lookahead_point
from cohelm.simulation.riders.rider_input import IDEAL, BaseRider, base_rider, deflected

_MOVING = 0.1  # m/s
_WALKING = 0.2
"""Speed below which a person stands, m/s."""
_MIN_SPEED = 0.3
"""Speed of the chair that is assumed while it stands, m/s."""


class Reluctant:
    """Steers if the chair leaves the desired route or stands too long, and releases the stick."""

    class Parameters(Model):
        """Thresholds and base rider; assumed."""

        base: BaseRider = Field(default_factory=lambda: dict(IDEAL))
        """Base rider."""
        max_distance: float = Field(0.8, gt=0.0, le=10.0)
        """Tolerated distance from the desired route, m …"""
        max_angle: float = Field(0.8, gt=0.0, le=3.15)
        """… and angle between motion and desired direction, rad …"""
        tolerance_time: float = Field(1.0, ge=0.0, le=30.0)
        """… which may be exceeded for this time, s."""
        standstill_time: float = Field(5.0, ge=0.0, le=300.0)
        """Tolerated standstill before the goal, and minimum time of steering after it, s."""
        release_share: float = Field(0.5, gt=0.0, le=1.0)
        """Share of the tolerances below which the stick is released."""
        lookahead: float = Field(1.0, gt=0.0, le=5.0)
        """Distance along the route to the point that gives the desired direction, m."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.base = base_rider(self.parameters.base)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p, now = self.parameters, view.time
        last: _Memory = memory or _Memory(
            base=None, content_at=now, moved_at=now, steers=False, until=-math.inf
        )
        act = self.base.act(view, last.base, rng)
        if act.command is None:
            return act
        moves = math.hypot(view.twist[0], view.twist[1]) >= _MOVING
        deviation = self._deviation(view, moves=moves)
        content = deviation <= (p.release_share if last.steers else 1.0)
        content_at = now if content else last.content_at
        moved_at = now if moves else last.moved_at
        stood = now - moved_at > p.standstill_time
        until = now + p.standstill_time if stood else last.until
        if last.steers:
            steers = now < until or not (moves and content_at == now)
        else:
            steers = stood or now - content_at > p.tolerance_time
        deflection = act.command.deflection if steers else np.zeros(2)
        kept = _Memory(
            base=act.memory, content_at=content_at, moved_at=moved_at, steers=steers, until=until
        )
        return deflected(view, deflection, kept)

    def _deviation(self, view: RiderView, *, moves: bool) -> float:
        """Deviation from the desired route; 1 is the tolerance."""
        p, (x, y, heading) = self.parameters, view.pose
        distance, aim = 0.0, view.goal
        if len(view.route):
            _, distance = nearest_on_polyline(view.route, x, y)
            aim = lookahead_point(view.route, x, y, p.lookahead)
        if not moves or math.hypot(view.goal[0] - x, view.goal[1] - y) < p.lookahead:
            return distance / p.max_distance
        direction = heading + (math.pi if view.twist[0] < 0.0 else 0.0)
        angle = math.remainder(math.atan2(aim[1] - y, aim[0] - x) - direction, 2.0 * math.pi)
        return max(distance / p.max_distance, abs(angle) / p.max_angle)


@value
class _Memory:
    base: Any
    content_at: float
    """Last time at which the chair was within the tolerances, s."""
    moved_at: float
    """Last time at which it moved, s."""
    steers: bool
    until: float
    """Minimum end of steering after a standstill, s."""


class Watchful:
    """Centred until a collision with a person in sight is imminent: then slower, behind them."""

    class Parameters(Model):
        """Prediction and reaction; assumed."""

        horizon: float = Field(4.0, gt=0.0, le=30.0)
        """Prediction horizon, s."""
        margin: float = Field(0.5, ge=0.0, le=5.0)
        """Minimum predicted gap between chair and person, m."""
        chair_radius: float = Field(0.5, gt=0.0, le=3.0)
        """Assumed radius of the chair about its drive axle, m."""
        forward: float = Field(0.25, ge=0.0, le=1.0)
        """Forward deflection meanwhile, share of full."""
        lateral: float = Field(0.5, ge=0.0, le=1.0)
        """Lateral deflection, share of full."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p = self.parameters
        threats = view.people[self._threatens(view)]
        if not len(threats):
            return deflected(view, (0.0, 0.0))
        _, y, _, across, _ = threats[int(np.argmin(np.hypot(threats[:, 0], threats[:, 1])))]
        behind = -across if abs(across) > _WALKING else -y
        return deflected(view, (p.forward, math.copysign(p.lateral, behind)))

    def _threatens(self, view: RiderView) -> Booleans:
        """Mask (n,) of walking people who come too near at constant velocities."""
        p, people = self.parameters, view.people
        speed = max(float(view.twist[0]), _MIN_SPEED)
        position = people[:, :2]
        velocity = people[:, 2:4] - np.array([speed, 0.0])
        distance = _closest_approach(position, velocity, p.horizon)
        near: Booleans = distance < p.margin + p.chair_radius + people[:, 4]
        walks = np.hypot(people[:, 2], people[:, 3]) > _WALKING
        return near & walks & (position[:, 0] > -p.chair_radius)


def _closest_approach(position: Floats, velocity: Floats, horizon: float) -> Floats:
    """Minimum distance (n,) to the origin of moving points (n, 2) within ``horizon``, m."""
    squared = np.maximum((velocity**2).sum(axis=1), 1e-9)
    time = np.clip(-(position * velocity).sum(axis=1) / squared, 0.0, horizon)
    nearest = position + time[:, None] * velocity
    distance: Floats = np.hypot(nearest[:, 0], nearest[:, 1])
    return distance
