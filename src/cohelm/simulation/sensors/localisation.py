"""Errors of localisation and wheel odometry."""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.geometry import transform, wrap_angle


class Localisation(Model):
    """Localisation error: bounded and slowly varying, as of scan matching; assumed."""

    position_bound: float = Field(0.03, ge=0.0, le=5.0)
    """Maximum error of the position, m."""
    heading_bound_deg: float = Field(1.0, ge=0.0, le=180.0)
    """Maximum error of the heading."""
    correlation_time: float = Field(2.0, gt=0.0, le=1000.0)
    """Time constant of the error, s."""

    def first(self, rng: np.random.Generator) -> Floats:
        """Draw an error (3,) of the stationary process: (x, y) in m, heading in rad."""
        return self._bounded(self._deviation() * rng.standard_normal(3))

    def after(self, error: Floats, dt: float, rng: np.random.Generator) -> Floats:
        """Return the error (3,) ``dt`` later: a clipped Ornstein-Uhlenbeck process."""
        keep = math.exp(-dt / self.correlation_time)
        fresh = math.sqrt(1.0 - keep * keep) * self._deviation() * rng.standard_normal(3)
        return self._bounded(keep * error + fresh)

    def _deviation(self) -> Floats:
        """Standard deviations (3,): half of each bound, so that clipping is rare."""
        p, h = self.position_bound, math.radians(self.heading_bound_deg)
        return np.array([p / 2.0, p / 2.0, h / 2.0])

    def _bounded(self, error: Floats) -> Floats:
        bound = math.radians(self.heading_bound_deg)
        far = math.hypot(error[0], error[1])
        within = min(self.position_bound / far, 1.0) if far > 0.0 else 1.0
        return np.array([within * error[0], within * error[1], min(max(error[2], -bound), bound)])


class Odometry(Model):
    """Noise of the measured twist: a share of it, and a constant where it is not zero; assumed."""

    share: float = Field(0.02, ge=0.0, le=1.0)
    """Standard deviation as a share of each component."""
    linear_floor: float = Field(0.003, ge=0.0, le=1.0)
    """Constant part while moving, m/s."""
    angular_floor: float = Field(0.005, ge=0.0, le=1.0)
    """Constant part while moving, rad/s."""

    def measure(self, twist: Floats, rng: np.random.Generator) -> Floats:
        """Measure a twist (3,); a component that is zero reads zero."""
        floor = np.array([self.linear_floor, self.linear_floor, self.angular_floor])
        deviation = np.where(twist == 0.0, 0.0, self.share * np.abs(twist) + floor)
        return twist + deviation * rng.standard_normal(3)


def with_error(pose: Floats, error: Floats, axis: float) -> Floats:
    """Add a localisation error (3,) to a true pose (3,).

    The x axis of the error has the direction ``axis`` in the map, rad.
    """
    x, y = transform([pose[0], pose[1], axis], error[:2])
    return np.array([x, y, wrap_angle(pose[2] + error[2])])
