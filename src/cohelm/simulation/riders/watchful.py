"""A rider who lets the chair drive and looks out for people."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Booleans, Floats
from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.hand import steered


class Watchful:
    """Centred, until somebody in sight is about to be run into: then slower, and behind them."""

    class Parameters(Model):
        """Whom to avoid, and how; assumed."""

        within: float = Field(4.0, gt=0.0, le=30.0)
        """For how long ahead they look, s."""
        margin: float = Field(0.5, ge=0.0, le=5.0)
        """How near somebody may come to the chair's middle line of travel beyond both bodies, m."""
        reach: float = Field(0.5, gt=0.0, le=3.0)
        """How far the chair's body reaches from its drive axle, as they take it, m."""
        forward: float = Field(0.25, ge=0.0, le=1.0)
        """Deflection forward meanwhile, share of full."""
        aside: float = Field(0.5, ge=0.0, le=1.0)
        """Deflection to the side, share of full."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p = self.parameters
        threats = view.people[self._threatens(view)]
        if not len(threats):
            return steered(view, (0.0, 0.0))
        _, y, _, across, _ = threats[int(np.argmin(np.hypot(threats[:, 0], threats[:, 1])))]
        behind_them = -across if abs(across) > _CROSSES else -y
        return steered(view, (p.forward, math.copysign(p.aside, behind_them)))

    def _threatens(self, view: RiderView) -> Booleans:
        """Who (n,) comes too near within the time, if both went on as they go."""
        p, people = self.parameters, view.people
        speed = max(float(view.twist[0]), _SLOWEST)
        place = people[:, :2]
        velocity = people[:, 2:4] - np.array([speed, 0.0])
        least = _nearest_to_come(place, velocity, p.within)
        near: Booleans = least < p.margin + p.reach + people[:, 4]
        walks = np.hypot(people[:, 2], people[:, 3]) > _CROSSES
        return near & walks & (place[:, 0] > -p.reach)


_CROSSES = 0.2
"""Slower than this somebody stands, m/s."""
_SLOWEST = 0.3
"""As fast as this the chair would set out, m/s."""


def _nearest_to_come(place: Floats, velocity: Floats, within: float) -> Floats:
    """Least distance (n,) within a time of points (n, 2) that move with (n, 2), m."""
    squared = np.maximum((velocity**2).sum(axis=1), 1e-9)
    moment = np.clip(-(place * velocity).sum(axis=1) / squared, 0.0, within)
    nearest = place + moment[:, None] * velocity
    distance: Floats = np.hypot(nearest[:, 0], nearest[:, 1])
    return distance
