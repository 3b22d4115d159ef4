"""What a localiser and wheel odometry say of the chair's own motion."""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.geometry import transform, wrap_angle


class Localisation(Model):
    """A localiser's error: bounded and slowly varying, as scan matching leaves it; assumed."""

    position_bound: float = Field(0.03, ge=0.0, le=5.0)
    """Greatest error of the position, m."""
    heading_bound_deg: float = Field(1.0, ge=0.0, le=180.0)
    """Greatest error of the heading."""
    correlation_time: float = Field(2.0, gt=0.0, le=1000.0)
    """Time constant of the error, s."""

    def first(self, rng: np.random.Generator) -> Floats:
        """An error (3,) as it stands at any moment: (x, y) in m, heading in rad."""
        return self._bounded(self._deviation() * rng.standard_normal(3))

    def after(self, error: Floats, dt: float, rng: np.random.Generator) -> Floats:
        """The error (3,) ``dt`` later: an Ornstein-Uhlenbeck process kept within the bounds."""
        keep = math.exp(-dt / self.correlation_time)
        fresh = math.sqrt(1.0 - keep * keep) * self._deviation() * rng.standard_normal(3)
        return self._bounded(keep * error + fresh)

    def _deviation(self) -> Floats:
        """Half of each bound, so that clipping is rare."""
        p, h = self.position_bound, math.radians(self.heading_bound_deg)
        return np.array([p / 2.0, p / 2.0, h / 2.0])

    def _bounded(self, error: Floats) -> Floats:
        bound = math.radians(self.heading_bound_deg)
        far = math.hypot(error[0], error[1])
        within = min(self.position_bound / far, 1.0) if far > 0.0 else 1.0
        return np.array([within * error[0], within * error[1], min(max(error[2], -bound), bound)])


class Odometry(Model):
    """Noise of the measured twist: a share of it, and a little beside where it is not zero.

    The figures are assumed.
    """

    share: float = Field(0.02, ge=0.0, le=1.0)
    """Standard deviation as a share of each component."""
    linear_floor: float = Field(0.003, ge=0.0, le=1.0)
    """Added to it while moving, m/s."""
    angular_floor: float = Field(0.005, ge=0.0, le=1.0)
    """Added to it while moving, rad/s."""

    def measure(self, twist: Floats, rng: np.random.Generator) -> Floats:
        """The twist (3,) as the wheels' encoders give it; a component that is zero reads zero."""
        floor = np.array([self.linear_floor, self.linear_floor, self.angular_floor])
        deviation = np.where(twist == 0.0, 0.0, self.share * np.abs(twist) + floor)
        return twist + deviation * rng.standard_normal(3)


def with_error(pose: Floats, error: Floats, axis: float) -> Floats:
    """A true pose (3,) as a localiser with this error (3,) gives it.

    The error's x runs in direction ``axis`` of the map, rad.
    """
    x, y = transform([pose[0], pose[1], axis], error[:2])
    return np.array([x, y, wrap_angle(pose[2] + error[2])])
