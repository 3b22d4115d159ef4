"""Shape of segments of columns, and the probability that such a shape is a person."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.array_kernels import members_by_label
from cohelm.arrays import Booleans, Floats, Integers
from cohelm.kernels import CACHED
from cohelm.perception.cloud_detection.columns import LAYER, LAYERS, Columns
from cohelm.perception.cloud_detection.segmentation import occluded_ends
from cohelm.perception.preprocessing.merged_cloud import MergedCloud

_TORSO = (0.8, 1.5)
"""Heights at which a body's width is measured, m."""
_LEGS = (0.2, 0.6)
"""Heights of legs, m."""
_HEAD = 0.1
"""The head is the topmost layer and this much below it, m."""
_AXES = 0.24**2 + 0.13**2
"""a² + b² of a clothed adult's torso, m² (breadth 0.48 m, depth 0.26 m: assumed)."""
_MIN_HALF, _MAX_HALF = 0.12, 0.25
"""Bounds of half a body's breadth and depth, m."""
_HEAD_RADIUS = 0.09
"""m."""
_RANGE_END = 0.5
"""An object nearer than this to the end of a sensor's range may extend beyond it, m."""
_FULL_RETURNS = 25.0
"""Number of returns from which positive evidence counts in full."""
_VIEW_MARGIN, _KNEE = 0.15, 0.3
"""The top of an object is visible if the view ends this far above it, and its legs if the view
begins below this height, m."""


class ShapeFeatures(NamedTuple):
    """Features of s segments, lengths in m."""

    mean: Floats
    """(s, 2) mean of the returns, Xu et al., eq. (3)."""
    centre: Floats
    """(s, 2) centre of the body behind them."""
    radius: Floats
    returns: Floats
    """Number of returns."""
    top: Floats
    bottom: Floats
    width: Floats
    """Width of the torso across the line of sight."""
    depth: Floats
    """Depth of the torso along the line of sight."""
    head: Floats
    """Width of the topmost part."""
    sheer: Floats
    """Share of the torso's columns that extend down over the legs, as a wall's do; NaN if either is
    out of view."""
    filled: Floats
    """Share of the layers from bottom to top with returns."""
    occluded: Floats
    """Number of occluded ends."""


@njit(**CACHED)
def shape_features(
    columns: Columns, labels: Integers, line: Floats, gaps: tuple[float, float]
) -> ShapeFeatures:
    """Compute the features of each segment.

    Args:
        columns: q columns.
        labels: (q,) segment of each column, −1: none.
        line: the skyline.
        gaps: angles between neighbouring azimuths, and elevations, rad.
    """
    s = labels.max() + 1 if labels.size else 0
    out = _no_features(s)
    centre, count = columns.centre, columns.returns
    order, first = members_by_label(labels, s)
    torso_bits, leg_bits = _bits(_TORSO[0], _TORSO[1]), _bits(_LEGS[0], _LEGS[1])
    for k in range(s):
        members = order[first[k] : first[k + 1]]
        highest, layers = columns.highest[members].max(), columns.occupied_layers[members]
        # Axes across and along the line of sight to the mean.
        total = count[members].sum()
        mx = (centre[members, 0] * count[members]).sum() / total
        my = (centre[members, 1] * count[members]).sum() / total
        distance = max(math.hypot(mx, my), 1e-9)
        ux, uy = mx / distance, my / distance
        across = -uy * centre[members, 0] + ux * centre[members, 1]
        along = ux * centre[members, 0] + uy * centre[members, 1]
        # The top is that of the connected layers: what hangs above is another object.
        union = 0
        for each in layers:
            union |= each
        bottom = columns.lowest[members].min()
        last = _last_layer(union, gaps[1] * distance)
        top = min(highest, (last + 1) * LAYER)
        if last * LAYER > highest:
            top = (last + 0.5) * LAYER
        torso = (layers & torso_bits) != 0
        legs = (layers & leg_bits) != 0
        sheer = (torso & legs).sum() / torso.sum() if torso.any() and legs.any() else np.nan
        if not torso.any():
            torso[:] = True
        head = (layers & _bits(last * LAYER - _HEAD, (last + 1) * LAYER)) != 0
        right, left = occluded_ends(centre[members[torso]], line)
        side, behind, radius = _body_centre(across, along, torso, head, top, gaps[0] * distance)
        out.mean[k, 0], out.mean[k, 1] = mx, my
        out.centre[k, 0] = -uy * side + ux * behind
        out.centre[k, 1] = ux * side + uy * behind
        out.radius[k], out.returns[k], out.top[k], out.bottom[k] = radius, total, top, bottom
        out.width[k] = across[torso].max() - across[torso].min()
        out.depth[k] = along[torso].max() - along[torso].min()
        out.head[k] = across[head].max() - across[head].min()
        out.sheer[k], out.filled[k] = sheer, _filled(union, bottom, top)
        out.occluded[k] = int(right) + int(left)
    return out


@njit(**CACHED)
def _no_features(s: int) -> ShapeFeatures:
    """Zeros for ``s`` segments."""
    return ShapeFeatures(
        mean=np.zeros((s, 2)),
        centre=np.zeros((s, 2)),
        radius=np.zeros(s),
        returns=np.zeros(s),
        top=np.zeros(s),
        bottom=np.zeros(s),
        width=np.zeros(s),
        depth=np.zeros(s),
        head=np.zeros(s),
        sheer=np.zeros(s),
        filled=np.zeros(s),
        occluded=np.zeros(s),
    )


