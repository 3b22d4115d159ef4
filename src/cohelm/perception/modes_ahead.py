"""Where the modes of motion lead over a horizon, gathered into hypotheses."""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.perception.modes import ModeState, ModeTable, drift


def ahead(
    state: ModeState, table: ModeTable, since: Floats, times: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """(weight (n, h), way (n, h, K, 2), velocity (n, h, K, 2), deviation (n, h, K)).

    The modes of a hypothesis become one Gaussian of their mean and covariance.

    Args:
        state: of n people, at the last look.
        table: the modes.
        since: how long ago that was, (n,) s.
        times: ahead of now, (K,) s; ways are from where a person is now, m.
    """
    n, h, K = len(state.id), int(table.hypothesis.max()) + 1, len(times)
    weight, deviation = np.zeros((n, h)), np.empty((n, h, K))
    way, velocity = np.empty((n, h, K, 2)), np.empty((n, h, K, 2))
    _ahead(
        since,
        times,
        state.mean,
        state.covariance,
        state.weight,
        state.wont,
        table.hypothesis,
        table.settling,
        table.agility,
        table.aim,
        table.wander,
        table.doubt,
        table.stir,
        weight,
        way,
        velocity,
        deviation,
    )
    return weight, way, velocity, deviation


@njit(cache=True)
def _ahead(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    since: Floats,
    times: Floats,
    mean: Floats,
    covariance: Floats,
    modes: Floats,
    wont: Floats,
    hypothesis: Integers,
    settling: Floats,
    agility: Floats,
    aim: Floats,
    wander: Floats,
    doubt: Floats,
    stir: Floats,
    weight: Floats,
    way: Floats,
    velocity: Floats,
    deviation: Floats,
) -> None:
    (n, m), K = modes.shape, len(times)
    a, g, noise, slip = np.empty((m, K)), np.empty((m, K)), np.empty((m, K)), np.empty((m, K))
    for j in range(m):
        for k in range(K):
            a[j, k], g[j, k], noise[j, k], _, _ = drift(times[k], settling[j], wander[j])
            slip[j, k] = times[k] - (g[j, k] if settling[j] < np.inf else 0.0)
    way[:] = 0.0
    velocity[:] = 0.0
    deviation[:] = 0.0
    for i in range(n):
        u = wont[i]
        for j in range(m):
            weight[i, hypothesis[j]] += modes[i, j]
        for j in range(m):
            h = hypothesis[j]
            r = modes[i, j] / weight[i, h]
            cx, cy = mean[i, j, 2], mean[i, j, 3]
            if settling[j] < np.inf:
                cx = aim[j, 0] * u[0] - aim[j, 1] * u[1]
                cy = aim[j, 0] * u[1] + aim[j, 1] * u[0]
            fade, gone, qpp, qpv, qvv = drift(since[i], settling[j], agility[j])
            ex, ey = fade * (mean[i, j, 2] - cx), fade * (mean[i, j, 3] - cy)
            C = covariance[i, j]
            pp = C[0] + 2.0 * gone * C[1] + gone * gone * C[2] + qpp
            pv, vv = fade * (C[1] + gone * C[2]) + qpv, fade * fade * C[2] + qvv
            blur = doubt[j] ** 2 * (u[0] ** 2 + u[1] ** 2) + stir[j] ** 2
            for k in range(K):
                px, py = cx * times[k] + g[j, k] * ex, cy * times[k] + g[j, k] * ey
                var = pp + 2.0 * g[j, k] * pv + g[j, k] ** 2 * vv
                var += noise[j, k] + blur * slip[j, k] ** 2
                way[i, h, k, 0] += r * px
                way[i, h, k, 1] += r * py
                velocity[i, h, k, 0] += r * (cx + a[j, k] * ex)
                velocity[i, h, k, 1] += r * (cy + a[j, k] * ey)
                # both axes' mean square for now; less that of the mean below
                deviation[i, h, k] += r * (var + 0.5 * (px * px + py * py))
        for h in range(weight.shape[1]):
            for k in range(K):
                square = way[i, h, k, 0] ** 2 + way[i, h, k, 1] ** 2
                left = deviation[i, h, k] - 0.5 * square
                before = deviation[i, h, k - 1] if k > 0 else 0.0
                deviation[i, h, k] = max(np.sqrt(max(left, 0.0)), before)
