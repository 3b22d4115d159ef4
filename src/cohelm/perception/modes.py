"""A bank of filters over what people may be up to: interacting modes of motion.

In each of m modes a person's velocity v is drawn to an aim c within a settling time τ, and white
noise of intensity q drives it::

    dp = v dt,    dv = (c − v) dt / τ + √q dw                                            (1)

τ = ∞ for who keeps going. The aim is the person's wont u, the velocity of who kept going lately,
shrunk to 0 for who stops and turned about or aside for who turns. Everybody leaves a mode i at the
rate λ_i and takes one anew, j with the share s_j::

    P(j | i) = e^{−λ_i t} δ_ij + (1 − e^{−λ_i t}) s_j                                    (2)

Positions seen weigh the modes by their likelihood and correct each mode's state (the interacting
multiple model filter of Blom and Bar-Shalom, 1988). People are not as tidy as the modes: the
likelihood is that of Student's distribution with ν degrees of freedom, for off beside a mode's
expectation with variance S ::

    p(off) ∝ (1 + |off|² / ν S)^{−(ν + 2)/2} / S                                         (3)

so that one odd look alone proves little. Noise is the same on both axes, which therefore share one
covariance of (p, v).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Integers, Shape, value

_LEAST = 1e-6
"""No mode's probability falls below it: what is ruled out for good could never be seen again."""


@value
class ModeTable:
    """What the modes are; those of who keeps going have no settling time."""

    hypothesis: Annotated[Integers, Shape("m")]
    """Which hypothesis each is a manner of."""
    share: Annotated[Floats, Shape("m")]
    """s of eq. (2), together 1."""
    rate: Annotated[Floats, Shape("m")]
    """λ of eq. (2), 1/s."""
    settling: Annotated[Floats, Shape("m")]
    """τ of eq. (1), s; +inf: the velocity is kept."""
    agility: Annotated[Floats, Shape("m")]
    """q of eq. (1) from one look to the next, m²/s³."""
    aim: Annotated[Floats, Shape("m 2")]
    """The aim c = a u + b u^⊥, u^⊥ to the left."""
    wander: Annotated[Floats, Shape("m")]
    """q of eq. (1) over the time ahead, m²/s³: more comes up there than from look to look."""
    doubt: Annotated[Floats, Shape("m")]
    """Deviation of the velocity that is come to in the end, as a share of |u|."""
    stir: Annotated[Floats, Shape("m")]
    """The same for anybody, m/s: who stands may start."""

    @property
    def usual(self) -> Floats:
        """(m,), the probabilities at which eq. (2) comes to rest."""
        odds = self.share / self.rate
        usual: Floats = odds / odds.sum()
        return usual


@value
class ModeState:
    """What is known of n people."""

    id: Annotated[Integers, Shape("n")]
    time: Annotated[Floats, Shape("n")]
    """Of the last look that counted, s."""
    mean: Annotated[Floats, Shape("n m 4")]
    """(x, y, v_x, v_y) in each mode then, m and m/s."""
    covariance: Annotated[Floats, Shape("n m 3")]
    """(P_pp, P_pv, P_vv) of either axis."""
    weight: Annotated[Floats, Shape("n m")]
    """Probabilities of the modes."""
    wont: Annotated[Floats, Shape("n 2")]
    """u, m/s."""
    told: Annotated[Floats, Shape("n 4")]
    """The tracker's mean at that look."""
    told_covariance: Annotated[Floats, Shape("n 3")]
    """The tracker's (P_pp, P_pv, P_vv) at that look, averaged over the axes."""


@njit(cache=True)
def drift(t: float, tau: float, q: float) -> tuple[float, float, float, float, float]:
    """(a, g, Q_pp, Q_pv, Q_vv): what a time ``t`` makes of eq. (1).

    a = e^{−t/τ}, g = τ (1 − a):  v − c ← a (v − c),  p ← p + c t + g (v − c), with noise Q.
    """
    if t < 1e-3 * tau:
        return 1.0, t, q * t**3 / 3.0, q * t * t / 2.0, q * t
    a = np.exp(-t / tau)
    g = tau * (1.0 - a)
    half = 0.5 * tau * (1.0 - a * a)
    return a, g, q * tau * tau * (t - 2.0 * g + half), 0.5 * q * g * g, q * half