@njit(**CACHED)
def _body_centre(
    across: Floats, along: Floats, torso: Booleans, head: Booleans, top: float, gap: float
) -> tuple[float, float, float]:
    """(across, along, radius) of the body's centre, m.

    A torso is an ellipse of semi-axes a and b. From any side, half its breadth W across the line of
    sight and the distance D from its nearest tangent to its centre have W² + D² = a² + b².
    """
    low, high = across[torso].min(), across[torso].max()
    half = min(0.5 * (high - low + gap), _MAX_HALF)
    deep = math.sqrt(max(_AXES - half * half, _MIN_HALF**2))
    side, behind = 0.5 * (low + high), along[torso].min() + deep
    # A narrow head at an adult's height is averaged with the torso.
    if top > 1.2 and head.sum() >= 1:
        low, high = across[head].min(), across[head].max()
        if high - low < 0.35:
            side = 0.5 * (side + 0.5 * (low + high))
            behind = 0.5 * (behind + along[head].min() + _HEAD_RADIUS)
    return side, behind, max(half, deep)


@njit(**CACHED)
def _bits(low: float, high: float) -> int:
    """Bits of the layers between two heights."""
    bits = 0
    for k in range(max(round(low / LAYER), 0), round(high / LAYER)):
        bits |= 1 << k
    return bits


@njit(**CACHED)
def _last_layer(layers: int, gap: float) -> int:
    """Topmost layer connected to the lowest by gaps of at most 1.5 ring gaps plus 0.2 m."""
    last, most = -1, 2 + math.ceil(1.5 * gap / LAYER)
    for k in range(LAYERS):
        if (layers >> k) & 1 and (last < 0 or k - last <= most or k * LAYER < _TORSO[0]):
            last = k
    return last


@njit(**CACHED)
def _filled(layers: int, bottom: float, top: float) -> float:
    """Share of the layers between two heights that are occupied."""
    low, high = max(int(bottom / LAYER), 0), min(max(int(top / LAYER), 0), LAYERS - 1)
    met = 0
    for k in range(low, high + 1):
        met += (layers >> k) & 1
    return met / (high - low + 1)


def person_log_odds(shape: ShapeFeatures, beside: Floats, cloud: MergedCloud) -> Floats:
    """ln(p / (1 − p)) that each of s segments is a person, from its shape alone; (s,).

    Sum of independent bounded evidence; assumed. Parts that are out of view, occluded, or between
    the sensor's rings give no evidence. A segment cut by the end of the range may be part of
    anything, and gets no positive evidence.

    Args:
        shape: of the segments.
        beside: (s,) share of its columns that touch another object's.
        cloud: the sensors' positions, views and resolution.
    """
    distance = np.hypot(shape.mean[:, 0], shape.mean[:, 1])
    lowest, highest = cloud.in_view(shape.mean)
    above = highest - shape.top > _VIEW_MARGIN
    below = lowest < _KNEE
    occluded = shape.occluded > 0.0
    aside, upright = cloud.azimuth_step * distance, cloud.elevation_step * distance
    sharp = np.clip(1.5 - 5.0 * upright, 0.0, 1.0)
    # The summands below are assumed; each is bounded, and 0 where its part is not visible.
    odds = _height_log_odds(shape.top, upright, above)
    odds += _width_log_odds(shape.width + aside, occluded)
    odds += sharp * _head_log_odds((shape.head + aside) / (shape.width + aside), above)
    # Walls and furniture are as wide below as above, a person stands on legs.
    sheer = shape.sheer
    odds += np.where(np.isnan(sheer) | ~below, 0.0, np.clip(10.0 * (0.5 - sheer), -2.0, 1.5))
    # A body has no gaps from bottom to top, and reaches down to its knees at least.
    odds -= 3.0 * sharp * (1.0 - shape.filled)
    odds -= np.where(below & ~occluded, 3.0 * np.clip(shape.bottom - 0.7, 0.0, 0.7), 0.0)
    # A person is not deep, and touches nothing.
    odds -= 4.0 * np.clip(shape.depth - 0.45, 0.0, 0.5)
    odds -= 4.0 * beside
    few = np.minimum(shape.returns / _FULL_RETURNS, 1.0)
    cut = cloud.range_left(shape.mean) < _RANGE_END
    return np.where(odds > 0.0, np.where(cut, 0.0, few * odds), odds)


def _height_log_odds(top: Floats, gap: Floats, visible: Booleans) -> Floats:
    """Evidence of the height (s,): an adult's is likely, a child's less; none is above 2.0 m."""
    odds = np.where(visible, 0.4 - 5.0 * np.clip(1.4 - top - gap, 0.0, 0.6), 0.0)
    return odds - 12.0 * np.clip(top - 2.0, 0.0, 0.4)


def _width_log_odds(width: Floats, occluded: Booleans) -> Floats:
    """Evidence of the torso's breadth (s,); a narrow, partly occluded one gives none."""
    thin = np.clip(0.22 - width, 0.0, 0.2)
    wide = np.clip(width - 0.7, 0.0, 0.4)
    return np.where(occluded & (width < 0.35), 0.0, 0.6 - 20.0 * thin - 10.0 * wide)


def _head_log_odds(share: Floats, visible: Booleans) -> Floats:
    """Evidence of the head's share (s,) of the breadth: a head or neck is narrower than the torso.

    If the view ends below the top, a narrower topmost part is weak evidence only: the view ends
    higher on farther parts.
    """
    odds = np.clip(8.0 * (0.8 - share), -1.5, 1.5)
    return np.where(visible, odds, np.clip(odds, 0.0, 0.5))
