"""Where people will be."""

from __future__ import annotations

import numpy as np
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
        t = step * np.arange(steps + 1)
        share = p.lasting * _walking(people.mean[:, 2:], p.standing)
        velocity = np.broadcast_to((share * people.mean[:, 2:])[:, None], (n, steps + 1, 2))
        mean = people.mean[:, None, :2] + t[:, None] * velocity
        C = people.covariance[:, None]
        time = t[:, None, None]
        spread = C[..., :2, :2] + time * (C[..., :2, 2:] + C[..., 2:, :2])
        spread = spread + time**2 * C[..., 2:, 2:] + p.agility * time**3 / 3.0 * np.eye(2)
        deviation = larger_deviation(spread.reshape(-1, 2, 2)).reshape(n, steps + 1)
        predictions = Predictions(
            step=step,
            names=("keeps_going",),
            weight=np.ones((n, 1)),
            mean=mean[:, None],
            velocity=velocity[:, None],
            deviation=np.minimum(deviation, p.largest_deviation)[:, None],
        )
        return predictions, None


def _walking(velocity: Floats, standing: float) -> Floats:
    """The share (n, 1) of velocities (n, 2) that is no noise about standing."""
    speed = np.hypot(velocity[:, :1], velocity[:, 1:])
    if standing == 0.0:
        return np.ones_like(speed)
    return np.asarray(np.clip(speed / standing - 1.0, 0.0, 1.0))