@njit(cache=True)
def look(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    dt: Floats,
    position: Floats,
    variance: Floats,
    mean: Floats,
    covariance: Floats,
    weight: Floats,
    wont: Floats,
    share: Floats,
    rate: Floats,
    settling: Floats,
    agility: Floats,
    aim: Floats,
    habit: float,
    tails: float,
) -> None:
    """Everybody ``dt`` (n,) > 0 later, seen at ``position`` (n, 2) of ``variance`` (n,).

    The state's arrays, as in ``ModeState``, are changed in place; the modes' as in ``ModeTable``.

    Args:
        habit: time constant with which u follows who keeps going, s.
        tails: ν of eq. (3).
    """
    n, modes = weight.shape
    log_w = np.empty(modes)
    for i in range(n):
        t, x, C, w, u = dt[i], mean[i], covariance[i], weight[i], wont[i]
        _mix(t, x, C, w, share, rate)
        for m in range(modes):
            a, g, qpp, qpv, qvv = drift(t, settling[m], agility[m])
            pp = C[m, 0] + 2.0 * g * C[m, 1] + g * g * C[m, 2] + qpp
            pv = a * (C[m, 1] + g * C[m, 2]) + qpv
            vv = a * a * C[m, 2] + qvv
            S = pp + variance[i]
            kp, kv = pp / S, pv / S
            squared = 0.0
            for k in range(2):
                c = x[m, k + 2]
                if settling[m] < np.inf:
                    c = aim[m, 0] * u[k] + aim[m, 1] * (u[0] if k == 1 else -u[1])
                e = x[m, k + 2] - c
                ahead = x[m, k] + c * t + g * e
                off = position[i, k] - ahead
                x[m, k] = ahead + kp * off
                x[m, k + 2] = c + a * e + kv * off
                squared += off * off
            C[m, 0], C[m, 1], C[m, 2] = (1.0 - kp) * pp, (1.0 - kp) * pv, vv - kv * pv
            log_w[m] = np.log(w[m] / S) - (0.5 * tails + 1.0) * np.log1p(squared / (tails * S))
        top, total = log_w.max(), 0.0
        for m in range(modes):
            w[m] = max(np.exp(log_w[m] - top), _LEAST)
            total += w[m]
        follow, before_x, before_y = 1.0 - np.exp(-t / habit), u[0], u[1]
        for m in range(modes):
            w[m] /= total
            if settling[m] == np.inf:
                u[0] += w[m] * follow * (x[m, 2] - before_x)
                u[1] += w[m] * follow * (x[m, 3] - before_y)


@njit(cache=True)
def _mix(t: float, x: Floats, C: Floats, w: Floats, share: Floats, rate: Floats) -> None:
    """Eq. (2) for one person: states (m, 4) and (m, 3), probabilities (m,); in place.

    Those who leave their modes are pooled, with one mean and one covariance, and shared out.
    """
    modes = len(w)
    pool = 0.0
    mean, spread = np.zeros(4), np.zeros(3)
    for m in range(modes):
        leaves = w[m] * (1.0 - np.exp(-rate[m] * t))
        pool += leaves
        for k in range(4):
            mean[k] += leaves * x[m, k]
    for k in range(4):
        mean[k] /= pool
    for m in range(modes):
        _add(spread, C[m], x[m], mean, w[m] * (1.0 - np.exp(-rate[m] * t)) / pool, 1.0)
    for m in range(modes):
        stays = w[m] * np.exp(-rate[m] * t)
        w[m] = stays + share[m] * pool
        s = stays / w[m]
        own = C[m].copy()
        for k in range(3):
            C[m, k] = (1.0 - s) * spread[k]
        _add(C[m], own, x[m], mean, s, 1.0 - s)
        for k in range(4):
            x[m, k] = mean[k] + s * (x[m, k] - mean[k])


@njit(cache=True)
def _add(  # a kernel takes plain arrays
    total: Floats, C: Floats, x: Floats, mean: Floats, share: float, apart: float
) -> None:
    """Add a share of (P_pp, P_pv, P_vv), and ``apart`` of it times the spread of x about a mean.

    The spread is averaged over both axes.
    """
    for k in range(3):
        total[k] += share * C[k]
    for k in range(2):
        p, v = x[k] - mean[k], x[k + 2] - mean[k + 2]
        total[0] += 0.5 * share * apart * p * p
        total[1] += 0.5 * share * apart * p * v
        total[2] += 0.5 * share * apart * v * v
