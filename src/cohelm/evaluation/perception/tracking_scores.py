"""Scores of tracked people against ground truth: identities, position and velocity errors.

A true person who need not be detected (too far, hidden) counts neither as missed nor as false: a
track at such a person is left out, as is a track beyond the range in which people count.
"""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.errors import PluginError
from cohelm.messages import People

WITHIN = 0.5
"""Largest distance between a track and its true person, m."""
LEAST_VISIBLE = 0.3
"""Smallest visible share of a body that has to be detected."""


@value
class FrameMatch:
    """True and tracked people at one instant."""

    true_id: Annotated[Integers, Shape("k")]
    true: Annotated[Floats, Shape("k 2")]
    """m."""
    tracked_id: Annotated[Integers, Shape("n")]
    tracked: Annotated[Floats, Shape("n 2")]
    """m."""


@value
class IdentityScores:
    """CLEAR MOT and identity measures; Bernardin and Stiefelhagen 2008, Ristani et al. 2016."""

    mota: float
    """1 − (misses + false positives + identity switches) / true positions."""
    idf1: float
    """F1 score of positions with the right identity."""
    switches: int
    """Number of identity switches."""
    misses: int
    """True positions without a track."""
    false: int
    """Tracked positions without a person."""
    positions: int
    """Number of true positions."""


@value
class TruePeople:
    """True people at one instant; n people."""

    time: float
    """s."""
    id: Annotated[Integers, Shape("n")]
    position: Annotated[Floats, Shape("n 2")]
    """Map frame, m."""
    velocity: Annotated[Floats, Shape("n 2")]
    """m/s; NaN: unknown."""
    visible: Annotated[Floats, Shape("n")]
    """Visible share of the body, 0…1."""
    required: Annotated[Booleans, Shape("n")]
    """People who have to be detected; the others may be."""
    centre: Annotated[Floats, Shape("2")]
    """Centre of the range in which tracks count, m."""
    extent: float = np.inf
    """Radius of that range, m; false tracks beyond it do not count."""


@value
class TrackingScores:
    """Scores of f frames with s sightings of required people."""

    identities: IdentityScores
    """MOTA, IDF1 and their counts."""
    frames: int
    frame: Annotated[Integers, Shape("s")]
    """Index of each sighting's frame."""
    person: Annotated[Integers, Shape("s")]
    """True id."""
    position: Annotated[Floats, Shape("s 2")]
    """True, m."""
    visible: Annotated[Floats, Shape("s")]
    """Share of the body."""
    tracked_id: Annotated[Integers, Shape("s")]
    """Id of the track, −1: missed."""
    offset: Annotated[Floats, Shape("s 2")]
    """Error of the position, m; NaN where missed."""
    velocity_offset: Annotated[Floats, Shape("s 2")]
    """Error of the velocity, m/s; NaN where missed."""
    false_tracks: Annotated[Floats, Shape("i 4")]
    """(frame, id, x, y) of every track without a person."""
    confidences: Annotated[Floats, Shape("c 2")]
    """(confidence, 1 with a person, else 0) of every track in any frame."""

    @property
    def position_error(self) -> float:
        """Mean error of the tracked positions, m; NaN without any."""
        return _mean_length(self.offset)

    @property
    def velocity_error(self) -> float:
        """Mean error of the tracked velocities, m/s; NaN without any."""
        return _mean_length(self.velocity_offset)

    @property
    def calibration(self) -> Floats:
        """(10, 3), for each tenth of the confidence: its mean, the share of people, the count."""
        bins = np.minimum((10.0 * self.confidences[:, 0]).astype(np.int64), 9)
        count = np.bincount(bins, minlength=10)
        with np.errstate(invalid="ignore"):
            means = [np.bincount(bins, column, 10) / count for column in self.confidences.T]
        return np.stack([*means, count], axis=-1)


