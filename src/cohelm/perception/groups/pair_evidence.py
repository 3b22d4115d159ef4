"""Evidence from positions, motion and headings that two people belong together."""

from __future__ import annotations

import math
from typing import NamedTuple

from numba import njit

from cohelm.arrays import Floats
from cohelm.kernels import CACHED


class PairEvidenceParameters(NamedTuple):
    """The part of ``Affinity.Parameters`` that the kernels use; described there."""

    walking_prior: float
    standing_prior: float
    nearness: float
    walking_distance: float
    following_factor: float
    companion_deviation: float
    stranger_deviation: float
    half_weight_deviation: float
    standing_distance: float
    facing: float
    o_space_offset: float
    o_space_distance: float
    behind: float
    standing_speed: float
    first_look: float
    drift_time: float
    fading: float
    rate: float
    max_evidence: float
    max_log_odds: float


class PairEvidence(NamedTuple):
    """Evidence of all pairs among n people."""

    log_odds: Floats
    """(n, n)."""
    relative_velocity: Floats
    """(n, n, 2) running mean of the second's velocity relative to the first, m/s."""
    weight: Floats
    """(n, n) weight of that mean, 0…1; 0: never observed together."""


@njit(**CACHED)
def update_pair_evidence(
    state: Floats,
    variance: Floats,
    heading: Floats,
    since: float,
    before: PairEvidence,
    w: PairEvidenceParameters,
) -> PairEvidence:
    """Evidence of all pairs after one more observation.

    L ← clip(L e^(−Δt / fading) + Δt · rate · e), e from :func:`walking_evidence` or
    :func:`standing_evidence`; Δt = ``first_look`` for a new pair. In the running mean of the
    relative velocity an observation weighs h² / (h² + variance), h = ``half_weight_deviation``.

    Args:
        state: (n, 4), x, y, v_x, v_y; m and m/s.
        variance: (n,) of the velocity along one axis, m²/s².
        heading: (n,) rad; NaN where unknown.
        since: time since the last observation, s.
        before: earlier evidence.
        w: the parameters.
    """
    n = state.shape[0]
    L, D, W = before.log_odds.copy(), before.relative_velocity.copy(), before.weight.copy()
    forget, fade = math.exp(-since / w.fading), math.exp(-since / w.drift_time)
    first = math.exp(-w.first_look / w.drift_time)
    for i in range(n):
        for j in range(i + 1, n):
            known = before.weight[i, j] > 0.0
            span, keep = (since, fade) if known else (w.first_look, first)
            # Running mean of the difference of velocities.
            var = variance[i] + variance[j]
            gain = (1.0 - keep) * w.half_weight_deviation**2 / (w.half_weight_deviation**2 + var)
            W[i, j] = W[i, j] * keep + gain
            if gain > 0.0:
                for axis in range(2):
                    apart = state[j, 2 + axis] - state[i, 2 + axis]
                    D[i, j, axis] += gain / W[i, j] * (apart - D[i, j, axis])
            # Evidence of this observation.
            one = math.hypot(state[i, 2], state[i, 3])
            other = math.hypot(state[j, 2], state[j, 3])
            if one < w.standing_speed and other < w.standing_speed:
                e = standing_evidence(state[i], state[j], heading[i], heading[j], w)
            else:
                relative_speed_sq = D[i, j, 0] ** 2 + D[i, j, 1] ** 2
                e = walking_evidence(state[i], state[j], relative_speed_sq, max(one, other), w)
            e = min(max(e, -w.max_evidence), w.max_evidence)
            kept = L[i, j] * forget if known else 0.0
            L[i, j] = min(max(kept + span * w.rate * e, -w.max_log_odds), w.max_log_odds)
            # The matrices are symmetric, the relative velocity antisymmetric.
            L[j, i], W[j, i] = L[i, j], W[i, j]
            D[j, i, 0], D[j, i, 1] = -D[i, j, 0], -D[i, j, 1]
    return PairEvidence(L, D, W)


@njit(**CACHED)
def walking_evidence(
    one: Floats, other: Floats, relative_speed_sq: float, speed: float, w: PairEvidenceParameters
) -> float:
    """Evidence of two people of whom at least one walks, an approximate log-likelihood ratio.

    Companions stay near, and nearer one behind the other than side by side. The difference of
    their velocities is Gaussian with deviation s, that of strangers larger and growing with speed:

        e = prior + nearness (1 − (d² + f a²) / distance²) + ln(S²/s²) − u²/2 (1/s² − 1/S²)
        s = companion_deviation,  S² = s² + (stranger_deviation · speed)²,  f = following_factor

    with d their distance, a its part along their common direction and u their relative velocity.
    If both are slow, the velocities carry no information.

    Args:
        one, other: x, y, v_x, v_y; m and m/s.
        relative_speed_sq: u², m²/s².
        speed: of the faster person, m/s.
        w: the parameters.
    """
    dx, dy = other[0] - one[0], other[1] - one[1]
    vx, vy = one[2] + other[2], one[3] + other[3]
    common = vx * vx + vy * vy
    along = (dx * vx + dy * vy) ** 2 / common if common > 1e-9 else 0.0
    near = 1.0 - (dx * dx + dy * dy + w.following_factor * along) / w.walking_distance**2
    s2 = w.companion_deviation**2
    S2 = s2 + (w.stranger_deviation * speed) ** 2
    same = math.log(S2 / s2) - 0.5 * relative_speed_sq * (1.0 / s2 - 1.0 / S2)
    total: float = w.walking_prior + w.nearness * near + same
    return total


@njit(**CACHED)
def standing_evidence(
    one: Floats, other: Floats, facing: float, other_facing: float, w: PairEvidenceParameters
) -> float:
    """Evidence of two standing people: a common o-space, or nearness if a heading is unknown.

    The centre of the o-space of an F-formation (Kendon) lies ``o_space_offset`` ahead of each
    member. Two people share it if their centres are near each other and neither is behind:

        e = prior + facing (1 − o² / o_space_distance²)
            − behind (max(−¼ − cos β, 0) + max(−¼ − cos β', 0))

    with o the distance of the centres and β the bearing of the other; −cos β > ¼ is behind the
    shoulders. With an unknown heading,
    e = prior + nearness (1 − d² / standing_distance²), at most half of ``max_evidence``.
    """
    dx, dy = other[0] - one[0], other[1] - one[1]
    d = math.hypot(dx, dy)
    if math.isnan(facing) or math.isnan(other_facing):
        e = w.standing_prior + w.nearness * (1.0 - (d / w.standing_distance) ** 2)
        return min(e, 0.5 * w.max_evidence)
    cx, cy = math.cos(facing), math.sin(facing)
    ox, oy = math.cos(other_facing), math.sin(other_facing)
    apart = math.hypot(dx + w.o_space_offset * (ox - cx), dy + w.o_space_offset * (oy - cy))
    ahead = (cx * dx + cy * dy) / max(d, 1e-9)
    other_ahead = -(ox * dx + oy * dy) / max(d, 1e-9)
    turned = max(-0.25 - ahead, 0.0) + max(-0.25 - other_ahead, 0.0)
    total: float = w.standing_prior + w.facing * (1.0 - (apart / w.o_space_distance) ** 2)
    total -= w.behind * turned
    return total
