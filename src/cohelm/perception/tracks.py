"""What a tracker remembers, and what it is told of people in one scan."""

from __future__ import annotations

from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.perception.api import Detections

_SHAPELESS, _SHAPELY = 3.0, 8.0
"""Returns that show no shape, and that show it whole."""

PER_TRACK = (
    "id",
    "mean",
    "covariance",
    "heading",
    "radius",
    "shape",
    "looks",
    "motion",
    "history",
    "born",
    "seen",
    "absent",
    "passed",
    "birthplace",
    "viewpoint",
    "surprise",
    "confirmed",
    "rest",
    "walked",
)


@value
class TrackerState:
    """Tracks at the time of the last scan, tentative ones included; m of them, by growing id."""

    time: float
    """Of the last scan that was used, s."""
    next_id: int
    id: Annotated[Integers, Shape("m")]
    mean: Annotated[Floats, Shape("m 4")]
    """(x, y, v_x, v_y), m and m/s."""
    covariance: Annotated[Floats, Shape("m 4 4")]
    heading: Annotated[Floats, Shape("m")]
    """rad; NaN until the track has walked."""
    radius: Annotated[Floats, Shape("m")]
    """m."""
    shape: Annotated[Floats, Shape("m")]
    """Running mean of the log-odds of a person that its shape gives."""
    looks: Annotated[Floats, Shape("m")]
    """How often its shape was looked at, a look with few returns counted in part."""
    motion: Annotated[Floats, Shape("m")]
    """Log-odds of a person that its walking has earned, ≥ 0."""
    history: Annotated[Integers, Shape("m")]
    """Bit k: seen k scans ago, of those that looked there."""
    born: Annotated[Floats, Shape("m")]
    """Time of its first sighting, s."""
    seen: Annotated[Floats, Shape("m")]
    """Time of its last sighting, s."""
    absent: Annotated[Floats, Shape("m")]
    """For how long it has not been seen, weighted by what was seen in its place, s."""
    passed: Annotated[Floats, Shape("m")]
    """For how long its place was seen through since it was last seen, s."""
    birthplace: Annotated[Floats, Shape("m 2")]
    """m."""
    viewpoint: Annotated[Floats, Shape("m 2")]
    """Where the sensor was at its first sighting, m."""
    surprise: Annotated[Floats, Shape("m")]
    """Running mean of the normalised squared innovations; 2 where the model holds."""
    confirmed: Annotated[Booleans, Shape("m")]
    """A person, and told."""
    rest: Annotated[Floats, Shape("m")]
    """Running mean of the log-odds that it costs to stand where something always stood, ≤ 0."""
    walked: Annotated[Booleans, Shape("m")]
    """Whether it has ever walked; true as well where nobody compared with what was there before."""

    @property
    def log_odds(self) -> Floats:
        """ln(p / (1 − p)) that each is a person; (m,)."""
        return self.shape + self.motion + self.rest

    def __len__(self) -> int:
        """How many tracks."""
        return len(self.id)


@value
class Sightings:
    """The possible people of one scan, d of them, from the nearest to the sensor on.

    The order makes the result independent of that in which a detector tells them.
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
    """ln(p / (1 − p)) of a person by its shape."""
    moved: Annotated[Floats, Shape("d")]
    """Log-odds that it has come to where it is; 0 where not known."""
    weight: Annotated[Floats, Shape("d")]
    """How much of a look each is, 0…1."""
    origin: Annotated[Floats, Shape("2")]
    """Where the sensor was, m."""
    compared: bool
    """Whether what was there before was asked for at all."""

    def __len__(self) -> int:
        """How many."""
        return len(self.radius)


def sightings(seen: Detections) -> Sightings:
    """The people in ``seen``, in an order of their own; a probability counts up to 99 %."""
    offset = seen.position - seen.origin
    order = np.lexsort((offset[:, 1], offset[:, 0], np.hypot(offset[:, 0], offset[:, 1])))
    p = np.clip(seen.confidence[order], 0.01, 0.99)
    return Sightings(
        time=seen.time,
        origin=seen.origin,
        position=seen.position[order],
        radius=seen.radius[order],
        deviation=seen.deviation[order],
        log_odds=np.log(p / (1.0 - p)),
        moved=np.zeros(len(order)) if seen.moved is None else seen.moved[order],
        weight=_weight(seen)[order],
        compared=seen.moved is not None,
    )


def _weight(seen: Detections) -> Floats:
    """How much of a look each of the seen is (d,), where it is asked what has moved.

    Few returns of a planar scan show no shape.
    """
    d = len(seen.position)
    if seen.moved is None:
        return np.ones(d)
    returns = np.bincount(seen.owner[seen.owner >= 0], minlength=d)
    return np.clip((returns - _SHAPELESS) / (_SHAPELY - _SHAPELESS), 0.1, 1.0)


def no_tracks(time: float, next_id: int = 0) -> TrackerState:
    """Nobody yet."""
    none = np.empty(0)
    whole, flags = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.bool_)
    shapes: dict[str, Any] = dict.fromkeys(PER_TRACK, none)
    shapes.update(id=whole, history=whole, confirmed=flags, walked=flags)
    shapes.update(mean=none.reshape(0, 4))
    shapes.update(covariance=none.reshape(0, 4, 4), birthplace=none.reshape(0, 2))
    shapes.update(viewpoint=none.reshape(0, 2))
    return TrackerState(time=time, next_id=next_id, **shapes)


def newborn(seen: Sightings, which: Booleans, next_id: int, speed_deviation: float) -> Any:
    """The fields of a tentative track, at rest and unsure of it, for ``which`` (d,) of the seen."""
    position, deviation = seen.position[which], seen.deviation[which]
    d = len(position)
    variance = np.empty((d, 4))
    variance[:, :2] = deviation[:, None] ** 2
    variance[:, 2:] = speed_deviation**2
    now = np.full(d, seen.time)
    return {
        "id": next_id + np.arange(d),
        "mean": np.concatenate([position, np.zeros((d, 2))], axis=1),
        "covariance": variance[:, :, None] * np.eye(4),
        "heading": np.full(d, np.nan),
        "radius": seen.radius[which],
        "shape": seen.log_odds[which],
        "looks": seen.weight[which],
        "motion": np.maximum(seen.moved[which], 0.0),
        "history": np.ones(d, dtype=np.int64),
        "born": now,
        "seen": now,
        "absent": np.zeros(d),
        "passed": np.zeros(d),
        "birthplace": position,
        "viewpoint": np.tile(seen.origin, (d, 1)),
        "surprise": np.full(d, 2.0),
        "confirmed": np.zeros(d, dtype=np.bool_),
        "rest": np.zeros(d),
        "walked": np.full(d, not seen.compared),
    }
