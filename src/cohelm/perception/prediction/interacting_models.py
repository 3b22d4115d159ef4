"""Interacting multiple models (IMM): a bank of filters over possible motions of a person.

In each of m models a person's velocity v approaches a target c with time constant τ, driven by
white noise of intensity q::

    dp = v dt,    dv = (c − v) dt / τ + √q dw                                            (1)

τ = ∞ for a person who keeps going. The target is derived from the person's nominal velocity u, the
recent velocity while keeping going: 0 for stopping, reversed or turned aside for turning. A person
leaves model i at the rate λ_i and enters model j with probability s_j::

    P(j | i) = e^{−λ_i t} δ_ij + (1 − e^{−λ_i t}) s_j                                    (2)

Observed positions weigh the models by their likelihood and correct each model's state (the
interacting multiple model filter of Blom and Bar-Shalom, 1988). People deviate from the models: the
likelihood is Student's distribution with ν degrees of freedom, for a distance d from a model's
expectation with variance S ::

    p(d) ∝ (1 + |d|² / ν S)^{−(ν + 2)/2} / S                                             (3)

so that one outlier proves little. Both axes have equal noise and share one covariance of (p, v).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.kernels import CACHED, callee

_MIN_WEIGHT = 1e-6
"""Lower bound of a model's probability, before normalisation: an excluded model never returns."""


class ModelBank(NamedTuple):
    """Motion models; m of them. Models that keep going have an infinite time constant."""

    hypothesis: Integers
    """(m,) hypothesis of each model."""
    entry_probability: Floats
    """(m,) s of eq. (2), of sum 1."""
    exit_rate: Floats
    """(m,) λ of eq. (2), 1/s."""
    time_constant: Floats
    """(m,) τ of eq. (1), s; +inf: the velocity is kept."""
    process_noise: Floats
    """(m,) q of eq. (1) between observations, m²/s³."""
    target: Floats
    """(m, 2) coefficients (a, b) of c = a u + b u^⊥, u^⊥ to the left."""
    horizon_noise: Floats
    """(m,) q of eq. (1) over the prediction horizon, m²/s³."""
    speed_uncertainty: Floats
    """(m,) deviation of the final velocity, as a share of |u|."""
    velocity_deviation: Floats
    """(m,) deviation of the final velocity at any speed, m/s: a standing person may start."""
    nominal_time_constant: float
    """Time constant with which u follows a person who keeps going, s."""
    student_dof: float
    """ν of eq. (3)."""

    @property
    def stationary(self) -> Floats:
        """(m,), the stationary probabilities of eq. (2)."""
        odds = self.entry_probability / self.exit_rate
        stationary: Floats = odds / odds.sum()
        return stationary


class FilterStates(NamedTuple):
    """Filter states of n people, as in :class:`ImmState`."""

    mean: Floats
    covariance: Floats
    mode_probability: Floats
    nominal_velocity: Floats


@value
class ImmState:
    """Memory of the filters; n people."""

    id: Annotated[Integers, Shape("n")]
    time: Annotated[Floats, Shape("n")]
    """Time of the last observation used, s."""
    mean: Annotated[Floats, Shape("n m 4")]
    """(x, y, v_x, v_y) in each model at that time, m and m/s."""
    covariance: Annotated[Floats, Shape("n m 3")]
    """(P_pp, P_pv, P_vv) of either axis."""
    mode_probability: Annotated[Floats, Shape("n m")]
    """Probabilities of the models."""
    nominal_velocity: Annotated[Floats, Shape("n 2")]
    """u, m/s."""
    tracker_mean: Annotated[Floats, Shape("n 4")]
    """The tracker's mean at that time."""
    tracker_covariance: Annotated[Floats, Shape("n 3")]
    """The tracker's (P_pp, P_pv, P_vv) at that time, averaged over the axes."""


class Horizon(NamedTuple):
    """Prediction of n people over K times, in h hypotheses."""

    weight: Floats
    """(n, h) probabilities of the hypotheses."""
    displacement: Floats
    """(n, h, K, 2) from the present position, m."""
    velocity: Floats
    """(n, h, K, 2) m/s."""
    deviation: Floats
    """(n, h, K) m."""


