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


class TrackerParameters(Model):
    """Parameters of the tracker; assumed where no reason is given."""

    process_noise: float = Field(0.4, gt=0.0, le=10.0)
    """q, intensity of the white acceleration, m²/s³: √0.4 m/s of drift in a second."""
    birth_density: float = Field(0.1, gt=0.0, le=10.0)
    """Density of new people at unexpected places, 1/m² and scan: a match that is less likely than a
    new person is rejected."""
    match_distance: float = Field(1.0, gt=0.0, le=10.0)
    """Largest distance of a match, m."""
    separation: float = Field(0.35, ge=0.0, le=2.0)
    """No track is born this near one that was just seen; a person may be part of a cluster up to
    this far beyond its radius, m."""
    hits: int = Field(2, ge=1, le=5)
    """Detections among the last five scans that confirm a track."""
    confirm_log_odds: float = Field(1.0, ge=0.0, le=5.0)
    """Log-odds of a person that confirm a track (1.0: 73 %); below 0 it is rejected."""
    static_shape: float = Field(2.0, ge=-5.0, le=5.0)
    """Mean log-odds of a shape that confirm a track without motion."""
    shape_rate: float = Field(0.15, gt=0.0, le=1.0)
    """Weight of the latest observation in the running mean of the shape's log-odds: observations of
    one shape are not independent, so they do not add up."""
    motion_gain: float = Field(0.5, ge=0.0, le=5.0)
    """Log-odds gained per detection while walking; at most 5."""
    motion_loss: float = Field(0.2, ge=0.0, le=5.0)
    """Log-odds lost per detection at rest."""
    walked_distance: float = Field(0.4, ge=0.0, le=5.0)
    """Distance from its birthplace of a track that has walked, m: more than a localisation error
    of 3 cm and 1° shifts an object 8 m away. It doubles until the sensor has moved by 0.5 m, which
    then sees other faces of an object, and clusters its parts differently."""
    walking_age: float = Field(0.4, ge=0.0, le=10.0)
    """Age from which a track may walk at a place that was not seen free, s."""
    walking_speed: float = Field(0.3, ge=0.0, le=3.0)
    """Least speed of walking, m/s."""
    patience: float = Field(2.0, gt=0.0, le=20.0)
    """Unseen time that ends a confirmed track, s; occluded counts two fifths, seen through 3."""
    report_deviation: float = Field(0.4, gt=0.0, le=5.0)
    """Standard deviation of the position above which a track is not reported, m; it lives on."""


SPEED_DEVIATION = 1.0
"""Standard deviation of a new track's velocity on each axis, m/s: people walk at 1.3 m/s."""


TRACK = np.dtype(
    [
        ("id", np.int64),
        # (x, y, v_x, v_y), m and m/s.
        ("mean", np.float64, 4),
        ("covariance", np.float64, (4, 4)),
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
        # True if the place was seen through since the last detection.
        ("seen_through", np.bool_),
        # Position of the track and of the sensor at the first detection, m.
        ("birthplace", np.float64, 2),
        ("viewpoint", np.float64, 2),
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
def start_track(track: Any, number: int, found: PersonDetections, j: int, scan: ScanTable) -> None:
    """Fill a blank row with a tentative track at rest, for detection j."""
    track.id = number
    track.heading = np.nan
    track.radius = found.radius[j]
    track.shape_log_odds, track.shape_looks = found.log_odds[j], found.shape_weight[j]
    arrival = found.arrival_log_odds[j]
    track.motion_log_odds = arrival if arrival > 0.0 else 0.0
    track.detection_history = 1
    track.birth_time = track.last_seen = scan.time
    track.has_walked = not scan.has_changes
    for i in range(2):
        track.mean[i] = track.birthplace[i] = found.position[j, i]
        track.viewpoint[i] = scan.origin[i]
        track.covariance[i, i] = found.deviation[j] ** 2
        track.covariance[i + 2, i + 2] = SPEED_DEVIATION**2
