"""People who turn back: what is possible, but not expected."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, unchecked
from cohelm.kernels import CACHED
from cohelm.messages import People, Predictions

TURN_DELAY = 0.25
"""Delay until a turn is detected, s: two scans and the filter."""
RETURN_SPEED = 1.0
"""Maximum return speed of people who are measured as slower, m/s: a turning person is."""
_FASTER = 4.0
"""Assumed return speed as a multiple of the measured speed, up to ``RETURN_SPEED``."""
_WALKED = 0.5
"""People who have been slower than this lately are assumed not to turn back, m/s: tracking noise is
up to 0.3 m/s."""


def turned_back(
    people: People,
    given: Predictions,
    speeds: Floats,
    *,
    acceleration: float,
) -> Predictions:
    """Predictions of all people walking back, since a turn that is not detected yet.

    Who has stood for a while stays. The measured position is that of a person who walked on; the
    turn has taken them behind it.

    Args:
        people: as measured.
        given: predictions of these people.
        speeds: (n,) of people lately, m/s.
        acceleration: of a turn, m/s².
    """
    mean, velocity = _return(
        people.mean,
        np.asarray(given.step * np.arange(given.mean.shape[2]), dtype=float),
        speeds > _WALKED,
        TURN_DELAY,
        acceleration,
        RETURN_SPEED,
    )
    return unchecked(
        given,
        names=("turned_back",),
        weight=np.ones((len(mean), 1)),
        mean=mean,
        velocity=velocity,
        deviation=np.zeros(mean.shape[:3]),
    )


@njit(**CACHED)
def _return(
    people: Floats,
    times: Floats,
    walked: Booleans,
    delay: float,
    acceleration: float,
    top_speed: float,
) -> tuple[Floats, Floats]:
    """(positions, velocities), (n, 1, N+1, 2) each, of people (n, 4) who turn back.

    times: (N+1,) since the measurement, s.  walked: (n,) people who have walked lately.  See
    :func:`turned_back`.
    """
    count, states = people.shape[0], times.shape[0]
    mean, velocity = np.empty((count, 1, states, 2)), np.empty((count, 1, states, 2))
    for i in range(count):
        speed = math.hypot(people[i, 2], people[i, 3])
        return_speed = max(speed, min(_FASTER * speed, top_speed))
        for k in range(states):
            # s: distance along the former direction, braking, then back at a constant speed
            elapsed = delay + times[k]
            turning = min(elapsed, (speed + return_speed) / acceleration)
            s = speed * turning - 0.5 * acceleration * (turning * turning)
            s -= return_speed * (elapsed - turning)
            s -= speed * delay
            v = -return_speed if elapsed > turning else speed - acceleration * turning
            if not walked[i]:
                s, v = 0.0, 0.0
            for a in range(2):
                unit = people[i, 2 + a] / max(speed, 1e-9)
                mean[i, 0, k, a] = people[i, a] + s * unit
                velocity[i, 0, k, a] = v * unit
    return mean, velocity
