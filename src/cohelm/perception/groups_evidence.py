"""How much two people's places, motion and facing speak for their belonging together."""

from __future__ import annotations

import math
from typing import NamedTuple

from numba import njit

from cohelm.arrays import Booleans, Floats


class Weighing(NamedTuple):
    """What the kernels take of ``Affinity.Parameters``, which tells what each means."""

    walking_prior: float
    standing_prior: float
    nearness: float
    walking_distance: float
    in_file: float
    unison: float
    strangers: float
    certain: float
    standing_distance: float
    facing: float
    stride: float
    shared: float
    behind: float
    standing: float
    first_look: float
    drift_time: float
    fading: float
    rate: float
    most: float
    largest: float


@njit(cache=True)
def gather(  # noqa: PLR0913, PLR0917  # a kernel takes what it works on one by one
    state: Floats,
    spread: Floats,
    heading: Floats,
    since: float,
    log_odds: Floats,
    drift: Floats,
    weight: Floats,
    known: Booleans,
    w: Weighing,
) -> tuple[Floats, Floats, Floats]:
    """(log_odds, drift, weight) of every pair after one more look.

    L ← clip(L e^(−Δt / fading) + Δt · rate · e), e from :func:`walking` or :func:`standing`; a
    pair that is seen for the first time gets Δt = ``first_look``. In the running mean of the drift
    a look weighs certain² / (certain² + variance): a velocity that is hardly known says little.

    Args:
        state: (n, 4), x, y, v_x, v_y; m and m/s.
        spread: (n,) variance of the velocity along one axis, m²/s².
        heading: (n,) rad; NaN where unknown.
        since: since the last look, s.
        log_odds: (n, n).
        drift: (n, n, 2), a running mean of the second's velocity as seen from the first, m/s.
        weight: (n, n), of that mean, 0…1.
        known: (n, n), which pairs have been looked at before.
        w: the parameters.
    """
    n = state.shape[0]
    L, D, W = log_odds.copy(), drift.copy(), weight.copy()
    forget, fade = math.exp(-since / w.fading), math.exp(-since / w.drift_time)
    first = math.exp(-w.first_look / w.drift_time)
    for i in range(n):
        for j in range(i + 1, n):
            span, keep = (since, fade) if known[i, j] else (w.first_look, first)
            var = spread[i] + spread[j]
            gain = (1.0 - keep) * w.certain**2 / (w.certain**2 + var)
            W[i, j] = W[i, j] * keep + gain
            if gain > 0.0:
                for axis in range(2):
                    apart = state[j, 2 + axis] - state[i, 2 + axis]
                    D[i, j, axis] += gain / W[i, j] * (apart - D[i, j, axis])
            one = math.hypot(state[i, 2], state[i, 3])
            other = math.hypot(state[j, 2], state[j, 3])
            if one < w.standing and other < w.standing:
                e = standing(state[i], state[j], heading[i], heading[j], w)
            else:
                slip = D[i, j, 0] ** 2 + D[i, j, 1] ** 2
                e = walking(state[i], state[j], slip, max(one, other), w)
            e = min(max(e, -w.most), w.most)
            kept = L[i, j] * forget if known[i, j] else 0.0
            L[i, j] = min(max(kept + span * w.rate * e, -w.largest), w.largest)
            L[j, i], W[j, i] = L[i, j], W[i, j]
            D[j, i, 0], D[j, i, 1] = -D[i, j, 0], -D[i, j, 1]
    return L, D, W


@njit(cache=True)
def walking(one: Floats, other: Floats, slip: float, speed: float, w: Weighing) -> float:
    """Evidence of two of whom at least one walks; its log-likelihood ratio, about.

    Companions stay near, and more so one behind the other than side by side; their velocities
    differ by Gaussians of deviation ``unison``, those of strangers by more, the faster they are:

        e = prior + nearness (1 − (d² + in_file a²) / distance²) + ln(S²/s²) − u²/2 (1/s² − 1/S²)
        s = unison,  S² = s² + (strangers · speed)²

    with d their distance, a its part along their common direction and u the drift. Where both are
    slow, the velocities say nothing.

    Args:
        one, other: x, y, v_x, v_y; m and m/s.
        slip: u², m²/s².
        speed: of the faster, m/s.
        w: the parameters.
    """
    dx, dy = other[0] - one[0], other[1] - one[1]
    vx, vy = one[2] + other[2], one[3] + other[3]
    common = vx * vx + vy * vy
    along = (dx * vx + dy * vy) ** 2 / common if common > 1e-9 else 0.0
    near = 1.0 - (dx * dx + dy * dy + w.in_file * along) / w.walking_distance**2
    s2 = w.unison**2
    S2 = s2 + (w.strangers * speed) ** 2
    same = math.log(S2 / s2) - 0.5 * slip * (1.0 / s2 - 1.0 / S2)
    total: float = w.walking_prior + w.nearness * near + same
    return total


@njit(cache=True)
def standing(one: Floats, other: Floats, facing: float, other_facing: float, w: Weighing) -> float:
    """Evidence of two who stand: a common o-space, or nearness alone where a heading is unknown.

    The o-space of an F-formation (Kendon) lies a ``stride`` ahead of everyone in it. Two share it
    whose centres are near each other, and neither of whom has the other behind:

        e = prior + facing (1 − o² / shared²) − behind (max(−¼ − cos β, 0) + max(−¼ − cos β', 0))

    with o the distance between the centres and β the bearing of the other; −cos β > ¼ is behind the
    shoulders. With a heading unknown,
    e = prior + nearness (1 − d² / standing_distance²), at most half as sure.
    """
    dx, dy = other[0] - one[0], other[1] - one[1]
    d = math.hypot(dx, dy)
    if math.isnan(facing) or math.isnan(other_facing):
        e = w.standing_prior + w.nearness * (1.0 - (d / w.standing_distance) ** 2)
        return min(e, 0.5 * w.most)
    cx, cy = math.cos(facing), math.sin(facing)
    ox, oy = math.cos(other_facing), math.sin(other_facing)
    apart = math.hypot(dx + w.stride * (ox - cx), dy + w.stride * (oy - cy))
    ahead = (cx * dx + cy * dy) / max(d, 1e-9)
    other_ahead = -(ox * dx + oy * dy) / max(d, 1e-9)
    turned = max(-0.25 - ahead, 0.0) + max(-0.25 - other_ahead, 0.0)
    total: float = w.standing_prior + w.facing * (1.0 - (apart / w.shared) ** 2)
    total -= w.behind * turned
    return total
