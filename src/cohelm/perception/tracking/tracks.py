"""Parameters and state of the Kalman tracker."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from cohelm.arrays import read_only, value
from cohelm.config import Model
from cohelm.kernels import callee
from cohelm.perception.tracking.person_detections import PersonDetections, ScanTable

INITIAL_NIS = 2.0
"""Mean of the normalised innovation squared where the model holds (χ², 2 degrees of freedom)."""


class TrackerParameters(Model):
    """Parameters of the tracker; assumed where no reason is given."""

    process_noise: float = Field(0.4, gt=0.0, le=10.0)
    """q, intensity of the white acceleration, m²/s³: √0.4 m/s of drift in a second."""
    manoeuvre_process_noise: float = Field(2.0, gt=0.0, le=50.0)
    """q of a track whose innovations are far larger than expected (it turns), m²/s³."""
    unseen_process_noise: float = Field(0.1, gt=0.0, le=10.0)
    """q while a track is not seen, m²/s³: part of the apparent agility between detections is the
    body's sway, which leads nowhere."""
    speed_deviation: float = Field(1.0, gt=0.0, le=5.0)
    """Standard deviation of a new track's velocity on each axis, m/s."""
    gate: float = Field(13.8, gt=0.0, le=100.0)
    """Largest squared Mahalanobis distance of a match (χ², 2 degrees of freedom, 99.9 %)."""
    birth_density: float = Field(0.1, gt=0.0, le=10.0)
    """Density of new people at unexpected places, 1/m² and scan: a match that is less likely than a
    new person is rejected."""
    match_distance: float = Field(1.0, gt=0.0, le=10.0)
    """Largest distance of a match, m."""
    match_distance_growth: float = Field(0.3, ge=0.0, le=5.0)
    """Growth of that distance with time unseen, m/s."""
    separation: float = Field(0.35, ge=0.0, le=2.0)
    """No track is born this near one that was just seen; a person may be part of a cluster up to
    this far beyond its radius, m."""
    double_distance: float = Field(0.5, ge=0.0, le=2.0)
    """Distance below which two tracks of planar scans are one person's legs, if one is a leg, m."""
    double_deviation: float = Field(0.1, ge=0.0, le=1.0)
    """Standard deviation of the centre from which a detection is one leg alone, m."""
    double_time: float = Field(0.4, ge=0.0, le=10.0)
    """Time for which they are so near before the younger one is deleted, s: half a stride."""
    hits: int = Field(3, ge=1, le=20)
    """Detections among the last ``window`` scans that confirm a track."""
    sure_hits: int = Field(2, ge=1, le=20)
    """Detections that confirm a track whose shape leaves little doubt."""
    single_hit_interval: float = Field(0.5, gt=0.0, le=5.0)
    """Time between scans from which one detection confirms such a track, s."""
    window: int = Field(5, ge=1, le=20)
    """Scans for the count of ``hits``."""
    sure_age: float = Field(0.09, ge=0.0, le=5.0)
    """Least age for ``sure_hits``, s: at 40 Hz two detections are one observation."""
    confirm_log_odds: float = Field(1.0, ge=-5.0, le=5.0)
    """Log-odds of a person that confirm a track (1.0: 73 %)."""
    sure_log_odds: float = Field(2.0, ge=-5.0, le=5.0)
    """Log-odds of a person that leave little doubt (2.0: 88 %)."""
    reject_log_odds: float = Field(-1.0, ge=-5.0, le=5.0)
    """Log-odds below which a confirmed track is rejected."""
    unmoved_reject_log_odds: float = Field(0.4, ge=-5.0, le=5.0)
    """Log-odds below which a track is rejected that arrived but has not walked: a door, a chair."""
    arrived_log_odds: float = Field(1.0, ge=0.0, le=5.0)
    """Log-odds of motion of a track that has arrived. Others must clearly look like a person."""
    arrived_shape: float = Field(-0.2, ge=-5.0, le=5.0)
    """Mean log-odds of a shape that confirm a track that arrived and has not walked: thin and
    glossy objects appear only now and then."""
    captured_cost: float = Field(6.0, ge=0.0, le=100.0)
    """Extra cost of a match of a track that has walked with a detection at a place that was always
    occupied: a person who passes an object does not become it."""
    static_shape: float = Field(2.0, ge=-5.0, le=5.0)
    """Mean log-odds of a shape that confirm a track without motion."""
    static_looks: float = Field(2.0, ge=0.0, le=100.0)
    """Observations of the shape that this takes; those with few returns count in part."""
    static_looks_torso: float = Field(3.1, ge=0.0, le=100.0)
    """Those for one body of a planar scan: other objects are as round in three, seldom in four."""
    static_shape_kept: float = Field(1.2, ge=-5.0, le=5.0)
    """Mean log-odds of a shape above which such a track remains confirmed."""
    static_moved: float = Field(-0.3, ge=-5.0, le=0.0)
    """Log-odds of change below which nothing walks: a track that seems to walk has jumped between
    objects at rest."""
    shape_rate: float = Field(0.15, gt=0.0, le=1.0)
    """Weight of the latest observation in the running mean of the shape's log-odds: observations of
    one shape are not independent, so they do not add up."""
    motion_gain: float = Field(1.0, ge=0.0, le=5.0)
    """Log-odds gained per detection while walking; at most 5."""
    motion_loss: float = Field(0.2, ge=0.0, le=5.0)
    """Log-odds lost per detection at rest."""
    arrival_loss: float = Field(0.3, ge=0.0, le=5.0)
    """Log-odds lost per detection of a track that arrived and has not walked: it may flicker."""
    walked_distance: float = Field(0.4, ge=0.0, le=5.0)
    """Distance from its birthplace of a track that has walked, m: more than a localisation error
    of 3 cm and 1° shifts an object 8 m away."""
    parallax: float = Field(0.4, ge=0.0, le=5.0)
    """Growth of that distance for a moving sensor, m: it sees other faces of an object, and
    clusters its parts differently."""
    parallax_driven: float = Field(0.5, gt=0.0, le=10.0)
    """Motion of the sensor for the full growth, m."""
    walking_shape: float = Field(-3.0, ge=-5.0, le=5.0)
    """Mean log-odds of a shape below which a track does not walk at a place that was, or may have
    been, occupied: the visible part of a wall moves along it."""
    walking_shape_driven: float = Field(0.0, ge=-5.0, le=5.0)
    """The same for a driving scanner without a map."""
    walking_age: float = Field(0.8, ge=0.0, le=10.0)
    """Age from which such a track may walk, s: its place has no past before."""
    walking_speed: float = Field(0.3, ge=0.0, le=3.0)
    """Least speed of walking, m/s."""
    pace_time: float = Field(1.0, gt=0.0, le=10.0)
    """Time over which the velocity is averaged for slow walkers, s: a stride or two."""
    leg_shape: float = Field(1.0, ge=-5.0, le=5.0)
    """Mean log-odds of a shape from which ``walked_distance_legs`` and one standard deviation of
    the speed suffice: furniture that seems to move seldom looks like a person all the time."""
    walked_distance_legs: float = Field(0.25, ge=0.0, le=5.0)
    """Distance from its birthplace of such a track that has walked, m."""
    walking_age_legs: float = Field(0.4, ge=0.0, le=10.0)
    """Age from which such a track may walk, s."""
    heading_speed: float = Field(0.2, ge=0.0, le=3.0)
    """Least speed at which the heading follows the motion, m/s."""
    patience: float = Field(2.0, gt=0.0, le=20.0)
    """Unseen time that ends a confirmed track, s; occluded counts two fifths, seen through 3."""
    tentative_patience: float = Field(0.35, gt=0.0, le=20.0)
    """Unseen time after which a tentative track is deleted, s; all time counts in full."""
    report_deviation: float = Field(0.4, gt=0.0, le=5.0)
    """Standard deviation of the position above which a track is not reported, m; it lives on."""
    report_unseen: float = Field(1.3, gt=0.0, le=20.0)
    """Weighted unseen time above which a track is not reported, s; it lives on."""
    report_seen_through: float = Field(0.05, ge=0.0, le=5.0)
    """Time of a seen-through place above which a track is not reported, s; it lives on."""


