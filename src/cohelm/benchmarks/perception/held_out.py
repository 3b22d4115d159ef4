"""Leave-one-out test: each recording is scored with a classifier trained without it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.benchmarks.bench import missing_data
from cohelm.benchmarks.claims import NONE, Bound, measured, skipped
from cohelm.benchmarks.perception.classifier_samples import recorded_samples, simulated_samples
from cohelm.benchmarks.perception.classifier_training import SCENES, train
from cohelm.evaluation.perception.labelled import LabelScores, LabelScoring, RecordingLabels
from cohelm.evaluation.perception.recording_view import perceive_frames, perception_of
from cohelm.perception import PerceptionParts, ScanClusters
from cohelm.recordings import open_recording
from cohelm.recordings.outside_data import outside_file

PART = "held-out recordings"
LABELLED = tuple(f"legtracker_positive_{k}_extracted.bag" for k in (1, 2, 3))
EMPTY = ("legtracker_negative_2_first28s.bag",)
SCANNERS = (None, "/left_scan", "/rear_scan", "/right_scan")
"""Topics of the empty rooms. None: all at once; their mounts are not recorded, so that each is
tracked by itself."""
LEAST_FOUND, MOST_UNLABELLED = Bound(low=0.92), Bound(high=1.2)
MEAN_FOUND, MEAN_UNLABELLED = Bound(low=0.95), Bound(high=0.7)
"""Bounds of each recording, and of the mean over the recordings."""


def held_out(settings: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """Train without each recording in turn, and score the pipeline on it."""
    files = {name: outside_file("lidar", name) for name in (*LABELLED, *EMPTY)}
    for name in (name for name, file in files.items() if file is None):
        yield skipped(PART, name, missing_data("lidar", name))
    known = {name: file for name, file in files.items() if file is not None}
    if not known:
        return
    simulated = simulated_samples(range(SCENES))
    samples = {n: recorded_samples(file, empty=n in EMPTY) for n, file in known.items()}
    parts, found = perception_of(settings), []
    for name, file in known.items():
        trees = train(simulated, [each for other, each in samples.items() if other != name])
        detector = ScanClusters(getattr(parts.detector, "parameters", None), trees)
        judged = replace(parts, detector=detector)
        if name in EMPTY:
            yield from (_empty(file, topic, judged) for topic in SCANNERS)
            continue
        scores = _scores(file, judged)
        found.append((scores.found, scores.unlabelled))
        said = f"{scores.labels} labels in {scores.instants} frames of {name}"
        yield measured(PART, "labels found", scores.found, bound=LEAST_FOUND, remark=said)
        yield measured(
            PART, "people per frame without a label", scores.unlabelled, bound=MOST_UNLABELLED,
            remark=f"worst frame: {scores.unlabelled_most}",
        )  # fmt: skip
    if found:
        recall, extra = np.mean(found, axis=0)
        yield measured(PART, "labels found, mean", float(recall), bound=MEAN_FOUND)
        yield measured(PART, "people without a label, mean", float(extra), bound=MEAN_UNLABELLED)


def _empty(file: Path, topic: str | None, parts: PerceptionParts) -> dict[str, Any]:
    """Row of a recording without people, by one scanner or by all."""
    frames, busy, ids = 0, 0, set()
    for seen in perceive_frames(open_recording(file, topic=topic), parts):
        frames += 1
        busy += len(seen.perceived.people) > 0
        ids |= set(seen.perceived.people.id.tolist())
    remark = f"of {frames} frames of {file.name}, {topic or 'all scanners'}; {len(ids)} ids"
    name = "frames of empty rooms with a detected person"
    return measured(PART, name, busy, bound=NONE, remark=remark)


def _scores(file: Path, parts: PerceptionParts) -> LabelScores:
    scoring = LabelScoring(RecordingLabels())
    for seen in perceive_frames(open_recording(file), parts):
        scoring(seen)
    return scoring.scores()
