"""People who were told, against people who truly were there."""

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
from cohelm.evaluation.mot import Identities
from cohelm.evaluation.perceived_scores import (
    LEAST_VISIBLE,
    WITHIN,
    TruePeople,
    tracking_scores,
)
from cohelm.evaluation.watching import Seen
from cohelm.messages import People
from cohelm.recordings import Labels, open_recording, read_trajectories
from cohelm.recordings.kitti import read_labels

REACH = 10.0
"""Labels farther from where the robot was are not counted, m."""
SLACK = 0.06
"""Between a label's time and that of the frame that it is compared with, s at most."""
_JSON, _WALKS, _SWEEP = {".json", ".jsonl", ".ndjson"}, "obsmat", ".bin"


@value
class Scores:
    """How well the people who were told fit the labels.

    A label is found where anybody is told within ``WITHIN``, so that the labels of two legs may be
    found with one person; the identities match every label with a person of its own.
    """

    instants: int
    """That were compared."""
    labels: int
    """That counted."""
    left_out: int
    """Labels that did not: beyond reach, or hidden."""
    found: float
    """Share of the labels with a person within ``WITHIN``; NaN without a label."""
    unlabelled: float
    """People without any label within ``WITHIN``, mean over the instants."""
    unlabelled_most: int
    """The same at the worst instant."""
    error: float
    """Mean distance of the found labels to the nearest person, m; NaN where none was found."""
    identities: Identities | None
    """None where the labels have no ids."""


class Truth(Protocol):
    """Where people truly were."""

    def at(self, seen: Seen) -> Labels | None:
        """The labels that a frame is to be compared with; None: nobody said."""
        ...


class Noted:
    """Labels at some instants; each is compared with one frame, the first that is near in time."""

    def __init__(self, labels: Sequence[Labels]) -> None:
        self._labels = sorted(labels, key=lambda each: each.time)
        self._times = np.array([each.time for each in self._labels])
        self._slack = SLACK if len(self._labels) > 1 else math.inf
        self._used: set[int] = set()

    def at(self, seen: Seen) -> Labels | None:
        """See :meth:`Truth.at`."""
        if not len(self._times):
            return None
        apart = np.abs(self._times - seen.observation.time)
        k = int(np.argmin(apart))
        if apart[k] > self._slack or k in self._used:
            return None
        self._used.add(k)
        return self._labels[k]


class Own:
    """The labels that come with the recording itself."""

    def at(self, seen: Seen) -> Labels | None:
        """See :meth:`Truth.at`."""
        return seen.labels


class Walked:
    """Recorded walks, the first frame of which was at ``begin``, s; None: with the first shown."""

    def __init__(self, file: Path, begin: float | None = None) -> None:
        self._walks = read_trajectories(file)
        self._begin = begin

    def at(self, seen: Seen) -> Labels | None:
        """See :meth:`Truth.at`."""
        time = seen.observation.time
        self._begin = time if self._begin is None else self._begin
        ids, position, _ = self._walks.at(time - self._begin)
        return Labels(time=time, position=position, id=ids, visible=np.ones(len(ids)))


def read_truth(file: Path, recording: Path, begin: float | None = None) -> Truth:
    """Where people truly were, as a file says.

    Args:
        file: JSON lines as ``cohelm people --json`` writes them, an ``obsmat`` table of walks,
            KITTI's labels (.txt), or a labelled recording.
        recording: that they are to be compared with; KITTI's calibration lies beside it.
        begin: time of the recording's first frame, with which walks begin, s; None: that of the
            first frame which is compared.

    Raises:
        RecordingError: naming the file and what it lacks.
    """
    if file.absolute() == recording.absolute():
        return Own()
    if not file.exists():
        raise RecordingError("no such file", file=file)
    if file.suffix.lower() in _JSON:
        return Noted(_read_lines(file))
    if file.suffix.lower() == ".txt":
        if _WALKS in file.name:
            return Walked(file, begin)
        if recording.suffix.lower() != _SWEEP and not recording.is_dir():
            raise RecordingError(f"labels of KITTI fit its sweeps, not {recording}", file=file)
        return Noted([read_labels(file, recording)])

    labels = [frame.labels for frame in open_recording(file) if frame.labels is not None]
    if not labels:
        raise RecordingError("has no labels", file=file)
    return Noted(labels)


class Scoring:
    """The scores of a recording, frame by frame."""

    def __init__(self, truth: Truth) -> None:
        self._truth = truth
        self._true: list[TruePeople] = []
        self._told: list[People] = []
        self._nearest: list[Floats] = []  # of the labels that count, to the nearest person
        self._unlabelled: list[int] = []
        self._left_out = 0

    def __call__(self, seen: Seen) -> Labels | None:
        """Compare one more frame; returns its labels."""
        labels = self._truth.at(seen)
        if labels is None:
            return None
        people = seen.perceived.people
        ahead = labels.time - people.time if math.isfinite(labels.time) else 0.0
        ahead = ahead if abs(ahead) <= SLACK else 0.0
        told = people.mean[:, :2] + ahead * people.mean[:, 2:]
        origin = seen.observation.pose[:2]
        counts = labels.visible >= LEAST_VISIBLE
        counts &= np.hypot(*(labels.position - origin).T) <= REACH
        apart = np.hypot(*(labels.position[:, None] - told[None]).transpose(2, 0, 1))
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
                asked=counts,
                centre=origin,
            )
        )
        self._told.append(replace(people, mean=np.column_stack([told, people.mean[:, 2:]])))
        return labels

    def scores(self) -> Scores:
        """Of all frames so far.

        Raises:
            PluginError: if the labels have ids and py-motmetrics is not installed.
        """
        nearest = np.concatenate([np.empty(0), *self._nearest])
        found = nearest[nearest <= WITHIN]
        with_ids = all((each.id >= 0).all() for each in self._true) and len(nearest)
        return Scores(
            instants=len(self._true),
            labels=len(nearest),
            left_out=self._left_out,
            found=len(found) / len(nearest) if len(nearest) else math.nan,
            unlabelled=float(np.mean(self._unlabelled)) if self._unlabelled else math.nan,
            unlabelled_most=max(self._unlabelled, default=0),
            error=float(found.mean()) if len(found) else math.nan,
            identities=tracking_scores(self._true, self._told).identities if with_ids else None,
        )


def _read_lines(file: Path) -> list[Labels]:
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError) as cause:
        what = getattr(cause, "strerror", None) or "is no text"
        raise RecordingError(str(what), file=file) from None
    found = []
    for number, line in enumerate(lines, start=1):
        if line.strip():
            labels = _labels_of(line, number, file)
            found += [] if labels is None else [labels]
    if not found:
        raise RecordingError("says of no instant who was there", file=file)
    return found


def _labels_of(line: str, number: int, file: Path) -> Labels | None:
    """One line; None where it is about something else, as the scores at the end."""
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
