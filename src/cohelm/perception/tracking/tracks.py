"""Parameters and state of the Kalman tracker, and the person detections of one scan."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.config import Model
from cohelm.perception.api import Detections

_NO_SHAPE, _FULL_SHAPE, _MIN_SHAPE_WEIGHT = 3.0, 8.0, 0.1
"""Numbers of returns that show no shape, and the whole shape; and the least weight of a shape."""
_MIN_PROBABILITY, _MAX_PROBABILITY = 0.01, 0.99
"""Bounds of a detection's confidence: they keep the log-odds finite."""
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
    """Log-odds of motion of a track that has arrived at its place. Others must have the clear shape
    of a person."""
    static_shape: float = Field(2.0, ge=-5.0, le=5.0)
    """Mean log-odds of a shape that confirm a track without motion."""
    static_looks: float = Field(2.0, ge=0.0, le=100.0)
    """Observations of the shape that this takes; those with few returns count in part."""
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
    """Log-odds lost per detection of a track that arrived and has not walked since: objects that
    appear only now and then do so."""
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
    walking_age: float = Field(0.8, ge=0.0, le=10.0)
    """Age from which such a track may walk, s: the past of its place is unknown before."""
    walking_speed: float = Field(0.3, ge=0.0, le=3.0)
    """Least speed of walking, m/s."""
    heading_speed: float = Field(0.2, ge=0.0, le=3.0)
    """Least speed at which the heading follows the motion, m/s."""
    patience: float = Field(2.0, gt=0.0, le=20.0)
    """Unseen time after which a confirmed track is deleted, s; occluded time counts two fifths,
    time in which its place was seen through threefold."""
    tentative_patience: float = Field(0.35, gt=0.0, le=20.0)
    """Unseen time after which a tentative track is deleted, s; all time counts in full."""
    report_deviation: float = Field(0.4, gt=0.0, le=5.0)
    """Standard deviation of the position above which a track is not reported, m; it lives on."""
    report_unseen: float = Field(1.3, gt=0.0, le=20.0)
    """Weighted unseen time above which a track is not reported, s; it lives on."""
    report_seen_through: float = Field(0.05, ge=0.0, le=5.0)
    """Time of a seen-through place above which a track is not reported, s; it lives on."""


@value
class TrackerState:
    """Tracks at the time of the last scan, including tentative ones; m of them, by growing id."""

    time: float
    """Time of the last scan used, s."""
    next_id: int
    id: Annotated[Integers, Shape("m")]
    mean: Annotated[Floats, Shape("m 4")]
    """(x, y, v_x, v_y), m and m/s."""
    covariance: Annotated[Floats, Shape("m 4 4")]
    heading: Annotated[Floats, Shape("m")]
    """rad; NaN until the track has walked."""
    radius: Annotated[Floats, Shape("m")]
    """m."""
    shape_log_odds: Annotated[Floats, Shape("m")]
    """Log-odds of a person from the shape: running mean."""
    shape_looks: Annotated[Floats, Shape("m")]
    """Number of observations of the shape; those with few returns count in part."""
    motion_log_odds: Annotated[Floats, Shape("m")]
    """Log-odds of a person gained by walking or arriving, ≥ 0."""
    static_penalty: Annotated[Floats, Shape("m")]
    """Log-odds of a person lost by standing at a place that was always occupied, ≤ 0: running
    mean."""
    detection_history: Annotated[Integers, Shape("m")]
    """Bit k: detected k scans ago, of those that looked there."""
    birth_time: Annotated[Floats, Shape("m")]
    """Time of the first detection, s."""
    last_seen: Annotated[Floats, Shape("m")]
    """Time of the last detection, s."""
    unseen_time: Annotated[Floats, Shape("m")]
    """Time without a detection, weighted by the visibility of the place, s."""
    seen_through_time: Annotated[Floats, Shape("m")]
    """Time in which the place was seen through since the last detection, s."""
    birthplace: Annotated[Floats, Shape("m 2")]
    """m."""
    viewpoint: Annotated[Floats, Shape("m 2")]
    """Position of the sensor at the first detection, m."""
    nis: Annotated[Floats, Shape("m")]
    """Normalised innovation squared eᵀ S⁻¹ e: running mean; 2 where the model holds."""
    confirmed: Annotated[Booleans, Shape("m")]
    """True for a person that may be reported."""
    has_walked: Annotated[Booleans, Shape("m")]
    """True if it has ever walked, and for all tracks without change detection."""

    @property
    def log_odds(self) -> Floats:
        """ln(p / (1 − p)) that each is a person; (m,)."""
        return self.shape_log_odds + self.motion_log_odds + self.static_penalty

    def __len__(self) -> int:
        """Number of tracks."""
        return len(self.id)


