"""Where people will be."""

from __future__ import annotations

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.messages import People, Predictions
from cohelm.perception.kalman import larger_deviation


class ConstantVelocity:
    """One hypothesis, ``keeps_going``: p + v t, less and less sure.

    The position's covariance after t is P_pp + t (P_pv + P_vp) + t² P_vv + q t³/3: what is not
    known of the velocity now, and how it may wander (``kalman.predict``). The larger axis's
    deviation is told, at most ``largest_deviation``.

    People walk or stand: the velocity that a tracker finds in who stands is noise, and would lead
    them half a metre aside.
    """

    class Parameters(Model):
        """Of the predictor; assumed."""

        agility: float = Field(0.05, ge=0.0, le=10.0)
        """q, m²/s³. Less than the tracker's: most people keep going, and a plan is renewed every
        tick; 0.13 m after 1 s, 0.37 m after 2 s from this alone."""
        largest_deviation: float = Field(1.0, gt=0.0, le=20.0)
        """m."""
        lasting: float = Field(1.0, ge=0.0, le=1.0)
        """Share of the velocity now that people go on with; 0: they are expected to stand where
        they are, which is what a planner without prediction believes."""
        standing: float = Field(0.1, ge=0.0, le=1.0)
        """Who is slower than this stands; from twice this on the whole velocity counts, m/s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def predict(
        self, people: People, steps: int, step: float, memory: None = None
    ) -> tuple[Predictions, None]:
        """See :meth:`Predictor.predict`; nothing needs to be remembered."""
        p = self.parameters
        n = len(people)
        t = step * np.arange(steps + 1, dtype=np.float64)
        share = p.lasting * _walking(people.mean[:, 2:], p.standing)
        velocity = np.broadcast_to((share * people.mean[:, 2:])[:, None], (n, steps + 1, 2))
        mean = people.mean[:, None, :2] + t[:, None] * velocity
        spread = _spread(people.covariance, t, p.agility * t**3 / 3.0)
        deviation = larger_deviation(spread).reshape(n, steps + 1)
        predictions = Predictions(
            step=step,
            names=("keeps_going",),
            weight=np.ones((n, 1)),
            mean=mean[:, None],
            velocity=velocity[:, None],
            deviation=np.minimum(deviation, p.largest_deviation)[:, None],
        )
        return predictions, None


@njit(cache=True)
def _spread(covariance: Floats, times: Floats, wandering: Floats) -> Floats:
    """Covariance (n·k, 2, 2) of n people's positions at k times: P_pp + t (P_pv + P_vp) + t² P_vv.

    wandering: added to the variances, (k,) m².
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
                    out[i * count + k, a, b] = each + (wandering[k] if a == b else 0.0)
    return out


def _walking(velocity: Floats, standing: float) -> Floats:
    """The share (n, 1) of velocities (n, 2) that is no noise about standing."""
    speed = np.hypot(velocity[:, :1], velocity[:, 1:])
    if standing == 0.0:
        return np.ones_like(speed)
    return np.asarray(np.clip(speed / standing - 1.0, 0.0, 1.0))
