"""What a tracker remembers, and the plain operations on it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.perception.kalman import innovations

_PER_TRACK = (
    "id",
    "mean",
    "covariance",
    "heading",
    "radius",
    "shape",
    "motion",
    "history",
    "absent",
    "birthplace",
    "surprise",
    "confirmed",
)


@value
class TrackerState:
    """Tracks at the time of the last scan, tentative ones included; m of them, by growing id."""

    time: float
    """Of the last scan that was used, s."""
    next_id: int
    id: Annotated[Integers, Shape("m")]
    mean: Annotated[Floats, Shape("m 4")]
    """(x, y, v_x, v_y), m and m/s."""
    covariance: Annotated[Floats, Shape("m 4 4")]
    heading: Annotated[Floats, Shape("m")]
    """rad; NaN until the track has walked."""
    radius: Annotated[Floats, Shape("m")]
    """m."""
    shape: Annotated[Floats, Shape("m")]
    """Running mean of the log-odds of a person that its shape gives."""
    motion: Annotated[Floats, Shape("m")]
    """Log-odds of a person that its walking has earned, ≥ 0."""
    history: Annotated[Integers, Shape("m")]
    """Bit k: seen k scans ago."""
    absent: Annotated[Floats, Shape("m")]
    """For how long it has not been seen, weighted by what was seen in its place, s."""
    birthplace: Annotated[Floats, Shape("m 2")]
    """m."""
    surprise: Annotated[Floats, Shape("m")]
    """Running mean of the normalised squared innovations; 2 where the model holds."""
    confirmed: Annotated[Booleans, Shape("m")]
    """A person, and told."""

    @property
    def log_odds(self) -> Floats:
        """ln(p / (1 − p)) that each is a person; (m,)."""
        return self.shape + self.motion

    def __len__(self) -> int:
        """How many tracks."""
        return len(self.id)


def no_tracks(time: float, next_id: int = 0) -> TrackerState:
    """Nobody yet."""
    none = np.empty(0)
    return TrackerState(
        time=time,
        next_id=next_id,
        id=np.empty(0, dtype=np.int64),
        mean=none.reshape(0, 4),
        covariance=none.reshape(0, 4, 4),
        heading=none,
        radius=none,
        shape=none,
        motion=none,
        history=np.empty(0, dtype=np.int64),
        absent=none,
        birthplace=none.reshape(0, 2),
        surprise=none,
        confirmed=np.empty(0, dtype=np.bool_),
    )


def select(state: TrackerState, which: Booleans) -> TrackerState:
    """The tracks ``which`` (m,) says, in order."""
    if which.all():
        return state
    return replace(state, **{name: getattr(state, name)[which] for name in _PER_TRACK})


def add(
    state: TrackerState,
    *,
    position: Floats,
    deviation: Floats,
    radius: Floats,
    shape: Floats,
    speed_deviation: float,
) -> TrackerState:
    """``state`` with a tentative track, at rest and unsure of it, for each of d positions."""
    d = len(position)
    if d == 0:
        return state
    variance = np.zeros((d, 4))
    variance[:, :2] = deviation[:, None] ** 2
    variance[:, 2:] = speed_deviation**2
    new = {
        "id": state.next_id + np.arange(d),
        "mean": np.concatenate([position, np.zeros((d, 2))], axis=1),
        "covariance": variance[:, :, None] * np.eye(4),
        "heading": np.full(d, np.nan),
        "radius": radius,
        "shape": shape,
        "motion": np.zeros(d),
        "history": np.ones(d, dtype=np.int64),
        "absent": np.zeros(d),
        "birthplace": position,
        "surprise": np.full(d, 2.0),
        "confirmed": np.zeros(d, dtype=np.bool_),
    }
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(state, name), new[name]]) for name in _PER_TRACK
    }
    return replace(state, next_id=state.next_id + d, **joined)


def associate(
    state: TrackerState, position: Floats, deviation: Floats, *, gate: float, farthest: float
) -> tuple[Integers, Integers, Floats]:
    """The cheapest one-to-one matching of tracks and positions.

    The cost of a pair is eᵀ S⁻¹ e + ln det S, that is −2 ln of the innovation's likelihood, with a
    little on top for a tentative track; as many pairs as pass the gate are made. What is left over
    of the confirmed tracks may then take what is left over nearby, however unlikely: someone who
    turned on the spot.

    Args:
        state: m tracks, at the time of the positions.
        position: (d, 2) m.
        deviation: (d,) m.
        gate: largest eᵀ S⁻¹ e of the first matching.
        farthest: largest |e|, m; half of it in the second matching.

    Returns:
        (tracks, positions, squared): indices of the pairs, (k,) each, and their eᵀ S⁻¹ e.
    """
    squared, log_det = innovations(state.mean, state.covariance, position, deviation)
    offset = position[None, :, :] - state.mean[:, None, :2]
    distance = np.hypot(offset[..., 0], offset[..., 1])
    cost = squared + log_det + _TENTATIVE * ~state.confirmed[:, None]
    usual = (squared <= gate) & (distance <= farthest)
    rows, cols = _match(np.where(usual, cost, _NEVER))
    free = state.confirmed[:, None] & (distance <= 0.5 * farthest)
    free[rows] = False
    free[:, cols] = False
    if free.any():
        more_rows, more_cols = _match(np.where(free, cost, _NEVER))
        rows, cols = np.concatenate([rows, more_rows]), np.concatenate([cols, more_cols])
    return rows, cols, squared[rows, cols]


_TENTATIVE = 3.0
"""What a match with a tentative track costs on top."""
_NEVER = 1e9


def _match(cost: Floats) -> tuple[Integers, Integers]:
    rows, cols = linear_sum_assignment(np.minimum(cost, _NEVER))
    made = cost[rows, cols] < _NEVER
    return rows[made], cols[made]
