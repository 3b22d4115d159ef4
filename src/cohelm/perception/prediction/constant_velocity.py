"""Predictor that keeps each person's velocity."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, read_only, sealed
from cohelm.config import Model
from cohelm.kernels import CACHED
from cohelm.messages import People, Predictions
from cohelm.perception.tracking.kalman import larger_axis


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
        times, drift = _horizon(steps, step, p.process_noise)
        ahead = _predicted(
            people.mean,
            people.covariance,
            times,
            drift,
            (p.velocity_share, p.standing_speed, p.max_deviation),
        )
        predictions = Predictions(step=step, names=("keeps_going",), **sealed(ahead)._asdict())
        return predictions, None


class _Horizon(NamedTuple):
    """Prediction of n people over K times: the columns of ``Predictions``, h = 1."""

    weight: Floats
    mean: Floats
    velocity: Floats
    deviation: Floats


@lru_cache(maxsize=8)
def _horizon(steps: int, step: float, process_noise: float) -> tuple[Floats, Floats]:
    """(times from now, s; variances by the drift of the velocity, m²), (steps + 1,) each."""
    t = step * np.arange(steps + 1, dtype=np.float64)
    return read_only(t), read_only(process_noise * t**3 / 3.0)


@njit(**CACHED)
def _predicted(
    mean: Floats,
    covariance: Floats,
    times: Floats,
    drift: Floats,
    limits: tuple[float, float, float],
) -> _Horizon:
    """Predict people at all times.

    Args:
        mean: (n, 4).
        covariance: (n, 4, 4); of a position after t, P_pp + t (P_pv + P_vp) + t² P_vv.
        times: (K,) from now, s.
        drift: added to the variances, (K,) m².
        limits: (share of the velocity that is kept, standing speed, largest deviation).
    """
    (n, _), count = mean.shape, len(times)
    kept, standing_speed, max_deviation = limits
    out = _Horizon(
        np.ones((n, 1)),
        np.empty((n, 1, count, 2)),
        np.empty((n, 1, count, 2)),
        np.empty((n, 1, count)),
    )
    for i in range(n):
        # The velocity of a standing person is noise.
        share, C = kept, covariance[i]
        if standing_speed != 0.0:
            speed = math.hypot(mean[i, 2], mean[i, 3])
            share *= min(max(speed / standing_speed - 1.0, 0.0), 1.0)
        for k in range(count):
            t, square = times[k], times[k] * times[k]
            for axis in range(2):
                velocity = share * mean[i, axis + 2]
                out.velocity[i, 0, k, axis] = velocity
                out.mean[i, 0, k, axis] = mean[i, axis] + t * velocity
            xx = C[0, 0] + t * (C[0, 2] + C[2, 0]) + square * C[2, 2] + drift[k]
            xy = C[0, 1] + t * (C[0, 3] + C[2, 1]) + square * C[2, 3]
            yy = C[1, 1] + t * (C[1, 3] + C[3, 1]) + square * C[3, 3] + drift[k]
            out.deviation[i, 0, k] = min(larger_axis(xx, xy, yy), max_deviation)
    return out
