"""Detector of people in the clouds of 3-D sensors: ground → columns → DBSCAN → shape.

Shape of segments of columns, and the probability that such a shape is a person.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.array_kernels import members_by_label
from cohelm.arrays import Booleans, Floats, Integers
from cohelm.config import Model
from cohelm.geometry import transform
from cohelm.kernels import CACHED, callee
from cohelm.maps import DistanceField
from cohelm.messages import PointCloud
from cohelm.perception.api import ColumnHeights, Detections
from cohelm.perception.cloud_detection.columns import (
    LAYER,
    LAYERS,
    Columns,
    HeightLimits,
    assign_low_columns,
    build_columns,
    floor_places,
    touching_share,
)
from cohelm.perception.cloud_detection.ground import ground_heights
from cohelm.perception.cloud_detection.segmentation import (
    SplitLimits,
    skyline,
    split_clusters,
)
from cohelm.perception.clustering.dbscan import dbscan
from cohelm.perception.clustering.ellipses import bounding_ellipses
from cohelm.perception.preprocessing.merged_cloud import MergedCloud, merge_clouds

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


@njit(**CACHED)
def shape_features(columns: Columns, labels: Integers, gaps: tuple[float, float]) -> ShapeFeatures:
    """Compute the features of each segment.

    Args:
        columns: q columns.
        labels: (q,) segment of each column, −1: none.
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
        side, behind, radius = _body_centre(across, along, torso, head, top, gaps[0] * distance)
        out.mean[k, 0], out.mean[k, 1] = mx, my
        out.centre[k, 0] = -uy * side + ux * behind
        out.centre[k, 1] = ux * side + uy * behind
        out.radius[k], out.returns[k], out.top[k], out.bottom[k] = radius, total, top, bottom
        out.width[k] = across[torso].max() - across[torso].min()
        out.depth[k] = along[torso].max() - along[torso].min()
        out.head[k] = across[head].max() - across[head].min()
        out.sheer[k], out.filled[k] = sheer, _filled(union, bottom, top)
    return out


@callee()
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
    )


@callee()
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


@callee()
def _bits(low: float, high: float) -> int:
    """Bits of the layers between two heights."""
    bits = 0
    for k in range(max(round(low / LAYER), 0), round(high / LAYER)):
        bits |= 1 << k
    return bits


@callee()
def _last_layer(layers: int, gap: float) -> int:
    """Topmost layer connected to the lowest by gaps of at most 1.5 ring gaps plus 0.2 m."""
    last, most = -1, 2 + math.ceil(1.5 * gap / LAYER)
    for k in range(LAYERS):
        if (layers >> k) & 1 and (last < 0 or k - last <= most or k * LAYER < _TORSO[0]):
            last = k
    return last


@callee()
def _filled(layers: int, bottom: float, top: float) -> float:
    """Share of the layers between two heights that are occupied."""
    low, high = max(int(bottom / LAYER), 0), min(max(int(top / LAYER), 0), LAYERS - 1)
    met = 0
    for k in range(low, high + 1):
        met += (layers >> k) & 1
    return met / (high - low + 1)


