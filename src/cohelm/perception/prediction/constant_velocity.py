"""Predictor that keeps each person's velocity."""

from __future__ import annotations

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.messages import People, Predictions
from cohelm.perception.tracking.kalman import larger_deviation


class ConstantVelocity:
    """One hypothesis, ``keeps_going``: p + v t, with growing deviation.

    The position's covariance after t is P_pp + t (P_pv + P_vp) + t² P_vv + q t³/3: the uncertainty
    of the present velocity, and its drift (``kalman.predict``). The deviation is that of the larger
    axis, at most ``max_deviation``.

    People walk or stand: the estimated velocity of a standing person is noise, and would shift the
    prediction by half a metre.
    """

    class Parameters(Model):
        """Parameters of the predictor; assumed."""

        process_noise: float = Field(0.05, ge=0.0, le=10.0)
        """q, m²/s³. Less than the tracker's: most people keep going, and a plan is renewed every
        tick. It adds 0.13 m after 1 s, 0.37 m after 2 s."""
        max_deviation: float = Field(1.0, gt=0.0, le=20.0)
        """m."""
        velocity_share: float = Field(1.0, ge=0.0, le=1.0)
        """Share of the present velocity that people keep; 0: they are predicted to stand still, as
        by a planner without prediction."""
        standing_speed: float = Field(0.1, ge=0.0, le=1.0)
        """Slower people are standing; from twice this speed the full velocity counts, m/s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def predict(
        self, people: People, steps: int, step: float, memory: None = None
    ) -> tuple[Predictions, None]:
        """See :meth:`Predictor.predict`; there is no memory."""
        p = self.parameters
        n = len(people)
        t = step * np.arange(steps + 1, dtype=np.float64)
        share = p.velocity_share * _walking_share(people.mean[:, 2:], p.standing_speed)
        velocity = np.broadcast_to((share * people.mean[:, 2:])[:, None], (n, steps + 1, 2))
        mean = people.mean[:, None, :2] + t[:, None] * velocity
        spread = _spread(people.covariance, t, p.process_noise * t**3 / 3.0)
        deviation = larger_deviation(spread).reshape(n, steps + 1)
        predictions = Predictions(
            step=step,
            names=("keeps_going",),
            weight=np.ones((n, 1)),
            mean=mean[:, None],
            velocity=velocity[:, None],
            deviation=np.minimum(deviation, p.max_deviation)[:, None],
        )
        return predictions, None


@njit(cache=True)
def _spread(covariance: Floats, times: Floats, drift: Floats) -> Floats:
    """Covariance (n·k, 2, 2) of n positions at k times: P_pp + t (P_pv + P_vp) + t² P_vv.

    drift: added to the variances, (k,) m².
    """
    count = len(times)
    out = np.empty((covariance.shape[0] * count, 2, 2))
    for i in range(covariance.shape[0]):
        C = covariance[i]
        for k in range(count):
            t = times[k]
            for a in range(2):
                for b in range(2):
                    each = C[a, b] + t * (C[a, b + 2] + C[a + 2, b]) + t * t * C[a + 2, b + 2]
                    out[i * count + k, a, b] = each + (drift[k] if a == b else 0.0)
    return out


def _walking_share(velocity: Floats, standing_speed: float) -> Floats:
    """Share (n, 1) of velocities (n, 2) that is not noise of a standing person."""
    speed = np.hypot(velocity[:, :1], velocity[:, 1:])
    if standing_speed == 0.0:
        return np.ones_like(speed)
    return np.asarray(np.clip(speed / standing_speed - 1.0, 0.0, 1.0))
