"""Scores of tracked people in a recording against labels."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from cohelm.arrays import Floats, value
from cohelm.errors import RecordingError
from cohelm.evaluation.perception.recording_view import PerceivedFrame
from cohelm.evaluation.perception.tracking_scores import (
    LEAST_VISIBLE,
    WITHIN,
    IdentityScores,
    TruePeople,
    tracking_scores,
)
from cohelm.messages import People
from cohelm.recordings import Labels, open_recording, read_trajectories
from cohelm.recordings.clouds.kitti import read_labels

REACH = 10.0
"""Distance from the robot beyond which labels do not count, m."""
SLACK = 0.06
"""Largest difference between the times of a label and of its frame, s."""
_JSON, _WALKS, _SWEEP = {".json", ".jsonl", ".ndjson"}, "obsmat", ".bin"


@value
class LabelScores:
    """Agreement of tracked people with labels.

    A label is found if any person is tracked within ``WITHIN``, so one person may cover the labels
    of two legs. The identity scores match every label with a person of its own.
    """

    instants: int
    """Compared instants."""
    labels: int
    """Labels that counted."""
    left_out: int
    """Labels that did not count: too far, or hidden."""
    found: float
    """Share of the labels with a person within ``WITHIN``; NaN without a label."""
    unlabelled: float
    """People without a label within ``WITHIN``, mean over the instants."""
    unlabelled_most: int
    """Largest number of such people at one instant."""
    error: float
    """Mean distance of the found labels to the nearest person, m; NaN where none was found."""
    identities: IdentityScores | None
    """None where the labels have no ids."""


class LabelSource(Protocol):
    """Source of labels."""

    def at(self, seen: PerceivedFrame) -> Labels | None:
        """Labels of a frame; None: there are none."""
        ...


class LabelledInstants:
    """Labels at some instants; each is compared with the first frame near in time."""

    def __init__(self, labels: Sequence[Labels]) -> None:
        self._labels = sorted(labels, key=lambda each: each.time)
        self._times = np.array([each.time for each in self._labels])
        self._slack = SLACK if len(self._labels) > 1 else math.inf
        self._used: set[int] = set()

    def at(self, seen: PerceivedFrame) -> Labels | None:
        """See :meth:`LabelSource.at`."""
        if not len(self._times):
            return None
        apart = np.abs(self._times - seen.observation.time)
        k = int(np.argmin(apart))
        if apart[k] > self._slack or k in self._used:
            return None
        self._used.add(k)
        return self._labels[k]


class RecordingLabels:
    """Labels of the recording itself."""

    def at(self, seen: PerceivedFrame) -> Labels | None:
        """See :meth:`LabelSource.at`."""
        return seen.labels


class TrajectoryLabels:
    """Recorded trajectories that begin at ``begin``, s; None: with the first frame."""

    def __init__(self, file: Path, begin: float | None = None) -> None:
        self._walks = read_trajectories(file)
        self._begin = begin

    def at(self, seen: PerceivedFrame) -> Labels | None:
        """See :meth:`LabelSource.at`."""
        time = seen.observation.time
        self._begin = time if self._begin is None else self._begin
        ids, position, _ = self._walks.at(time - self._begin)
        return Labels(time=time, position=position, id=ids, visible=np.ones(len(ids)))


def read_label_source(file: Path, recording: Path, begin: float | None = None) -> LabelSource:
    """Read labels from a file.

    Args:
        file: JSON lines as ``cohelm people --json`` writes them, an ``obsmat`` table of walks,
            KITTI's labels (.txt), or a labelled recording.
        recording: recording to compare with; KITTI's calibration lies beside it.
        begin: time of the recording's first frame, at which trajectories begin, s; None: that of
            the first compared frame.

    Raises:
        RecordingError: naming the file and what it lacks.
    """
    if file.absolute() == recording.absolute():
        return RecordingLabels()
    if not file.exists():
        raise RecordingError("no such file", file=file)
    if file.suffix.lower() in _JSON:
        return LabelledInstants(_read_lines(file))
    if file.suffix.lower() == ".txt":
        if _WALKS in file.name:
            return TrajectoryLabels(file, begin)
        if recording.suffix.lower() != _SWEEP and not recording.is_dir():
            raise RecordingError(f"labels of KITTI fit its sweeps, not {recording}", file=file)
        return LabelledInstants([read_labels(file, recording)])

    labels = [frame.labels for frame in open_recording(file) if frame.labels is not None]
    if not labels:
        raise RecordingError("has no labels", file=file)
    return LabelledInstants(labels)


class LabelScoring:
    """Scores of a recording, frame by frame."""

    def __init__(self, truth: LabelSource) -> None:
        self._truth = truth
        self._true: list[TruePeople] = []
        self._tracked: list[People] = []
        self._nearest: list[Floats] = []  # distances of the counting labels to the nearest person
        self._unlabelled: list[int] = []
        self._left_out = 0

    def __call__(self, seen: PerceivedFrame) -> Labels | None:
        """Compare one frame; returns its labels."""
        labels = self._truth.at(seen)
        if labels is None:
            return None
        people = seen.perceived.people
        ahead = labels.time - people.time if math.isfinite(labels.time) else 0.0
        ahead = ahead if abs(ahead) <= SLACK else 0.0
        tracked = people.mean[:, :2] + ahead * people.mean[:, 2:]
        origin = seen.observation.pose[:2]
        counts = labels.visible >= LEAST_VISIBLE
        counts &= np.hypot(*(labels.position - origin).T) <= REACH
        apart = np.hypot(*(labels.position[:, None] - tracked[None]).transpose(2, 0, 1))
        self._nearest.append(apart.min(axis=1, initial=np.inf)[counts])
        self._unlabelled.append(int((apart > WITHIN).all(axis=0).sum()))
        self._left_out += int((~counts).sum())
        self._true.append(
            TruePeople(
                time=labels.time,
                id=labels.id,
                position=labels.position,
                velocity=np.full_like(labels.position, np.nan),
                visible=labels.visible,
                required=counts,
                centre=origin,
            )
        )
        self._tracked.append(replace(people, mean=np.column_stack([tracked, people.mean[:, 2:]])))
        return labels

    def scores(self) -> LabelScores:
        """Scores of all frames so far.

        Raises:
            PluginError: if the labels have ids and py-motmetrics is not installed.
        """
        nearest = np.concatenate([np.empty(0), *self._nearest])
        found = nearest[nearest <= WITHIN]
        with_ids = all((each.id >= 0).all() for each in self._true) and len(nearest)
        return LabelScores(
            instants=len(self._true),
            labels=len(nearest),
            left_out=self._left_out,
            found=len(found) / len(nearest) if len(nearest) else math.nan,
            unlabelled=float(np.mean(self._unlabelled)) if self._unlabelled else math.nan,
            unlabelled_most=max(self._unlabelled, default=0),
            error=float(found.mean()) if len(found) else math.nan,
            identities=tracking_scores(self._true, self._tracked).identities if with_ids else None,
        )


def _read_lines(file: Path) -> list[Labels]:
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError) as cause:
        what = getattr(cause, "strerror", None) or "is not text"
        raise RecordingError(str(what), file=file) from None
    found = []
    for number, line in enumerate(lines, start=1):
        if line.strip():
            labels = _labels_of(line, number, file)
            found += [] if labels is None else [labels]
    if not found:
        raise RecordingError("has no labelled instant", file=file)
    return found


def _labels_of(line: str, number: int, file: Path) -> Labels | None:
    """Labels of one line; None for other lines, such as the scores at the end."""
    try:
        data: Any = json.loads(line)
        if not {"t", "people"} & data.keys():
            return None
        people = data["people"]
        position = np.array([[each["x"], each["y"]] for each in people], dtype=float)
        time = float(data["t"])
        ids = np.array([-1 if each.get("id") is None else each["id"] for each in people], dtype=int)
    except (ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError):
        time, position, ids = math.nan, np.empty(0), np.empty(0, dtype=int)
    if not (math.isfinite(time) and np.isfinite(position).all()):
        form = '{"t": seconds, "people": [{"id": 1, "x": metres, "y": metres}]}'
        raise RecordingError(f"line {number}: write one instant as {form}", file=file)
    return Labels(time=time, position=position.reshape(-1, 2), id=ids, visible=np.ones(len(ids)))
