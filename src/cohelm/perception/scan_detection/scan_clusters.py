"""Detector of people in planar scans: returns minus the map → DBSCAN → size and roundness."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers, replace
from cohelm.config import Model
from cohelm.kernels import CACHED
from cohelm.maps import DistanceField
from cohelm.messages import Scan
from cohelm.perception.api import Detections
from cohelm.perception.clustering.dbscan import dbscan
from cohelm.perception.clustering.ellipses import bounding_ellipses
from cohelm.perception.clustering.shape_fits import DiscPrior
from cohelm.perception.preprocessing.scan_returns import ScanReturns, scan_returns
from cohelm.perception.scan_detection.bodies import Beams, BodySizes, find_bodies
from cohelm.perception.scan_detection.body_candidates import BodyCandidates
from cohelm.perception.scan_detection.candidate_features import candidate_features
from cohelm.perception.scan_detection.legs import MAX_LOG_ODDS, LegModel
from cohelm.perception.scan_detection.person_classifier import (
    TreeEnsemble,
    person_log_odds,
    shipped_classifier,
)

MAX_LONE_LEG_LOG_ODDS = -0.1
"""Bound of the log-odds of one leg alone."""
TORSO_MARGIN = 1.5
"""Log-odds that a torso has at most beyond the classifier's, which has seen legs mostly."""
NO_WALL = 1e5
"""Distance of walls beyond which there is no map, m."""


class ScanCandidates(NamedTuple):
    """Possible people of one scan with p returns; d of them."""

    returns: ScanReturns
    mapped: Booleans
    """(p,) True for returns that the map explains."""
    has_map: bool
    cluster_of_return: Integers
    """(p,) −1: none."""
    body_of_return: Integers
    """(p,) candidate of each return, −1: none."""
    bodies: BodyCandidates
    """With the hand-made log-odds."""
    features: Floats
    """(d, f) columns of ``FEATURES``."""


