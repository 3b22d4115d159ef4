"""People in the clouds of 3-D sensors: ground → columns → DBSCAN → shape."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.config import Model
from cohelm.geometry import transform
from cohelm.maps import DistanceField
from cohelm.messages import PointCloud
from cohelm.perception.api import Detections, Heights
from cohelm.perception.cloud_bodies import (
    CENTRE_X,
    CENTRE_Y,
    DEPTH,
    HIDDEN,
    MEAN_X,
    MEAN_Y,
    RADIUS,
    WIDTH,
    join_low,
    looks,
    touching,
)
from cohelm.perception.cloud_clearing import floor_places
from cohelm.perception.cloud_free import free_ends
from cohelm.perception.cloud_points import Gathered, gather
from cohelm.perception.cloud_segments import segments, skyline
from cohelm.perception.cloud_shape import log_odds
from cohelm.perception.columns import Columns, thin
from cohelm.perception.dbscan import dbscan
from cohelm.perception.ellipse import bounding_ellipses
from cohelm.perception.ground import ground_heights

_FLOOR_PLACE = 0.1
"""Side of the squares of which each tells once that floor was seen in it, m."""
_ABOVE = 1.0
"""Returns up to this far above the clearance tell whether a thing goes on there, m."""


class CloudClusters:
    """Xu et al., section on perception, for LiDARs with several rings and for depth cameras.

    What stands higher than a table is clustered for itself, so that a person at a table is not one
    with it; what is lower joins a body as its legs, or stays an obstacle. Returns that the static
    map explains own nobody. A cluster wider than one person is cut between its runs, its heads and
    its bodies. How probable it is a person is told from height, width, head and legs.
    """

    class Parameters(Model):
        """Of the detector; assumed where no reason is given."""

        centre: Literal["printed", "corrected"] = "corrected"
        """``printed``: the mean of the visible returns, eq. (3), too near the sensor.
        ``corrected``: the middle of the body behind them."""
        reach: float = Field(15.0, gt=1.0, le=50.0)
        """Radius about the sensor beyond which nothing is looked at, m (the paper's window is 10 m
        wide; people who walk at 1.5 m/s are seen 5 s before they enter it)."""
        column: float = Field(0.05, gt=0.01, le=0.5)
        """Side of a column, m (a third of a leg's breadth)."""
        steepest: float = Field(0.12, gt=0.0, le=0.5)
        """Slope of ground, rise over run (ramps for wheelchairs have at most 0.10, and 0.02 for
        what the robot's own pitch adds)."""
        step: float = Field(0.03, gt=0.0, le=0.3)
        """By which ground may rise at once, m: noise, gaps, door sills."""
        ground: float = Field(0.06, gt=0.0, le=0.5)
        """What is lower above the ground is ground, at the sensor, m."""
        ground_growth: float = Field(0.004, ge=0.0, le=0.1)
        """Growth of that with range, m/m (a pitch known to 0.25°)."""
        hole: float = Field(0.3, gt=0.0, le=2.0)
        """What lies deeper below the ground is the edge of a hole and stands in the way, m."""
        clearance: float = Field(2.0, gt=0.5, le=4.0)
        """What hangs higher is not in the way, m (doors are 2.0 m high)."""
        upright: float = Field(0.8, gt=0.0, le=2.0)
        """What reaches higher may be a person's trunk, m (tables are 0.75 m high)."""
        map_margin: float = Field(0.1, ge=0.0, le=1.0)
        """A column this near a mapped wall is its, m (localisation, half a column, noise)."""
        map_margin_growth: float = Field(0.015, ge=0.0, le=0.2)
        """Growth of that margin with range, m/m (1° of localisation at most is 0.017)."""
        neighbours: float = Field(0.12, gt=0.0, le=1.0)
        """ε of DBSCAN at the sensor, m (two columns and more)."""
        neighbour_gaps: float = Field(2.2, ge=0.0, le=10.0)
        """Growth of ε, in gaps between azimuths: one lost beam does not part a cluster."""
        min_samples: int = Field(2, ge=1, le=100)
        """Columns, itself included, that make a core column."""
        widest: float = Field(1.0, gt=0.0, le=3.0)
        """Largest width or depth of a person who swings arms, m."""
        heads_from: float = Field(0.5, gt=0.0, le=3.0)
        """Width from which two heads are looked for, m."""
        cut_to: float = Field(3.0, gt=0.0, le=10.0)
        """Width up to which several people are looked for in one cluster, m."""
        body_radius: float = Field(0.2, gt=0.05, le=1.0)
        """r₀ of the disc that stands for a body when a cluster is cut, m."""
        body_radius_deviation: float = Field(0.05, gt=0.0, le=0.5)
        """Its standard deviation, m."""
        body_noise: float = Field(0.05, gt=0.0, le=0.5)
        """Standard deviation of columns about that disc, m: a body is no disc."""
        legs: float = Field(0.5, ge=0.0, le=2.0)
        """Low things this near a body's centre, and small, are its legs, m (half a stride)."""
        least_log_odds: float = Field(-2.0, ge=-10.0, le=10.0)
        """What is less probable a person is not told of (−2: 12 %); it is an obstacle."""
        most_log_odds: float = Field(4.0, ge=0.0, le=10.0)
        """What one look at a shape can say at most."""
        position_noise: float = Field(0.018, ge=0.0, le=0.5)
        """Standard deviation of a centre from look to look, m: columns, posture."""
        position_noise_growth: float = Field(0.002, ge=0.0, le=0.1)
        """Its growth with range, m/m: gaps between beams, and the heading's error."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def detect(
        self, clouds: tuple[PointCloud, ...], X_MR: Floats, walls: DistanceField
    ) -> Detections:
        """See :meth:`CloudDetector.detect`.

        Clouds of which nothing is usable show nothing. A direction is free as far as the ground
        was seen in it; where no ground came back, nothing is said.
        """
        p = self.parameters
        seen = gather(clouds, X_MR, p.reach)
        if not len(seen.points):
            return Detections.nothing(clouds[0].time, seen.X_MS[:2])
        heights = ground_heights(seen.points, p.steepest, p.step, p.reach)
        bounds = np.array([-p.hole, p.ground, p.ground_growth, p.clearance, p.clearance + _ABOVE])
        columns = Columns(
            *thin(seen.points, heights, bounds, p.column, p.reach, int(seen.parts[1]))
        )
        columns = columns.where(columns.lowest <= p.clearance)
        points = transform(seen.X_MS, columns.centre)
        away = np.hypot(columns.centre[:, 0], columns.centre[:, 1])
        mapped = walls.at(points) < p.map_margin + p.map_margin_growth * away
        cluster, owner, bodies = self._bodies(columns, ~mapped, seen)
        ground = np.abs(heights) <= p.ground
        return Detections(
            time=clouds[0].time,
            origin=seen.X_MS[:2],
            points=points,
            owner=owner,
            mapped=mapped,
            through=transform(seen.X_MS, free_ends(seen.points, ground, columns.centre)),
            position=transform(seen.X_MS, bodies[:, :2]),
            radius=bodies[:, 2],
            deviation=bodies[:, 3],
            confidence=1.0 / (1.0 + np.exp(-bodies[:, 4])),
            cluster=cluster,
            ellipse=bounding_ellipses(points, cluster, cluster.max(initial=-1) + 1, p.column),
            heights=_heights(seen, columns, ground),
        )

    def _bodies(
        self, columns: Columns, free: Booleans, seen: Gathered
    ) -> tuple[Integers, Integers, Floats]:
        """(cluster of each column, its owner, bodies (d, 5)) about the sensor.

        A body is (x, y, radius, deviation, log-odds of a person).
        """
        p = self.parameters
        in_view = seen.in_view(columns.centre)[1]
        tall = free & (columns.highest > np.clip(in_view - 0.3, 0.3, p.upright))
        line = skyline(columns.centre[tall])
        cluster, count = self._clusters(columns, tall, free & ~tall, line, seen)
        beside = touching(
            columns.centre, np.where(free, cluster, count), tall | ~free, 3.0 * p.column, count
        )
        segment = np.where(cluster < count, cluster, -1)
        look = looks(*columns[:5], segment, line, np.array([seen.spacing, seen.ring]))
        odds = log_odds(look, beside, seen)
        away = np.hypot(look[:, MEAN_X], look[:, MEAN_Y])
        size = np.maximum(look[:, WIDTH], look[:, DEPTH])
        possible = (size <= p.widest + seen.spacing * away) & (odds >= p.least_log_odds)
        number = np.append(np.where(possible, np.cumsum(possible) - 1, -1), -1)
        at = [MEAN_X, MEAN_Y] if p.centre == "printed" else [CENTRE_X, CENTRE_Y]
        doubt = p.position_noise + p.position_noise_growth * away + 0.05 * look[:, HIDDEN]
        odds = np.minimum(odds, p.most_log_odds)
        bodies = np.column_stack([look[:, at], look[:, RADIUS], doubt, odds])
        return cluster, number[segment], bodies[possible]

    def _clusters(
        self, columns: Columns, tall: Booleans, low: Booleans, line: Floats, seen: Gathered
    ) -> tuple[Integers, int]:
        """(cluster of each column, −1: none; how many, the first of them, are upright segments)."""
        p = self.parameters
        gap = p.neighbour_gaps * seen.spacing
        reach = p.neighbours + gap * np.hypot(columns.centre[:, 0], columns.centre[:, 1])
        cluster = np.full(len(reach), -1, dtype=np.int64)
        cluster[tall] = segments(
            columns.centre[tall],
            columns.highest[tall],
            dbscan(columns.centre[tall], reach[tall], p.min_samples),
            line,
            np.array([p.heads_from, p.widest, p.cut_to, p.neighbours, gap]),
            np.array([p.body_radius, p.body_radius_deviation, p.body_noise]),
        )
        count = int(cluster.max(initial=-1)) + 1
        below = dbscan(columns.centre[low], reach[low], p.min_samples)
        cluster[low] = join_low(columns.centre, cluster, columns.centre[low], below, p.legs, count)
        return cluster, count


def _heights(seen: Gathered, columns: Columns, ground: Booleans) -> Heights:
    """How high the columns are, and where the ground was seen, in the map frame."""
    floor, seen_by = floor_places(seen.points, ground, seen.parts, _FLOOR_PLACE)
    return Heights(
        sensor=np.column_stack([transform(seen.X_MS, seen.sensors[:, :2]), seen.sensors[:, 2]]),
        low=columns.lowest,
        high=columns.highest,
        layers=columns.first,
        floor=transform(seen.X_MS, floor.astype(float)).astype(np.float32),
        seen_by=seen_by,
    )