def tracking_scores(
    truth: Sequence[TruePeople], tracked: Sequence[People], *, within: float = WITHIN
) -> TrackingScores:
    """Score the tracks of each frame against ground truth.

    Each frame matches as many people as possible with the smallest sum of distances; the errors are
    those of these matches. py-motmetrics matches on its own and keeps an identity while it fits.

    Args:
        truth: f frames.
        tracked: tracks in the same frames.
        within: largest distance of a match, m.

    Raises:
        PluginError: where py-motmetrics is not installed.
    """
    compared: list[FrameMatch] = []
    rows: list[Floats] = [np.empty((0, 10))]
    false_tracks, confidences = [np.empty((0, 4))], [np.empty((0, 2))]
    for k, (true, people) in enumerate(zip(truth, tracked, strict=True)):
        match = _matches(true, people, within)
        near = np.hypot(*(people.mean[:, :2] - true.centre).T) <= true.extent
        unmatched = np.setdiff1d(np.flatnonzero(near), match)
        counted = np.union1d(unmatched, match[true.required & (match >= 0)])
        compared.append(
            FrameMatch(
                true_id=true.id[true.required],
                true=true.position[true.required],
                tracked_id=people.id[counted],
                tracked=people.mean[counted, :2],
            )
        )
        rows.append(_sightings(k, true, people, match))
        alone = np.full(len(unmatched), float(k))
        false_tracks.append(
            np.column_stack([alone, people.id[unmatched], people.mean[unmatched, :2]])
        )
        right = np.isin(np.arange(len(people)), match)
        confidences.append(np.column_stack([people.confidence, right]))
    table = np.concatenate(rows)
    return TrackingScores(
        identities=identities(compared, within),
        frames=len(compared),
        frame=table[:, 0].astype(np.int64),
        person=table[:, 1].astype(np.int64),
        tracked_id=table[:, 2].astype(np.int64),
        visible=table[:, 3],
        position=table[:, 4:6],
        offset=table[:, 6:8],
        velocity_offset=table[:, 8:],
        false_tracks=np.concatenate(false_tracks),
        confidences=np.concatenate(confidences),
    )


def _matches(true: TruePeople, people: People, within: float) -> Integers:
    """Index of the track of each true person, (n,), −1: none."""
    offset = true.position[:, None] - people.mean[None, :, :2]
    distance = np.hypot(offset[..., 0], offset[..., 1])
    near = distance <= within
    rows, cols = linear_sum_assignment(np.where(near, distance, 1e3))
    match = np.full(len(true.id), -1)
    match[rows] = np.where(near[rows, cols], cols, -1)
    return match


def _sightings(k: int, true: TruePeople, people: People, match: Integers) -> Floats:
    """(s, 10) of required people: frame, id, track id, visible, position, both errors."""
    required = np.flatnonzero(true.required)
    found = match[required] >= 0
    mean = np.full((len(required), 4), np.nan)
    mean[found] = people.mean[match[required[found]]]
    tracked_id = np.full(len(required), -1)
    tracked_id[found] = people.id[match[required[found]]]
    return np.column_stack(
        [
            np.full(len(required), k),
            true.id[required],
            tracked_id,
            true.visible[required],
            true.position[required],
            mean[:, :2] - true.position[required],
            mean[:, 2:] - true.velocity[required],
        ]
    )


def _mean_length(vectors: Floats) -> float:
    length = np.hypot(vectors[:, 0], vectors[:, 1])
    known = length[np.isfinite(length)]
    return float(known.mean()) if len(known) else float("nan")


def identities(instants: Iterable[FrameMatch], within: float) -> IdentityScores:
    """Compute identity scores; a pair farther apart than ``within``, m, never matches.

    Raises:
        PluginError: if py-motmetrics is not installed.
    """
    names = ("mota", "idf1", "num_switches", "num_misses", "num_false_positives", "num_objects")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # divisions by zero, and deprecations in pandas
        mm = _motmetrics()
        accumulator = mm.MOTAccumulator(auto_id=True)
        for each in instants:
            apart = np.hypot(*(each.true[:, None] - each.tracked[None]).transpose(2, 0, 1))
            apart = np.where(apart <= within, apart, np.nan)
            accumulator.update(each.true_id.tolist(), each.tracked_id.tolist(), apart)
        row = mm.metrics.create().compute(accumulator, metrics=list(names)).iloc[0]
    return IdentityScores(
        mota=float(row["mota"]),
        idf1=float(row["idf1"]),
        switches=int(row["num_switches"]),
        misses=int(row["num_misses"]),
        false=int(row["num_false_positives"]),
        positions=int(row["num_objects"]),
    )


def _motmetrics() -> Any:
    try:
        return importlib.import_module("motmetrics")
    except ImportError:
        raise PluginError(
            "py-motmetrics, which MOTA and IDF1 need, is not installed: pip install cohelm[bench]"
        ) from None
