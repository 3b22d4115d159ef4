"""People who were told, against people who truly were there."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from cohelm.arrays import Floats, value
from cohelm.errors import RecordingError
from cohelm.evaluation.mot import Compared, Identities, identities
from cohelm.evaluation.watching import Seen
from cohelm.recordings import Labels, open_recording, read_trajectories
from cohelm.recordings.kitti import read_labels

WITHIN = 0.5
"""A label is found where a person is told no farther from it, m."""
REACH = 10.0
"""Labels farther from the sensor are not counted, m: the pipeline's window ends there."""
LEAST_VISIBLE = 0.3
"""Labels of whom the sensor saw a smaller share are not counted."""
SLACK = 0.06
"""Between a label's time and that of the frame that it is compared with, s at most."""
_JSON, _WALKS = {".json", ".jsonl", ".ndjson"}, "obsmat"


@value
class Scores:
    """How well the people who were told fit the labels."""

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
    """Recorded walks that begin with the recording's first frame."""

    def __init__(self, file: Path) -> None:
        self._walks = read_trajectories(file)
        self._begin: float | None = None

    def at(self, seen: Seen) -> Labels | None:
        """See :meth:`Truth.at`."""
        time = seen.observation.time
        self._begin = time if self._begin is None else self._begin
        ids, position, _ = self._walks.at(time - self._begin)
        return Labels(time=time, position=position, id=ids, visible=np.ones(len(ids)))


def read_truth(file: Path, recording: Path) -> Truth:
    """Where people truly were, as a file says.

    Args:
        file: JSON lines as ``cohelm people --json`` writes them, an ``obsmat`` table of walks,
            KITTI's labels (.txt), or a labelled recording.
        recording: that they are to be compared with; KITTI's calibration lies beside it.

    Raises:
        RecordingError: naming the file and what it lacks.
    """
    if file.absolute() == recording.absolute():
        return Own()
    if file.suffix.lower() in _JSON:
        return Noted(_read_lines(file))
    if file.suffix.lower() == ".txt":
        if _WALKS in file.name:
            return Walked(file)
        return Noted([read_labels(file, recording)])

    labels = [frame.labels for frame in open_recording(file) if frame.labels is not None]
    if not labels:
        raise RecordingError("has no labels", file=file)
    return Noted(labels)


class Scoring:
    """The scores of a recording, frame by frame."""

    def __init__(self, truth: Truth) -> None:
        self._truth = truth
        self._compared: list[Compared] = []
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
        counts = labels.visible >= LEAST_VISIBLE
        origin = seen.observation.pose[:2]
        counts &= np.hypot(*(labels.position - origin).T) <= REACH
        apart = np.hypot(*(labels.position[:, None] - told[None]).transpose(2, 0, 1))
        self._nearest.append(apart.min(axis=1, initial=np.inf)[counts])
        spare = (apart > WITHIN).all(axis=0)
        self._unlabelled.append(int(spare.sum()))
        self._left_out += int((~counts).sum())
        judged = spare | (apart[counts] <= WITHIN).any(axis=0)
        self._compared.append(
            Compared(
                true_id=labels.id[counts],
                true=labels.position[counts],
                told_id=people.id[judged],
                told=told[judged],
            )
        )
        return labels

    def scores(self) -> Scores:
        """Of all frames so far.

        Raises:
            PluginError: if the labels have ids and py-motmetrics is not installed.
        """
        nearest = np.concatenate([np.empty(0), *self._nearest])
        found = nearest[nearest <= WITHIN]
        with_ids = all((each.true_id >= 0).all() for each in self._compared) and len(nearest)
        return Scores(
            instants=len(self._compared),
            labels=len(nearest),
            left_out=self._left_out,
            found=len(found) / len(nearest) if len(nearest) else math.nan,
            unlabelled=float(np.mean(self._unlabelled)) if self._unlabelled else math.nan,
            unlabelled_most=max(self._unlabelled, default=0),
            error=float(found.mean()) if len(found) else math.nan,
            identities=identities(self._compared, WITHIN) if with_ids else None,
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
