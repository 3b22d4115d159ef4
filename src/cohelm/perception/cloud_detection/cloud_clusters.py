"""Detector of people in the clouds of 3-D sensors: ground → columns → DBSCAN → shape."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.config import Model
from cohelm.geometry import transform
from cohelm.kernels import CACHED
from cohelm.maps import DistanceField
from cohelm.messages import PointCloud
from cohelm.perception.api import ColumnHeights, Detections
from cohelm.perception.cloud_detection.columns import (
    Columns,
    HeightLimits,
    assign_low_columns,
    build_columns,
    floor_places,
    touching_share,
)
from cohelm.perception.cloud_detection.ground import ground_heights
from cohelm.perception.cloud_detection.segmentation import SplitLimits, skyline, split_clusters
from cohelm.perception.cloud_detection.shape_features import person_log_odds, shape_features
from cohelm.perception.clustering.dbscan import dbscan
from cohelm.perception.clustering.ellipses import bounding_ellipses
from cohelm.perception.clustering.shape_fits import DiscPrior
from cohelm.perception.preprocessing.merged_cloud import MergedCloud, merge_clouds

DIRECTIONS = 360
"""Directions of a full turn for free space (1° each)."""
_FLOOR_SQUARE = 0.1
"""Side of the squares with one floor point each, m."""
_ABOVE_CLEARANCE = 1.0
"""Returns up to this far above the clearance show whether an object continues there, m."""
_TOUCHING_COLUMNS = 3.0
"""Distance at which two objects touch, in columns."""
_OCCLUDED_END_NOISE = 0.05
"""Standard deviation of a centre added for each occluded end, m."""


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
    map explains belong to no person. A cluster wider than one person is split between its runs, its
    heads and its bodies. Height, width, head and legs give the probability of a person.
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
        body_radius: float = Field(0.2, gt=0.05, le=1.0)
        """r₀ of the disc of a body for splits, m."""
        body_radius_deviation: float = Field(0.05, gt=0.0, le=0.5)
        """Its standard deviation, m."""
        body_noise: float = Field(0.05, gt=0.0, le=0.5)
        """Standard deviation of columns about that disc, m: a body is no disc."""
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
        self._body = DiscPrior(p.body_radius, p.body_radius_deviation, p.body_noise)

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
        shape = shape_features(columns, segment, line, (cloud.azimuth_step, cloud.elevation_step))
        odds = person_log_odds(shape, beside, cloud)
        distance = np.hypot(shape.mean[:, 0], shape.mean[:, 1])
        size = np.maximum(shape.width, shape.depth)
        possible = (size <= p.widest + cloud.azimuth_step * distance) & (odds >= p.min_log_odds)
        number = np.append(np.where(possible, np.cumsum(possible) - 1, -1), -1)
        at = shape.mean if p.centre == "printed" else shape.centre
        noise = (
            p.position_noise
            + p.position_noise_growth * distance
            + _OCCLUDED_END_NOISE * shape.occluded
        )
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
                bodies_from=p.widest,
                bodies_to=p.split_to,
                gap=p.epsilon,
                gap_growth=gap,
            ),
            self._body,
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


@njit(**CACHED)
def _direction(x: float, y: float) -> int:
    return int((math.atan2(y, x) / (2.0 * math.pi) + 0.5) * DIRECTIONS) % DIRECTIONS