TRACK = np.dtype(
    [
        ("id", np.int64),
        # (x, y, v_x, v_y), m and m/s.
        ("mean", np.float64, 4),
        ("covariance", np.float64, (4, 4)),
        # Running mean of the velocity over ``pace_time``, m/s.
        ("pace", np.float64, 2),
        # rad; NaN until the track has walked.
        ("heading", np.float64),
        # m.
        ("radius", np.float64),
        # Log-odds of a person from the shape: running mean.
        ("shape_log_odds", np.float64),
        # Number of observations of the shape; those with few returns count in part.
        ("shape_looks", np.float64),
        # Log-odds of a person gained by walking or arriving, ≥ 0.
        ("motion_log_odds", np.float64),
        # Log-odds lost by standing at a place that was always occupied, ≤ 0: running mean.
        ("static_penalty", np.float64),
        # Bit k: detected k scans ago, of those that looked there.
        ("detection_history", np.int64),
        # Time of the first and of the last detection, s.
        ("birth_time", np.float64),
        ("last_seen", np.float64),
        # Time without a detection, weighted by the visibility of the place, s.
        ("unseen_time", np.float64),
        # Time in which the place was seen through since the last detection, s.
        ("seen_through_time", np.float64),
        # Position of the track and of the sensor at the first detection, m.
        ("birthplace", np.float64, 2),
        ("viewpoint", np.float64, 2),
        # Normalised innovation squared eᵀ S⁻¹ e: running mean; 2 where the model holds.
        ("nis", np.float64),
        # Time for which an older track has been at the same place, s.
        ("double_time", np.float64),
        # True for a person that may be reported.
        ("confirmed", np.bool_),
        # True if it has ever walked, and for all tracks without change detection.
        ("has_walked", np.bool_),
    ],
    align=True,
)
"""Columns of the table of tracks."""
Tracks = NDArray[np.void]
"""Table (m,) of tracks, with the columns of ``TRACK``."""