class ScanClusters:
    """Xu et al., section on perception, for a planar scanner at leg height or above.

    Returns that the static map explains are removed first, so that a person beside a wall is a
    cluster of their own. A cluster as wide as a body is a possible person; its confidence is the
    evidence for a disc against a face, a corner or clutter (``shape_fits``). A wide cluster is
    split where two discs explain it much better than one shape. Narrow clusters are legs, if their
    width fits; two legs within a stride are one possible person (``legs``).
    """

    class Parameters(Model):
        """Parameters of the detector; assumed where no reason is given."""

        centre: Literal["printed", "corrected"] = "corrected"
        """``printed``: the mean of the visible returns, Xu et al., eq. (3), about 0.8 of the radius
        too near. ``corrected``: the centre of the disc behind them."""
        map_margin: float = Field(0.09, ge=0.0, le=1.0)
        """A return this near a mapped wall belongs to it, m (3 cm of localisation, a cell)."""
        map_margin_growth: float = Field(0.015, ge=0.0, le=0.2)
        """Growth of that margin with range, m/m (1° of localisation error is 0.017)."""
        epsilon: float = Field(0.12, gt=0.0, le=1.0)
        """ε of DBSCAN at the sensor, m."""
        epsilon_beams: float = Field(2.2, ge=0.0, le=10.0)
        """Growth of ε, in gaps between beams: one lost beam does not split a cluster."""
        min_samples: int = Field(2, ge=1, le=100)
        """Neighbours, itself included, of a core point (at 9 m a body has three returns)."""
        narrowest: float = Field(0.3, ge=0.0, le=1.0)
        """Smallest width of a body without occluded ends, including half a beam at each end, m."""
        widest: float = Field(0.9, gt=0.0, le=3.0)
        """Largest width of a body, m."""
        split_from: float = Field(0.62, gt=0.0, le=3.0)
        """Width from which a split into two people is tried, m."""
        body_radius: float = Field(0.27, gt=0.05, le=1.0)
        """r₀ of a body's disc, m."""
        body_radius_deviation: float = Field(0.05, gt=0.0, le=0.5)
        """Its standard deviation among people, m."""
        leg_width: float = Field(0.12, gt=0.0, le=0.5)
        """Width of one leg with its trousers from any side, m."""
        leg_width_deviation: float = Field(0.04, gt=0.0, le=0.5)
        """m."""
        both_legs_width: float = Field(0.28, gt=0.0, le=1.0)
        """Width of two legs that touch or nearly occlude each other, m."""
        both_legs_width_deviation: float = Field(0.07, gt=0.0, le=0.5)
        """m."""
        longest_stride: float = Field(0.8, gt=0.0, le=2.0)
        """Largest distance between the legs of one person, m."""
        legs_deviation: float = Field(0.08, gt=0.0, le=0.5)
        """Standard deviation of a person's centre from the middle of the legs, m."""
        leg_deviation: float = Field(0.15, gt=0.0, le=0.5)
        """Standard deviation of a person's centre from the only visible leg, m."""
        single_leg_log_odds: float = Field(-1.0, ge=-5.0, le=5.0)
        """Log-odds that only one leg of a person is visible."""
        range_noise: float = Field(0.015, gt=0.0, le=0.5)
        """Standard deviation of a return about a disc, m: the sensor's and the body's own."""
        position_noise: float = Field(0.02, ge=0.0, le=0.5)
        """Standard deviation of a centre beyond that of its fit (gait, localisation), m."""
        position_noise_growth: float = Field(0.004, ge=0.0, le=0.1)
        """Its growth with range, m/m: the part of the heading error that varies between scans."""

    def __init__(
        self, parameters: Parameters | None = None, classifier: TreeEnsemble | None = None
    ) -> None:
        self.parameters = p = parameters or self.Parameters()
        self._classifier = shipped_classifier() if classifier is None else classifier
        self._sizes = BodySizes(p.narrowest, p.widest, p.split_from)
        self._prior = DiscPrior(p.body_radius, p.body_radius_deviation, p.range_noise)
        self._legs = LegModel(
            width=p.leg_width,
            width_deviation=p.leg_width_deviation,
            pair_width=p.both_legs_width,
            pair_width_deviation=p.both_legs_width_deviation,
            stride=p.longest_stride,
            pair_deviation=p.legs_deviation,
            single_deviation=p.leg_deviation,
            single_log_odds=p.single_leg_log_odds,
        )

    def detect(self, scan: Scan, X_MR: Floats, walls: DistanceField) -> Detections:
        """See :meth:`Detector.detect`; a scan without a usable return gives no detections."""
        p = self.parameters
        seen = self.candidates(scan, X_MR, walls)
        returns, bodies, cluster = seen.returns, seen.bodies, seen.cluster_of_return
        if not len(returns.points):
            free = returns.free_ends
            return replace(Detections.empty(scan.time, returns.origin), free_ends=free)
        distance = np.hypot(*(bodies.disc_centre - returns.origin).T)
        noise = p.position_noise + p.position_noise_growth * distance
        return Detections(
            time=scan.time,
            origin=returns.origin,
            points=returns.points,
            detection_of_return=seen.body_of_return,
            mapped=seen.mapped,
            free_ends=returns.free_ends,
            position=bodies.disc_centre if p.centre == "corrected" else bodies.mean,
            radius=bodies.radius,
            deviation=np.hypot(bodies.deviation, noise),
            confidence=1.0 / (1.0 + np.exp(-self._log_odds(seen))),
            cluster_of_return=cluster,
            ellipse=bounding_ellipses(
                returns.points, cluster, cluster.max(initial=-1) + 1, p.range_noise
            ),
        )

    def _log_odds(self, seen: ScanCandidates) -> Floats:
        """Log-odds (d,) of a person from the fits of shapes and from the classifier.

        Of legs the classifier decides, up to a bound beyond which both must agree: furniture has
        clear legs, too, and a lone leg is no person by its shape. Of a torso the fit of its disc
        decides, unless the classifier doubts it. Without a map that shows bins and pillars, which
        are as round, the classifier decides of a torso as well, and is bounded.
        """
        bodies, learned = seen.bodies, person_log_odds(seen.features, self._classifier)
        on_legs = _on_legs(bodies)
        alone = on_legs & (bodies.deviation >= self.parameters.leg_deviation)
        bound = np.where(alone, MAX_LONE_LEG_LOG_ODDS, np.maximum(bodies.log_odds, MAX_LOG_ODDS))
        limit = learned + TORSO_MARGIN if seen.has_map else np.minimum(learned, MAX_LOG_ODDS)
        torso = np.minimum(bodies.log_odds, limit)
        return np.where(on_legs, np.minimum(learned, bound), torso)

    def candidates(self, scan: Scan, X_MR: Floats, walls: DistanceField) -> ScanCandidates:
        """Candidates for people in a scan, with their features; arguments as for :meth:`detect`."""
        p = self.parameters
        seen = scan_returns(scan, X_MR)
        away = walls.at(seen.points)
        mapped = away < p.map_margin + p.map_margin_growth * seen.range
        unmapped = np.flatnonzero(~mapped)
        cluster = np.full(len(mapped), -1, dtype=np.int64)
        gap = seen.range[unmapped] * seen.increment
        epsilon = p.epsilon + p.epsilon_beams * gap
        cluster[unmapped] = dbscan(seen.points[unmapped], epsilon, p.min_samples)
        # ε is also the least step of depth between two objects, of which the nearer occludes.
        occluded = _occluded(seen.range, seen.bearing, seen.increment, p.epsilon)
        beams = Beams(seen.points, seen.bearing, occluded, cluster, seen.origin, seen.increment)
        body_of_return, bodies = find_bodies(beams, self._sizes, self._prior, self._legs)
        features = candidate_features(beams, body_of_return, bodies)
        has_map = bool(away.min(initial=np.inf) < NO_WALL)
        return ScanCandidates(seen, mapped, has_map, cluster, body_of_return, bodies, features)


def _on_legs(bodies: BodyCandidates) -> Booleans:
    """Mask (d,) of candidates whose centre is the mean of their returns, as that of legs is."""
    out: Booleans = (bodies.disc_centre == bodies.mean).all(axis=1)
    return out


@njit(**CACHED)
def _occluded(distance: Floats, bearing: Floats, increment: float, step: float) -> Integers:
    """(p, 2): 1 where the return before (after) each, a beam or two away, is nearer by ``step``.

    The first and the last return are neighbours if the scan covers a full turn.
    """
    n = distance.shape[0]
    out = np.zeros((n, 2), dtype=np.int64)
    for i in range(n):
        before = i - 1 if i > 0 else n - 1
        apart = (bearing[i] - bearing[before]) % (2.0 * math.pi) > 2.5 * increment
        if not apart:
            out[i, 0] = distance[before] < distance[i] - step
            out[before, 1] = distance[i] < distance[before] - step
    return out