PER_TRACK = tuple(
    field.name for field in fields(TrackerState) if field.name not in {"time", "next_id"}
)
"""Fields with one row per track."""


@value
class PersonDetections:
    """Possible people of one scan, d of them, ordered by distance from the sensor.

    The order makes the result independent of the detector's order.
    """

    time: float
    """s."""
    position: Annotated[Floats, Shape("d 2")]
    """m."""
    radius: Annotated[Floats, Shape("d")]
    """m."""
    deviation: Annotated[Floats, Shape("d")]
    """m."""
    log_odds: Annotated[Floats, Shape("d")]
    """ln(p / (1 − p)) of a person from the shape."""
    arrival_log_odds: Annotated[Floats, Shape("d")]
    """ln(p / (1 − p)) of having arrived at its place; 0 where unknown."""
    shape_weight: Annotated[Floats, Shape("d")]
    """Weight as an observation of the shape, 0…1."""
    origin: Annotated[Floats, Shape("2")]
    """Position of the sensor, m."""
    has_changes: bool
    """True if change detection was used."""

    def __len__(self) -> int:
        """Number of possible people."""
        return len(self.radius)


def person_detections(found: Detections) -> PersonDetections:
    """Sort the people in ``found`` by distance; probabilities are limited to 99 %."""
    d, arrival = len(found.position), found.arrival_log_odds
    offset = found.position - found.origin
    order = np.lexsort((offset[:, 1], offset[:, 0], np.hypot(offset[:, 0], offset[:, 1])))
    p = np.clip(found.confidence[order], _MIN_PROBABILITY, _MAX_PROBABILITY)
    return PersonDetections(
        time=found.time,
        origin=found.origin,
        position=found.position[order],
        radius=found.radius[order],
        deviation=found.deviation[order],
        log_odds=np.log(p / (1.0 - p)),
        arrival_log_odds=np.zeros(d) if arrival is None else arrival[order],
        shape_weight=_shape_weight(found)[order],
        has_changes=arrival is not None,
    )


def _shape_weight(found: Detections) -> Floats:
    """Weight (d,) of each detection: with change detection, few returns show no shape."""
    d, detection = len(found.position), found.detection_of_return
    if found.arrival_log_odds is None:
        return np.ones(d)
    returns = np.bincount(detection[detection >= 0], minlength=d)
    return np.clip((returns - _NO_SHAPE) / (_FULL_SHAPE - _NO_SHAPE), _MIN_SHAPE_WEIGHT, 1.0)


def no_tracks(time: float, next_id: int = 0) -> TrackerState:
    """State without tracks."""
    none = np.empty(0)
    integers, flags = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.bool_)
    rows: dict[str, Any] = dict.fromkeys(PER_TRACK, none)
    rows.update(id=integers, detection_history=integers, confirmed=flags, has_walked=flags)
    rows.update(mean=none.reshape(0, 4), covariance=none.reshape(0, 4, 4))
    rows.update(birthplace=none.reshape(0, 2), viewpoint=none.reshape(0, 2))
    return TrackerState(time=time, next_id=next_id, **rows)


def new_tracks(
    found: PersonDetections, which: Booleans, next_id: int, speed_deviation: float
) -> dict[str, Any]:
    """Fields of tentative tracks at rest for the detections ``which`` (d,)."""
    position, deviation = found.position[which], found.deviation[which]
    d = len(position)
    variance = np.empty((d, 4))
    variance[:, :2] = deviation[:, None] ** 2
    variance[:, 2:] = speed_deviation**2
    now = np.full(d, found.time)
    return {
        "id": next_id + np.arange(d),
        "mean": np.concatenate([position, np.zeros((d, 2))], axis=1),
        "covariance": variance[:, :, None] * np.eye(4),
        "heading": np.full(d, np.nan),
        "radius": found.radius[which],
        "shape_log_odds": found.log_odds[which],
        "shape_looks": found.shape_weight[which],
        "motion_log_odds": np.maximum(found.arrival_log_odds[which], 0.0),
        "static_penalty": np.zeros(d),
        "detection_history": np.ones(d, dtype=np.int64),
        "birth_time": now,
        "last_seen": now,
        "unseen_time": np.zeros(d),
        "seen_through_time": np.zeros(d),
        "birthplace": position,
        "viewpoint": np.tile(found.origin, (d, 1)),
        "nis": np.full(d, INITIAL_NIS),
        "confirmed": np.zeros(d, dtype=np.bool_),
        "has_walked": np.full(d, not found.has_changes),
    }