def person_log_odds(shape: ShapeFeatures, beside: Floats, cloud: MergedCloud) -> Floats:
    """ln(p / (1 − p)) that each of s segments is a person, from its shape alone; (s,).

    Sum of independent bounded evidence; assumed. Parts that are out of view or between the sensor's
    rings give no evidence. A segment cut by the end of the range may be part of
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
    aside, upright = cloud.azimuth_step * distance, cloud.elevation_step * distance
    sharp = np.clip(1.5 - 5.0 * upright, 0.0, 1.0)
    # The summands below are assumed; each is bounded, and 0 where its part is not visible.
    odds = _height_log_odds(shape.top, upright, above)
    odds += 0.6 - 10.0 * np.clip(shape.width + aside - 0.7, 0.0, 0.4)
    odds += sharp * _head_log_odds((shape.head + aside) / (shape.width + aside), above)
    # Walls and furniture are as wide below as above, a person stands on legs.
    sheer = shape.sheer
    odds += np.where(np.isnan(sheer) | ~below, 0.0, np.clip(10.0 * (0.5 - sheer), -2.0, 1.5))
    # A body has no gaps from bottom to top, and reaches down to its knees at least.
    odds -= 3.0 * sharp * (1.0 - shape.filled)
    odds -= np.where(below, 3.0 * np.clip(shape.bottom - 0.7, 0.0, 0.7), 0.0)
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


def _head_log_odds(share: Floats, visible: Booleans) -> Floats:
    """Evidence of the head's share (s,) of the breadth: a head or neck is narrower than the torso.

    If the view ends below the top, a narrower topmost part is weak evidence only: the view ends
    higher on farther parts.
    """
    odds = np.clip(8.0 * (0.8 - share), -1.5, 1.5)
    return np.where(visible, odds, np.clip(odds, 0.0, 0.5))


DIRECTIONS = 360
"""Directions of a full turn for free space (1° each)."""
_FLOOR_SQUARE = 0.1
"""Side of the squares with one floor point each, m."""
_ABOVE_CLEARANCE = 1.0
"""Returns up to this far above the clearance show whether an object continues there, m."""
_TOUCHING_COLUMNS = 3.0
"""Distance at which two objects touch, in columns."""


class _Bodies(NamedTuple):
    """Possible people, d of them, in the frame S of ``MergedCloud``."""

    centre: Floats
    """(d, 2) m."""
    radius: Floats
    """(d,) m."""
    deviation: Floats
    """(d,) standard deviation of the centre, m."""
    log_odds: Floats
    """(d,) ln(p / (1 − p)) of a person."""


class CloudClusters:
    """Xu et al., section on perception, for LiDARs with several rings and for depth cameras.

    What is higher than a table is clustered separately, so that a person at a table is not merged
    with it; lower columns join a body as its legs, or remain an obstacle. Returns that the static
    map explains belong to no person. A cluster wider than one person is split between its runs
    and its heads. Height, width, head and legs give the probability of a person.
    """

    class Parameters(Model):
        """Parameters of the detector; assumed where no reason is given."""

        centre: Literal["printed", "corrected"] = "corrected"
        """``printed``: the mean of the visible returns, Xu et al., eq. (3), too near the sensor.
        ``corrected``: the middle of the body behind them."""
        reach: float = Field(15.0, gt=1.0, le=50.0)
        """Radius about the sensor within which returns are used, m (the paper's window is 10 m
        wide; people walking at 1.5 m/s are seen 5 s before they enter it)."""
        column: float = Field(0.05, gt=0.01, le=0.5)
        """Side of a column, m (a third of a leg's breadth)."""
        steepest: float = Field(0.12, gt=0.0, le=0.5)
        """Slope of ground, rise over run (wheelchair ramps have at most 0.10, and the robot's own
        pitch adds 0.02)."""
        step: float = Field(0.03, gt=0.0, le=0.3)
        """Largest step of the ground, m: noise, gaps, door sills."""
        ground: float = Field(0.06, gt=0.0, le=0.5)
        """Height above the ground below which a return is ground, at the sensor, m."""
        ground_growth: float = Field(0.004, ge=0.0, le=0.1)
        """Growth of that with range, m/m (a pitch known to 0.25°)."""
        hole: float = Field(0.3, gt=0.0, le=2.0)
        """A return deeper below the ground is the edge of a hole and an obstacle, m."""
        clearance: float = Field(2.0, gt=0.5, le=4.0)
        """Higher returns are no obstacle, m (doors are 2.0 m high)."""
        upright: float = Field(0.8, gt=0.0, le=2.0)
        """Height from which a column may be a person's trunk, m (tables are 0.75 m high)."""
        map_margin: float = Field(0.1, ge=0.0, le=1.0)
        """A column this near a mapped wall belongs to it, m (localisation, half a column)."""
        map_margin_growth: float = Field(0.015, ge=0.0, le=0.2)
        """Growth of that margin with range, m/m (1° of localisation error is 0.017)."""
        epsilon: float = Field(0.12, gt=0.0, le=1.0)
        """ε of DBSCAN at the sensor, m (more than two columns)."""
        epsilon_gaps: float = Field(2.2, ge=0.0, le=10.0)
        """Growth of ε, in gaps between azimuths: one lost beam does not split a cluster."""
        min_samples: int = Field(2, ge=1, le=100)
        """Columns, itself included, of a core column."""
        widest: float = Field(1.0, gt=0.0, le=3.0)
        """Largest width or depth of a person with swinging arms, m."""
        heads_from: float = Field(0.5, gt=0.0, le=3.0)
        """Width from which two heads are searched, m."""
        split_to: float = Field(3.0, gt=0.0, le=10.0)
        """Largest width of a cluster that is split into several people, m."""
        legs: float = Field(0.5, ge=0.0, le=2.0)
        """Small low objects this near a body's centre are its legs, m (half a stride)."""
        min_log_odds: float = Field(-2.0, ge=-10.0, le=10.0)
        """Log-odds below which a segment is only an obstacle (−2: 12 %)."""
        max_log_odds: float = Field(4.0, ge=0.0, le=10.0)
        """Bound of the log-odds from one observation of a shape."""
        position_noise: float = Field(0.018, ge=0.0, le=0.5)
        """Standard deviation of a centre between observations, m: columns, posture."""
        position_noise_growth: float = Field(0.002, ge=0.0, le=0.1)
        """Its growth with range, m/m: gaps between beams, and the heading error."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = p = parameters or self.Parameters()
        top = p.clearance + _ABOVE_CLEARANCE
        self._limits = HeightLimits(
            hole=-p.hole,
            ground=p.ground,
            ground_growth=p.ground_growth,
            clearance=p.clearance,
            top=top,
        )

    def detect(
        self, clouds: tuple[PointCloud, ...], X_MR: Floats, walls: DistanceField
    ) -> Detections:
        """See :meth:`CloudDetector.detect`.

        Clouds without a usable return give no detections. A direction is free up to the farthest
        ground seen in it, and unknown without returns from the ground.
        """
        p = self.parameters
        cloud = merge_clouds(clouds, X_MR, p.reach)
        if not len(cloud.points):
            return Detections.empty(clouds[0].time, cloud.X_MS[:2])
        heights = ground_heights(cloud.points, p.steepest, p.step, p.reach)
        first_sensor_count = int(cloud.parts[1])
        columns: Columns = build_columns(
            cloud.points, heights, self._limits, p.column, p.reach, first_sensor_count
        )
        columns = columns.where(columns.lowest <= p.clearance)
        points = transform(cloud.X_MS, columns.centre)
        distance = np.hypot(columns.centre[:, 0], columns.centre[:, 1])
        mapped = walls.at(points) < p.map_margin + p.map_margin_growth * distance
        cluster, body_of_column, bodies = self._bodies(columns, ~mapped, cloud)
        ground = np.abs(heights) <= p.ground
        return Detections(
            time=clouds[0].time,
            origin=cloud.X_MS[:2],
            points=points,
            detection_of_return=body_of_column,
            mapped=mapped,
            free_ends=transform(cloud.X_MS, free_ends(cloud.points, ground, columns.centre)),
            position=transform(cloud.X_MS, bodies.centre),
            radius=bodies.radius,
            deviation=bodies.deviation,
            confidence=1.0 / (1.0 + np.exp(-bodies.log_odds)),
            cluster_of_return=cluster,
            ellipse=bounding_ellipses(points, cluster, cluster.max(initial=-1) + 1, p.column),
            heights=_column_heights(cloud, columns, ground),
        )

    def _bodies(
        self, columns: Columns, unmapped: Booleans, cloud: MergedCloud
    ) -> tuple[Integers, Integers, _Bodies]:
        """(cluster of each column, its body, the bodies); −1 for none."""
        p = self.parameters
        highest_visible = cloud.in_view(columns.centre)[1]
        tall = unmapped & (columns.highest > np.clip(highest_visible - 0.3, 0.3, p.upright))
        line = skyline(columns.centre[tall])
        cluster, count = self._clusters(columns, tall, unmapped & ~tall, line, cloud)
        beside = touching_share(
            columns.centre,
            np.where(unmapped, cluster, count),
            tall | ~unmapped,
            _TOUCHING_COLUMNS * p.column,
            count,
        )
        segment = np.where(cluster < count, cluster, -1)
        shape = shape_features(columns, segment, (cloud.azimuth_step, cloud.elevation_step))
        odds = person_log_odds(shape, beside, cloud)
        distance = np.hypot(shape.mean[:, 0], shape.mean[:, 1])
        size = np.maximum(shape.width, shape.depth)
        possible = (size <= p.widest + cloud.azimuth_step * distance) & (odds >= p.min_log_odds)
        number = np.append(np.where(possible, np.cumsum(possible) - 1, -1), -1)
        at = shape.mean if p.centre == "printed" else shape.centre
        noise = p.position_noise + p.position_noise_growth * distance
        odds = np.minimum(odds, p.max_log_odds)
        bodies = _Bodies(
            centre=at[possible],
            radius=shape.radius[possible],
            deviation=noise[possible],
            log_odds=odds[possible],
        )
        return cluster, number[segment], bodies

    def _clusters(
        self, columns: Columns, tall: Booleans, low: Booleans, line: Floats, cloud: MergedCloud
    ) -> tuple[Integers, int]:
        """(cluster of each column, −1: none; number of upright segments, which come first)."""
        p = self.parameters
        gap = p.epsilon_gaps * cloud.azimuth_step
        epsilon = p.epsilon + gap * np.hypot(columns.centre[:, 0], columns.centre[:, 1])
        cluster = np.full(len(epsilon), -1, dtype=np.int64)
        cluster[tall] = split_clusters(
            columns.centre[tall],
            columns.highest[tall],
            dbscan(columns.centre[tall], epsilon[tall], p.min_samples),
            line,
            SplitLimits(
                heads_from=p.heads_from,
                runs_from=p.widest,
                heads_to=p.split_to,
                gap=p.epsilon,
                gap_growth=gap,
            ),
        )
        count = int(cluster.max(initial=-1)) + 1
        below = dbscan(columns.centre[low], epsilon[low], p.min_samples)
        cluster[low] = assign_low_columns(
            columns.centre, cluster, columns.centre[low], below, p.legs, count
        )
        return cluster, count


def _column_heights(cloud: MergedCloud, columns: Columns, ground: Booleans) -> ColumnHeights:
    """Heights of the columns and the observed floor, in the map frame."""
    floor, sensor = floor_places(cloud.points, ground, cloud.parts, _FLOOR_SQUARE)
    at = transform(cloud.X_MS, cloud.sensors[:, :2])
    return ColumnHeights(
        sensor=np.column_stack([at, cloud.sensors[:, 2]]),
        low=columns.lowest,
        high=columns.highest,
        first_sensor_layers=columns.first_sensor_layers,
        floor=transform(cloud.X_MS, floor.astype(float)).astype(np.float32),
        floor_sensor=sensor,
    )


@njit(**CACHED)
def free_ends(points: Floats, ground: Booleans, columns: Floats) -> Floats:
    """Farthest ground in each direction without a column, (k, 2), m.

    A direction without ground is left out: a cloud cannot tell free space from a blind sensor.

    Args:
        points: (p, 3) from the sensor, m.
        ground: (p,) True for ground.
        columns: (q, 2) from the sensor, m.
    """
    blocked = np.zeros(DIRECTIONS, dtype=np.bool_)
    for i in range(columns.shape[0]):
        blocked[_direction(columns[i, 0], columns[i, 1])] = True
    farthest = np.zeros(DIRECTIONS)
    for i in range(points.shape[0]):
        if ground[i]:
            squared = points[i, 0] ** 2 + points[i, 1] ** 2
            d = _direction(points[i, 0], points[i, 1])
            farthest[d] = max(farthest[d], squared)
    out = np.empty((DIRECTIONS, 2))
    count = 0
    for d in range(DIRECTIONS):
        if farthest[d] > 0.0 and not blocked[d]:
            angle = (d + 0.5) * 2.0 * math.pi / DIRECTIONS - math.pi
            distance = math.sqrt(farthest[d])
            out[count, 0], out[count, 1] = distance * math.cos(angle), distance * math.sin(angle)
            count += 1
    return out[:count]


@callee()
def _direction(x: float, y: float) -> int:
    return int((math.atan2(y, x) / (2.0 * math.pi) + 0.5) * DIRECTIONS) % DIRECTIONS