@value
class TrackerState:
    """Tracks at the time of the last scan, including tentative ones."""

    time: float
    """Time of the last scan used, s."""
    next_id: int
    tracks: Tracks
    """(m,) by growing id, read-only."""

    def __len__(self) -> int:
        """Number of tracks."""
        return len(self.tracks)


def no_tracks(time: float, next_id: int = 0) -> TrackerState:
    """State without tracks."""
    return TrackerState(time=time, next_id=next_id, tracks=_NO_TRACKS)


_NO_TRACKS: Tracks = read_only(np.empty(0, TRACK))


@callee()
def start_track(
    track: Any, number: int, found: PersonDetections, j: int, scan: ScanTable, p: TrackerParameters
) -> None:
    """Fill a blank row with a tentative track at rest, for detection j."""
    track.id = number
    track.heading = np.nan
    track.radius = found.radius[j]
    track.shape_log_odds, track.shape_looks = found.log_odds[j], found.shape_weight[j]
    arrival = found.arrival_log_odds[j]
    track.motion_log_odds = arrival if arrival > 0.0 else 0.0
    track.detection_history = 1
    track.birth_time = track.last_seen = scan.time
    track.nis = INITIAL_NIS
    track.has_walked = not scan.has_changes
    for i in range(2):
        track.mean[i] = track.birthplace[i] = found.position[j, i]
        track.viewpoint[i] = scan.origin[i]
        track.covariance[i, i] = found.deviation[j] ** 2
        track.covariance[i + 2, i + 2] = p.speed_deviation**2