@njit(**CACHED)
def transition_coefficients(
    t: float, tau: float, q: float
) -> tuple[float, float, float, float, float]:
    """Compute (a, g, Q_pp, Q_pv, Q_vv), the solution of eq. (1) after a time ``t``.

    a = e^{−t/τ}, g = τ (1 − a):  v − c ← a (v − c),  p ← p + c t + g (v − c), with noise Q.
    """
    if t < 1e-3 * tau:
        return 1.0, t, q * t**3 / 3.0, q * t * t / 2.0, q * t
    a = np.exp(-t / tau)
    g = tau * (1.0 - a)
    half = 0.5 * tau * (1.0 - a * a)
    return a, g, q * tau * tau * (t - 2.0 * g + half), 0.5 * q * g * g, q * half


@njit(**CACHED)
def update_models(
    dt: Floats, position: Floats, variance: Floats, states: FilterStates, bank: ModelBank
) -> None:
    """Predict all people by ``dt`` (n,) > 0 and update them with observed positions, in place.

    Args:
        dt: s.
        position: (n, 2) m.
        variance: (n,) m².
        states: of the filters, changed in place.
        bank: the models.
    """
    n, modes = states.mode_probability.shape
    dof, target = bank.student_dof, bank.target
    log_w = np.empty(modes)
    for i in range(n):
        t, x, C = dt[i], states.mean[i], states.covariance[i]
        w, u = states.mode_probability[i], states.nominal_velocity[i]
        _mix(t, x, C, w, bank)
        # Each model: prediction by eq. (1), Kalman update, log-likelihood by eq. (3).
        for m in range(modes):
            a, g, qpp, qpv, qvv = transition_coefficients(
                t, bank.time_constant[m], bank.process_noise[m]
            )
            pp = C[m, 0] + 2.0 * g * C[m, 1] + g * g * C[m, 2] + qpp
            pv = a * (C[m, 1] + g * C[m, 2]) + qpv
            vv = a * a * C[m, 2] + qvv
            S = pp + variance[i]
            kp, kv = pp / S, pv / S
            squared = 0.0
            for k in range(2):
                c = x[m, k + 2]
                if bank.time_constant[m] < np.inf:
                    c = target[m, 0] * u[k] + target[m, 1] * (u[0] if k == 1 else -u[1])
                e = x[m, k + 2] - c
                predicted = x[m, k] + c * t + g * e
                innovation = position[i, k] - predicted
                x[m, k] = predicted + kp * innovation
                x[m, k + 2] = c + a * e + kv * innovation
                squared += innovation * innovation
            C[m, 0], C[m, 1], C[m, 2] = (1.0 - kp) * pp, (1.0 - kp) * pv, vv - kv * pv
            log_w[m] = np.log(w[m] / S) - (0.5 * dof + 1.0) * np.log1p(squared / (dof * S))
        # Normalised weights; then the nominal velocity follows the models that keep going.
        top, total = log_w.max(), 0.0
        for m in range(modes):
            w[m] = max(np.exp(log_w[m] - top), _MIN_WEIGHT)
            total += w[m]
        gain, before_x, before_y = 1.0 - np.exp(-t / bank.nominal_time_constant), u[0], u[1]
        for m in range(modes):
            w[m] /= total
            if bank.time_constant[m] == np.inf:
                u[0] += w[m] * gain * (x[m, 2] - before_x)
                u[1] += w[m] * gain * (x[m, 3] - before_y)


@callee()
def _mix(t: float, x: Floats, C: Floats, w: Floats, bank: ModelBank) -> None:
    """Eq. (2) for one person: states (m, 4) and (m, 3), probabilities (m,); in place.

    The part that leaves its models is pooled, with one mean and one covariance, and distributed.
    """
    modes, rate = len(w), bank.exit_rate
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
        w[m] = stays + bank.entry_probability[m] * pool
        s = stays / w[m]
        own = C[m].copy()
        for k in range(3):
            C[m, k] = (1.0 - s) * spread[k]
        _add(C[m], own, x[m], mean, s, 1.0 - s)
        for k in range(4):
            x[m, k] = mean[k] + s * (x[m, k] - mean[k])


