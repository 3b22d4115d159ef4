"""Leave-one-recording-out: each open recording is judged by a classifier that never saw it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cohelm.benchmarks.bench import missing_data
from cohelm.benchmarks.claims import NONE, Bound, measured, skipped
from cohelm.benchmarks.perception.classifier_samples import recorded_samples, simulated_samples
from cohelm.benchmarks.perception.classifier_training import SCENES, train
from cohelm.evaluation.perception.labelled import LabelScoring, RecordingLabels
from cohelm.evaluation.perception.recording_view import perceive_frames, perception_of
from cohelm.perception import ScanClusters
from cohelm.recordings import open_recording
from cohelm.recordings.outside_data import outside_file

PART = "held-out recordings"
LABELLED = tuple(f"legtracker_positive_{k}_extracted.bag" for k in (1, 2, 3))
EMPTY = ("legtracker_negative_2_first28s.bag",)
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
        scoring, ids, frames, busy = LabelScoring(RecordingLabels()), set(), 0, 0
        for seen in perceive_frames(open_recording(file), replace(parts, detector=detector)):
            scoring(seen)
            ids |= set(seen.perceived.people.id.tolist())
            frames += 1
            busy += len(seen.perceived.people) > 0
        if name in EMPTY:
            remark = f"of {frames} frames of {name}; {len(ids)} ids"
            yield measured(PART, "frames of empty rooms with somebody", busy, bound=NONE, remark=remark)
            continue
        scores = scoring.scores()
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
