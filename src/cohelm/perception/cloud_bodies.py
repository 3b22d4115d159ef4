"""What segments of columns look like: height, width, head, roundness, and where their centre is."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.perception.cloud_segments import hidden_ends
from cohelm.perception.columns import LAYER, LAYERS

_TORSO = (0.8, 1.5)
"""Heights between which a body's width is taken, m."""
_LEGS = (0.2, 0.6)
"""Heights at which legs are looked for, m."""
_HEAD = 0.1
"""The head is taken to be the topmost layer and this much below it, m."""
_AXES = 0.24**2 + 0.13**2
"""a² + b² of a clothed adult's torso, m² (breadth 0.48 m, depth 0.26 m: assumed)."""
_LEAST_HALF, _MOST_HALF = 0.12, 0.25
"""Bounds of half a body's breadth and depth, m."""
_HEAD_RADIUS = 0.09
"""m."""


FIELDS = 14
MEAN_X, MEAN_Y, CENTRE_X, CENTRE_Y, RADIUS, RETURNS, TOP, BOTTOM = range(8)
WIDTH, DEPTH, HEAD, SHEER, FILLED, HIDDEN = range(8, FIELDS)
"""Of a segment, lengths in m: the mean of its returns, eq. (3), and the centre of the body behind
them; its radius; how many returns; how high it begins and ends; its width across the line of sight
and its depth along it, at the torso; the width of its topmost part; the share of the torso's
columns that reach down over the legs, as a wall's do, NaN where either is out of view; the share of
the layers from bottom to top in which something came back; how many of its ends are hidden."""


@njit(cache=True)
def looks(  # noqa: PLR0917  # a kernel takes arrays and numbers
    centre: Floats,
    count: Integers,
    lowest: Floats,
    highest: Floats,
    layers: Integers,
    labels: Integers,
    line: Floats,
    gaps: Floats,
) -> Floats:
    """What each of s segments looks like, (s, FIELDS).

    Args:
        centre, count, lowest, highest, layers: of the columns, see ``Columns``.
        labels: (q,) segment of each column, −1: none.
        line: the skyline.
        gaps: (2,) angles between neighbouring azimuths, and elevations, rad.
    """
    s = labels.max() + 1 if labels.size else 0
    out = np.zeros((s, FIELDS))
    order = np.argsort(labels, kind="mergesort")
    first = np.searchsorted(labels[order], np.arange(s + 1))
    torso_bits, leg_bits = _bits(_TORSO[0], _TORSO[1]), _bits(_LEGS[0], _LEGS[1])
    for k in range(s):
        members = order[first[k] : first[k + 1]]
        total = count[members].sum()
        mx = (centre[members, 0] * count[members]).sum() / total
        my = (centre[members, 1] * count[members]).sum() / total
        away = max(math.hypot(mx, my), 1e-9)
        ux, uy = mx / away, my / away
        across = -uy * centre[members, 0] + ux * centre[members, 1]
        along = ux * centre[members, 0] + uy * centre[members, 1]
        union = 0
        for i in members:
            union |= layers[i]
        bottom = lowest[members].min()
        last = _last_layer(union, gaps[1] * away)
        top = min(highest[members].max(), (last + 1) * LAYER)
        if last * LAYER > highest[members].max():
            top = (last + 0.5) * LAYER
        torso = (layers[members] & torso_bits) != 0
        legs = (layers[members] & leg_bits) != 0
        sheer = (torso & legs).sum() / torso.sum() if torso.any() and legs.any() else np.nan
        if not torso.any():
            torso[:] = True
        head = (layers[members] & _bits(last * LAYER - _HEAD, (last + 1) * LAYER)) != 0
        right, left = hidden_ends(centre[members[torso]], line)
        side, behind, radius = _middle(across, along, torso, head, top, gaps[0] * away)
        out[k, MEAN_X], out[k, MEAN_Y] = mx, my
        out[k, CENTRE_X] = -uy * side + ux * behind
        out[k, CENTRE_Y] = ux * side + uy * behind
        out[k, RADIUS], out[k, RETURNS], out[k, TOP], out[k, BOTTOM] = radius, total, top, bottom
        out[k, WIDTH] = across[torso].max() - across[torso].min()
        out[k, DEPTH] = along[torso].max() - along[torso].min()
        out[k, HEAD] = across[head].max() - across[head].min()
        out[k, SHEER], out[k, FILLED] = sheer, _filled(union, bottom, top)
        out[k, HIDDEN] = int(right) + int(left)
    return out


@njit(cache=True)
def _middle(  # a kernel takes arrays and numbers
    across: Floats, along: Floats, torso: Booleans, head: Booleans, top: float, gap: float
) -> tuple[float, float, float]:
    """(across, along, radius) of the body's centre, m.

    A torso is an ellipse of semi-axes a and b. Seen from any side, half its breadth W across the
    line of sight and the distance D from its nearest tangent to its centre have W² + D² = a² + b².
    """
    low, high = across[torso].min(), across[torso].max()
    half = min(0.5 * (high - low + gap), _MOST_HALF)
    deep = math.sqrt(max(_AXES - half * half, _LEAST_HALF**2))
    side, behind = 0.5 * (low + high), along[torso].min() + deep
    if top > 1.2 and head.sum() >= 1:
        low, high = across[head].min(), across[head].max()
        if high - low < 0.35:
            side = 0.5 * (side + 0.5 * (low + high))
            behind = 0.5 * (behind + along[head].min() + _HEAD_RADIUS)
    return side, behind, max(half, deep)