@callee()
def _add(total: Floats, C: Floats, x: Floats, mean: Floats, share: float, apart: float) -> None:
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


@njit(**CACHED)
def predict_hypotheses(
    states: FilterStates, bank: ModelBank, since: Floats, times: Floats
) -> Horizon:
    """Predict people; the models of a hypothesis become one Gaussian of their mean and covariance.

    Args:
        states: of the filters at the last observation.
        bank: the models.
        since: (n,) time since the last observation, s.
        times: (K,) from now, s.
    """
    modes, tau = states.mode_probability, bank.time_constant
    (n, m), K, count = modes.shape, len(times), bank.hypothesis.max() + 1
    a, g, noise, target_gain = _responses(bank, times)
    weight, deviation = np.zeros((n, count)), np.zeros((n, count, K))
    displacement, velocity = np.zeros((n, count, K, 2)), np.zeros((n, count, K, 2))
    for i in range(n):
        u = states.nominal_velocity[i]
        for j in range(m):
            weight[i, bank.hypothesis[j]] += modes[i, j]
        for j in range(m):
            h = bank.hypothesis[j]
            r = modes[i, j] / weight[i, h]
            vx, vy = states.mean[i, j, 2], states.mean[i, j, 3]
            cx, cy = vx, vy
            if tau[j] < np.inf:
                cx = bank.target[j, 0] * u[0] - bank.target[j, 1] * u[1]
                cy = bank.target[j, 0] * u[1] + bank.target[j, 1] * u[0]
            # From the last observation to the present, by eq. (1).
            a0, g0, qpp, qpv, qvv = transition_coefficients(since[i], tau[j], bank.process_noise[j])
            ex, ey = a0 * (vx - cx), a0 * (vy - cy)
            C = states.covariance[i, j]
            pp = C[0] + 2.0 * g0 * C[1] + g0 * g0 * C[2] + qpp
            pv, vv = a0 * (C[1] + g0 * C[2]) + qpv, a0 * a0 * C[2] + qvv
            target_variance = bank.speed_uncertainty[j] ** 2 * (u[0] ** 2 + u[1] ** 2)
            target_variance += bank.velocity_deviation[j] ** 2
            for k in range(K):
                px, py = cx * times[k] + g[j, k] * ex, cy * times[k] + g[j, k] * ey
                var = pp + 2.0 * g[j, k] * pv + g[j, k] ** 2 * vv
                var += noise[j, k] + target_variance * target_gain[j, k] ** 2
                displacement[i, h, k, 0] += r * px
                displacement[i, h, k, 1] += r * py
                velocity[i, h, k, 0] += r * (cx + a[j, k] * ex)
                velocity[i, h, k, 1] += r * (cy + a[j, k] * ey)
                # Mean square over both axes; that of the mean is subtracted below.
                deviation[i, h, k] += r * (var + 0.5 * (px * px + py * py))
        for h in range(count):
            for k in range(K):
                square = displacement[i, h, k, 0] ** 2 + displacement[i, h, k, 1] ** 2
                variance = deviation[i, h, k] - 0.5 * square
                # Uncertainty never shrinks with time, although models of one hypothesis may meet.
                before = deviation[i, h, k - 1] if k > 0 else 0.0
                deviation[i, h, k] = max(np.sqrt(max(variance, 0.0)), before)
    return Horizon(weight, displacement, velocity, deviation)


@callee()
def _responses(bank: ModelBank, times: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Response (m, K) of each model to its initial state, which is the same for all people.

    Returns:
        Share of the velocity that is left; displacement per velocity, s; variance of the position,
        m²; displacement per error of the final velocity, s.
    """
    tau = bank.time_constant
    m, K = len(tau), len(times)
    a, g, noise = np.empty((m, K)), np.empty((m, K)), np.empty((m, K))
    target_gain = np.empty((m, K))
    for j in range(m):
        for k in range(K):
            a[j, k], g[j, k], noise[j, k], _, _ = transition_coefficients(
                times[k], tau[j], bank.horizon_noise[j]
            )
            target_gain[j, k] = times[k] - (g[j, k] if tau[j] < np.inf else 0.0)
    return a, g, noise, target_gain
