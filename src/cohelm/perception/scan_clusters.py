"""People in a planar scan: returns less the map's → DBSCAN → size and roundness."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.config import Model
from cohelm.maps import DistanceField
from cohelm.messages import Scan
from cohelm.perception.api import Detections
from cohelm.perception.bodies import find_bodies
from cohelm.perception.dbscan import dbscan
from cohelm.perception.ellipse import bounding_ellipses
from cohelm.perception.scan import Returns, returns


class ScanClusters:
    """Xu et al., section on perception, for a planar scanner at the height of the legs or above.

    Returns that the static map explains are set aside first, so that a person beside a wall stands
    free of it. A cluster as wide as a body is a possible person; how much more probable a disc is
    than a face, a corner or clutter (see ``fits``) is its confidence. A wide one is cut where two
    discs explain it much better than one thing.
    """

    class Parameters(Model):
        """Of the detector; assumed where no reason is given."""

        centre: Literal["printed", "corrected"] = "corrected"
        """``printed``: the mean of the visible returns, eq. (3), about 0.8 of the radius too near.
        ``corrected``: the disc behind them."""
        map_margin: float = Field(0.09, ge=0.0, le=1.0)
        """A return this near a mapped wall is its, m (3 cm of localisation, one cell, noise)."""
        map_margin_growth: float = Field(0.015, ge=0.0, le=0.2)
        """Growth of that margin with range, m/m (1° of localisation at most is 0.017)."""
        reach: float = Field(0.12, gt=0.0, le=1.0)
        """ε of DBSCAN at the sensor, m."""
        reach_beams: float = Field(2.2, ge=0.0, le=10.0)
        """Growth of ε, in gaps between beams: one lost beam does not part a cluster."""
        min_samples: int = Field(2, ge=1, le=100)
        """Neighbours, itself included, that make a core point (at 9 m a body has three returns)."""
        narrowest: float = Field(0.3, ge=0.0, le=1.0)
        """Least width of a body, where neither end is hidden, half-seen beams granted, m."""
        widest: float = Field(0.9, gt=0.0, le=3.0)
        """Largest width of a body, m."""
        cut_from: float = Field(0.62, gt=0.0, le=3.0)
        """Width from which two people who touch are looked for, m."""
        body_radius: float = Field(0.27, gt=0.05, le=1.0)
        """r₀ of a body's disc, m."""
        body_radius_deviation: float = Field(0.05, gt=0.0, le=0.5)
        """Its standard deviation among people, m."""
        leg_width: float = Field(0.12, gt=0.0, le=0.5)
        """Of one leg with its trousers as seen from anywhere, m."""
        leg_width_deviation: float = Field(0.04, gt=0.0, le=0.5)
        """m."""
        both_legs_width: float = Field(0.28, gt=0.0, le=1.0)
        """Of two legs that touch or nearly hide each other, m."""
        both_legs_width_deviation: float = Field(0.07, gt=0.0, le=0.5)
        """m."""
        longest_stride: float = Field(0.8, gt=0.0, le=2.0)
        """Largest distance between the legs of one person, m."""
        legs_deviation: float = Field(0.08, gt=0.0, le=0.5)
        """Standard deviation of a person's centre from the middle of the legs, m."""
        leg_deviation: float = Field(0.15, gt=0.0, le=0.5)
        """The same from one leg, the other one not being seen, m."""
        one_legged: float = Field(-1.0, ge=-5.0, le=5.0)
        """Log-odds that a person shows one leg only."""
        range_noise: float = Field(0.015, gt=0.0, le=0.5)
        """Standard deviation of a return about a disc, m: the sensor's and the body's own."""
        position_noise: float = Field(0.02, ge=0.0, le=0.5)
        """Standard deviation of a centre beyond that of its fit (gait, localisation), m."""
        position_noise_growth: float = Field(0.004, ge=0.0, le=0.1)
        """Its growth with range, m/m: the heading's error, as far as it changes between scans."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def detect(self, scan: Scan, X_MR: Floats, walls: DistanceField) -> Detections:
        """See :meth:`Detector.detect`; a scan without a usable return shows nothing."""
        p = self.parameters
        seen = returns(scan, X_MR)
        if not len(seen.points):
            nothing = Detections.nothing(scan.time, seen.origin)
            return replace(nothing, through=seen.through)
        mapped = walls.at(seen.points) < p.map_margin + p.map_margin_growth * seen.range
        free = np.flatnonzero(~mapped)
        labels = np.full(len(mapped), -1, dtype=np.int64)
        gap = seen.range[free] * seen.increment
        labels[free] = dbscan(seen.points[free], p.reach + p.reach_beams * gap, p.min_samples)
        owner, bodies = find_bodies(
            seen.points,
            seen.bearing,
            _hidden(seen.range, seen.bearing, seen.increment, p.reach),
            labels,
            seen.origin,
            seen.increment,
            np.array([p.narrowest, p.widest, p.cut_from]),
            np.array([p.body_radius, p.body_radius_deviation, p.range_noise]),
            self._legs(),
        )
        return self._detections(scan.time, seen, mapped, labels, owner, bodies)

    def _legs(self) -> Floats:
        """What ``find_bodies`` needs to know about legs."""
        p = self.parameters
        return np.array(
            [
                p.leg_width,
                p.leg_width_deviation,
                p.both_legs_width,
                p.both_legs_width_deviation,
                p.longest_stride,
                p.legs_deviation,
                p.leg_deviation,
                p.one_legged,
            ]
        )

    def _detections(
        self,
        time: float,
        seen: Returns,
        mapped: Booleans,
        labels: Integers,
        owner: Integers,
        bodies: Floats,
    ) -> Detections:
        p = self.parameters
        away = np.hypot(*(bodies[:, :2] - seen.origin).T)
        extra = p.position_noise + p.position_noise_growth * away
        return Detections(
            time=time,
            origin=seen.origin,
            points=seen.points,
            owner=owner,
            mapped=mapped,
            through=seen.through,
            position=bodies[:, :2] if p.centre == "corrected" else bodies[:, 5:7],
            radius=bodies[:, 2],
            deviation=np.hypot(bodies[:, 3], extra),
            confidence=1.0 / (1.0 + np.exp(-bodies[:, 4])),
            cluster=labels,
            ellipse=bounding_ellipses(
                seen.points, labels, labels.max(initial=-1) + 1, p.range_noise
            ),
        )


@njit(cache=True)
def _hidden(away: Floats, bearing: Floats, increment: float, step: float) -> Integers:
    """(p, 2): 1 where the return before (after) each, a beam or two away, is nearer by ``step``.

    The first and the last return are neighbours if the scan closes the circle.
    """
    n = away.shape[0]
    out = np.zeros((n, 2), dtype=np.int64)
    for i in range(n):
        before = i - 1 if i > 0 else n - 1
        apart = (bearing[i] - bearing[before]) % (2.0 * math.pi) > 2.5 * increment
        if not apart:
            out[i, 0] = away[before] < away[i] - step
            out[before, 1] = away[i] < away[before] - step
    return out
