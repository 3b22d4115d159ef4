"""Evidence that detected tracks are people: walking, shape, agility and rest."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cohelm.arrays import Booleans, Floats, Integers, unchecked
from cohelm.perception.tracking.tracks import PersonDetections, TrackerParameters, TrackerState

_RADIUS_RATE = 0.2
"""Weight of the latest observation in the running mean of the radius."""
_NIS_RATE, _MAX_NIS = 0.4, 20.0
"""Weight of the latest innovation in the running mean of the NIS, and its bound: one outlier is no
manoeuvre."""
_MAX_MOTION = 5.0
"""Bound of the log-odds of motion."""
_STATIC_FROM, _STATIC_GAIN = -1.0, 2.0
"""Log-odds of arrival below which a detection is punished for standing still, and the factor of
what is below. A cloud's detection whose place was never seen empty has −0.9 and stays unpunished:
it may be a standing person."""


class Matches(NamedTuple):
    """Detections of m tracks in one scan."""

    detection: Integers
    """(m,) index of the detection, or ``NO_MATCH``."""
    mahalanobis_sq: Floats
    """(m,) its eᵀ S⁻¹ e."""
    merged: Booleans
    """(m,) True for both of two people who share a cluster."""

    @property
    def detected(self) -> Booleans:
        """(m,) True for tracks with a detection of their own."""
        return np.asarray(self.detection >= 0)


def update_track_evidence(
    tracks: TrackerState,
    mean: Floats,
    covariance: Floats,
    found: PersonDetections,
    matches: Matches,
    p: TrackerParameters,
) -> TrackerState:
    """Update the states and the evidence of detected tracks.

    A cluster of two people says nothing about the size, shape or agility of either.

    Args:
        tracks: before the scan.
        mean, covariance: (m, 4) and (m, 4, 4) after it.
        found: possible people of the scan.
        matches: of tracks and possible people.
        p: the parameters.
    """
    detected = matches.detected
    alone = np.flatnonzero(detected & ~matches.merged)
    walks, motion = _update_motion(tracks, mean, covariance, found, matches, p)
    radius, shape, looks = _update_shape(tracks, found, alone, matches.detection[alone], p)
    return unchecked(
        tracks,
        mean=mean,
        covariance=covariance,
        heading=_updated_heading(tracks, mean, covariance, detected, p),
        radius=radius,
        shape_log_odds=shape,
        shape_looks=looks,
        motion_log_odds=motion,
        static_penalty=_updated_static_penalty(tracks, found, matches, p),
        nis=_updated_nis(tracks, alone, matches.mahalanobis_sq),
        last_seen=np.where(detected, found.time, tracks.last_seen),
        has_walked=tracks.has_walked | (detected & walks),
    )


def _update_motion(
    tracks: TrackerState,
    mean: Floats,
    covariance: Floats,
    found: PersonDetections,
    matches: Matches,
    p: TrackerParameters,
) -> tuple[Booleans, Floats]:
    """(True for tracks that walk (m,), log-odds of motion (m,)).

    A track walks if it is far enough from its birthplace, and fast, at a place that has changed.
    """
    detected, detection = matches.detected, matches.detection[matches.detected]
    driven = np.hypot(*(found.origin - tracks.viewpoint).T)
    driven = np.minimum(driven / p.parallax_driven, 1.0)
    least = p.walked_distance + p.parallax * driven
    far = np.hypot(*(mean[:, :2] - tracks.birthplace).T) > least
    walks = far & _is_faster(mean, covariance, p.walking_speed)
    # Few returns seen from a moving sensor are little evidence of motion.
    arrival, credit = np.zeros(len(tracks)), np.ones(len(tracks))
    arrival[detected] = found.arrival_log_odds[detection]
    credit[detected] -= driven[detected] * (1.0 - found.shape_weight[detection])
    known = (tracks.shape_log_odds > p.walking_shape) & (
        found.time - tracks.birth_time >= p.walking_age
    )
    walks &= (arrival >= p.static_moved) & ((arrival > 0.0) | known | (not found.has_changes))
    loss = np.where(tracks.has_walked, -p.motion_loss, -p.arrival_loss)
    motion = tracks.motion_log_odds + np.where(walks, p.motion_gain * credit, loss) * detected
    motion[detected] = np.maximum(motion, arrival * credit)[detected]
    return walks, np.clip(motion, 0.0, _MAX_MOTION)


def _update_shape(
    tracks: TrackerState,
    found: PersonDetections,
    alone: Integers,
    detection: Integers,
    p: TrackerParameters,
) -> tuple[Floats, Floats, Floats]:
    """(radius, log-odds of the shape, observations of the shape), (m,) each.

    Args:
        tracks: before the scan.
        found: possible people of the scan.
        alone: (k,) tracks with a cluster of their own.
        detection: (k,) detections of these.
        p: the parameters.
    """
    radius, shape = tracks.radius.copy(), tracks.shape_log_odds.copy()
    looks, weight = tracks.shape_looks.copy(), found.shape_weight[detection]
    radius[alone] += _RADIUS_RATE * (found.radius[detection] - tracks.radius[alone])
    looks[alone] += weight
    rate = weight * np.maximum(p.shape_rate, 1.0 / looks[alone])
    shape[alone] += rate * (found.log_odds[detection] - tracks.shape_log_odds[alone])
    return radius, shape, looks


def _updated_nis(tracks: TrackerState, alone: Integers, mahalanobis_sq: Floats) -> Floats:
    nis = tracks.nis.copy()
    nis[alone] += _NIS_RATE * (np.minimum(mahalanobis_sq[alone], _MAX_NIS) - tracks.nis[alone])
    return nis


def _updated_static_penalty(
    tracks: TrackerState, found: PersonDetections, matches: Matches, p: TrackerParameters
) -> Floats:
    detected, penalty = matches.detected, tracks.static_penalty.copy()
    arrival = found.arrival_log_odds[matches.detection[detected]]
    now = _STATIC_GAIN * np.minimum(arrival - _STATIC_FROM, 0.0)
    penalty[detected] += p.shape_rate * (now - tracks.static_penalty[detected])
    return penalty


def _updated_heading(
    tracks: TrackerState,
    mean: Floats,
    covariance: Floats,
    detected: Booleans,
    p: TrackerParameters,
) -> Floats:
    """Direction of motion (m,) of tracks that are fast enough, else the last one, rad."""
    follows = detected & _is_faster(mean, covariance, p.heading_speed)
    return np.where(follows, np.arctan2(mean[:, 3], mean[:, 2]), tracks.heading)


def _is_faster(mean: Floats, covariance: Floats, speed: float) -> Booleans:
    """Mask (m,) of speeds above ``speed``, m/s, and above twice their standard deviation."""
    squared = mean[:, 2] ** 2 + mean[:, 3] ** 2
    variance = 0.5 * (covariance[:, 2, 2] + covariance[:, 3, 3])
    faster: Booleans = (squared > speed * speed) & (squared > 4.0 * variance)
    return faster