@njit(cache=True)
def _bits(low: float, high: float) -> int:
    """The layers between two heights."""
    bits = 0
    for k in range(max(round(low / LAYER), 0), round(high / LAYER)):
        bits |= 1 << k
    return bits


@njit(cache=True)
def _last_layer(layers: int, gap: float) -> int:
    """The layer up to which a thing goes on in steps of at most a gap between rings and 0.2 m."""
    last, most = -1, 2 + math.ceil(1.5 * gap / LAYER)
    for k in range(LAYERS):
        if (layers >> k) & 1 and (last < 0 or k - last <= most or k * LAYER < _TORSO[0]):
            last = k
    return last


@njit(cache=True)
def _filled(layers: int, bottom: float, top: float) -> float:
    """Share of the layers between two heights that are occupied."""
    low, high = max(int(bottom / LAYER), 0), min(max(int(top / LAYER), 0), LAYERS - 1)
    met = 0
    for k in range(low, high + 1):
        met += (layers >> k) & 1
    return met / (high - low + 1)


@njit(cache=True)
def touching(centre: Floats, labels: Integers, asked: Booleans, near: float, bodies: int) -> Floats:
    """Share of each segment's columns (q, 2) within ``near``, m, of another thing's; (bodies,).

    Args:
        centre: (q, 2) m.
        labels: (q,) segment of each; ``bodies`` and more, or −1, is something else.
        asked: (q,) which columns count.
        near: m.
        bodies: how many segments there are.
    """
    size, met = np.zeros(bodies), np.zeros(bodies)
    chosen = np.flatnonzero(asked)
    if chosen.size == 0:
        return size
    # squares of side ``near``: whoever is within it lies in the same or the next ones
    left, low = centre[chosen, 0].min(), centre[chosen, 1].min()
    rows = int((centre[chosen, 1].max() - low) / near) + 3
    cols = int((centre[chosen, 0].max() - left) / near) + 3
    square = np.empty(chosen.size, dtype=np.int64)
    for a in range(chosen.size):
        row = int((centre[chosen[a], 1] - low) / near) + 1
        square[a] = row * cols + int((centre[chosen[a], 0] - left) / near) + 1
    begin = np.zeros(rows * cols + 1, dtype=np.int64)
    for a in range(chosen.size):
        begin[square[a] + 1] += 1
    begin = np.cumsum(begin)
    columns = chosen[np.argsort(square, kind="mergesort")]
    for a in range(chosen.size):
        i = chosen[a]
        if labels[i] < 0 or labels[i] >= bodies:
            continue
        size[labels[i]] += 1.0
        met[labels[i]] += _meets(centre, labels, columns, begin, i, square[a], cols, near)
    return met / np.maximum(size, 1.0)


@njit(cache=True)
def _meets(  # noqa: PLR0917  # a kernel takes arrays and numbers
    centre: Floats,
    labels: Integers,
    columns: Integers,
    begin: Integers,
    i: int,
    square: int,
    cols: int,
    near: float,
) -> bool:
    """Whether another thing's column lies within ``near`` of column ``i``, in its ``square``."""
    for row in range(-1, 2):
        first = square + row * cols
        for b in range(begin[first - 1], begin[first + 2]):
            j = columns[b]
            if labels[j] != labels[i]:
                apart = math.hypot(centre[j, 0] - centre[i, 0], centre[j, 1] - centre[i, 1])
                if apart <= near:
                    return True
    return False


@njit(cache=True)
def join_low(  # a kernel takes arrays and numbers
    centre: Floats,
    labels: Integers,
    low: Floats,
    clusters: Integers,
    near: float,
    count: int,
) -> Integers:
    """Number of each low column: that of the body whose legs it is, or of its own cluster.

    A cluster of low columns no wider than ``near`` belongs to the nearest segment, no wider than
    a person, whose mean lies within ``near``; others are numbered from ``count``.

    Args:
        centre: (q, 2) of all columns.
        labels: (q,) segment of each, −1: none.
        low: (k, 2) low columns.
        clusters: (k,) of low ones, −1: none.
        near: m.
        count: of segments.
    """
    box = np.empty((count, 4))
    box[:, :2], box[:, 2:] = np.inf, -np.inf
    for i in range(labels.size):
        if labels[i] >= 0:
            b = box[labels[i]]
            b[0], b[1] = min(b[0], centre[i, 0]), min(b[1], centre[i, 1])
            b[2], b[3] = max(b[2], centre[i, 0]), max(b[3], centre[i, 1])
    groups = clusters.max() + 1 if clusters.size else 0
    span = np.empty((groups, 4))
    span[:, :2], span[:, 2:] = np.inf, -np.inf
    for i in range(clusters.size):
        if clusters[i] >= 0:
            s = span[clusters[i]]
            s[0], s[1] = min(s[0], low[i, 0]), min(s[1], low[i, 1])
            s[2], s[3] = max(s[2], low[i, 0]), max(s[3], low[i, 1])
    number = np.arange(count, count + groups)
    for g in range(groups):
        s = span[g]
        if max(s[2] - s[0], s[3] - s[1]) > near:
            continue
        best = near
        for k in range(count):
            b = box[k]
            if max(b[2] - b[0], b[3] - b[1]) > 2.0 * near:
                continue
            dx = 0.5 * (s[0] + s[2] - b[0] - b[2])
            dy = 0.5 * (s[1] + s[3] - b[1] - b[3])
            if math.hypot(dx, dy) < best:
                best, number[g] = math.hypot(dx, dy), k
    out = np.full(clusters.size, -1, dtype=np.int64)
    for i in range(clusters.size):
        if clusters[i] >= 0:
            out[i] = number[clusters[i]]
    return out
