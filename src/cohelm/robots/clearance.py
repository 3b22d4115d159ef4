"""Clearance from people: one model for terms and barriers, verification and safety gate.

At prediction time t, a gap of

    m(t, v) = s(v) · min(now + (growth + oncoming · o) · t + deviations · σ, upper) + extra

is kept from a person who walks at v, where s grows from ``standing`` to 1 at 0.5 m/s, o is
:func:`oncoming_share`, σ the standard deviation of the predicted position, and ``extra`` a
therapist's addition, which holds in full for standing people too. Terms and barriers read m(t),
verification reads it without σ and o, and lets it grow with a person's pace, see
``planner_memory.recent_paces``; comfort braking and the gate, which act last, keep
s(v) · ``CLOSEST`` · now + extra. While the ride is stalled, the gap does not grow.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.kernels import CACHED
from cohelm.messages import People

BRISK = 0.5
"""Clearance counts in full from this speed of a person on, m/s."""


CLOSEST = 0.25
"""Share of the gap now that is left to the last moment."""


class Clearance(Model):
    """Clearance from people; assumed, tuned on rides."""

    now: float = Field(0.12, ge=0.0, le=2.0)
    """Gap to a walking person now, m."""
    growth: float = Field(0.12, ge=0.0, le=1.0)
    """Growth with prediction time, m/s."""
    oncoming: float = Field(0.0, ge=0.0, le=1.0)
    """Additional growth for oncoming people, m/s."""
    deviations: float = Field(0.0, ge=0.0, le=5.0)
    """Standard deviations of the predicted position that are added."""
    upper: float = Field(0.6, ge=0.0, le=3.0)
    """Upper bound, m."""
    standing: float = Field(0.4, ge=0.0, le=1.0)
    """Share for a standing person."""

    def law(self, *, tight: bool = False, oncoming: float = 0.0, extra: float = 0.0) -> MarginLaw:
        """The law for compiled code.

        Args:
            tight: the ride has stalled: the gap does not grow, so that the robot may squeeze
                past people.
            oncoming: o, 0 to 1.
            extra: added to the gap, m; the minimum distance of a therapist.
        """
        if tight:
            return MarginLaw(self.now, 0.0, 0.0, self.now, self.standing, extra)
        return MarginLaw(
            self.now,
            self.growth + self.oncoming * oncoming,
            self.deviations,
            max(self.upper, self.now),
            self.standing,
            extra,
        )


class MarginLaw(NamedTuple):
    """:class:`Clearance` in one situation."""

    now: float
    """m."""
    growth: float
    """m/s."""
    deviations: float
    upper: float
    """m."""
    standing: float
    extra: float
    """m."""


@njit(**CACHED)
def people_margins(
    velocity: Floats, deviation: Floats, step: float, steps: int, law: MarginLaw
) -> Floats:
    """m(t), (P, L+1), of all hypotheses of all people.

    Args:
        velocity: (n, h, N+1, 2); the first decides whether the person walks.
        deviation: (n, h, N+1) of the predicted positions, m.
        step: between predictions, s.
        steps: L; beyond N the deviation stays.
        law: clearance.
    """
    n, h, known = deviation.shape
    out = np.empty((n * h, steps + 1))
    for i in range(n):
        for j in range(h):
            share = share_of(math.hypot(velocity[i, j, 0, 0], velocity[i, j, 0, 1]), law.standing)
            for k in range(steps + 1):
                gap = law.now + law.growth * k * step
                gap += law.deviations * deviation[i, j, min(k, known - 1)]
                out[i * h + j, k] = share * min(gap, law.upper) + law.extra
    return out


@njit(**CACHED, inline="always")
def share_of(speed: float, standing: float) -> float:
    """s(v)."""
    return standing + (1.0 - standing) * min(speed / BRISK, 1.0)


def oncoming_share(people: People, pose: Floats) -> float:
    """o, the share of the oncoming growth that applies to all people, 0 to 1.

    1 for a single person who walks straight towards the robot, less by the cosine for crossing
    people, 0 for people who walk in the robot's direction: the robot yields to crossing people
    instead of driving around them. Positions do not matter, so the margin does not fade during a
    passage. The mean over several people is divided by their number, because a wide margin to one
    would lead into the next. Slow people count in proportion, in full from 0.5 m/s. Assumed.

    Args:
        people: as they are now.
        pose: X_MR, (3,).
    """
    return float(_oncoming(people.mean, math.cos(pose[2]), math.sin(pose[2])))


@njit(**CACHED)
def _oncoming(states: Floats, cos: float, sin: float) -> float:
    """Oncoming share of states (n, 4) for a heading."""
    walking, towards = 0.0, 0.0
    for i in range(states.shape[0]):
        vx, vy = states[i, 2], states[i, 3]
        speed = math.hypot(vx, vy)
        if speed > 0.0:
            walks = min(speed / BRISK, 1.0)
            walking += walks
            towards += walks * max(-(cos * vx + sin * vy) / speed, 0.0)
    return towards / walking / max(walking, 1.0) if walking > 0.0 else 0.0
