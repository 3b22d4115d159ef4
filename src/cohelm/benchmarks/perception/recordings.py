"""Perception on recordings that others made and labelled."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from cohelm.benchmarks.bench import missing_data
from cohelm.benchmarks.claims import (
    Bound,
    measured,
    skipped,
)
from cohelm.evaluation.perception.film import FilmRecorder
from cohelm.evaluation.perception.labelled import (
    LabelScoring,
    LabelSource,
    RecordingLabels,
    read_label_source,
)
from cohelm.evaluation.perception.recording_view import (
    PREDICTION_PARTS,
    RecordingSummary,
    parts_of,
    perceive_frames,
    perception_of,
)
from cohelm.recordings import open_recording
from cohelm.recordings.outside_data import outside_file

DEMO = "legtracker_demo_stationary_simple.bag"
KITTI = "kitti_obj_000000"
NEAREST = Bound(high=0.3)
"""Largest distance from the box's centre, m."""


def demo(folder: Path, settings: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """Unlabelled long bag: number of tracks and id changes."""
    part, file = "demo bag", outside_file("lidar", DEMO)
    if file is None:
        yield skipped(part, DEMO, missing_data("lidar", DEMO))
        return
    _, tracks = _watch(file, folder, None, settings)
    said = f"{tracks.frames} frames, {tracks.end - tracks.begin:.0f} s; see demo.png"
    lasting = len(tracks.lasting())
    yield measured(part, "tracks that live longer than 2 s", lasting, unit="tracks", remark=said)
    yield measured(part, "tracks of any length", len(tracks.trails), unit="tracks")
    yield measured(
        part,
        "id changes",
        tracks.switched_ids(),
        unit="changes",
        remark="a track begins within 1.5 s and 0.7 m of the extrapolation of one that ended: the "
        "bag has no labels",
    )


def kitti(folder: Path, settings: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """Labelled pedestrian of a single frame."""
    part, file = "KITTI", outside_file("lidar", f"{KITTI}.bin")
    labels = outside_file("lidar", f"{KITTI}.label.txt")
    if file is None or labels is None:
        yield skipped(part, "frame 000000", missing_data("lidar", f"{KITTI}.bin"))
        return
    scoring, tracks = _watch(file, folder, read_label_source(labels, file), settings)
    scores = scoring.scores()
    error = scores.error if scores.labels and scores.found == 1.0 else math.nan
    said = f"{scores.labels} labelled in range; {tracks.max_people} tracked; see {file.stem}.png"
    yield measured(
        part, "pedestrian from the box's centre", error, unit="m", bound=NEAREST, remark=said
    )
    yield measured(
        part, "people without a label", scores.unlabelled, unit="people",
        remark="labels cover the camera's view, a quarter of the scan, and people only",
    )  # fmt: skip


def _watch(
    file: Path, folder: Path, truth: LabelSource | None, settings: Sequence[str]
) -> tuple[LabelScoring, RecordingSummary]:
    """Run perception on a recording and draw its busiest instant."""
    scoring, tracks = LabelScoring(truth or RecordingLabels()), RecordingSummary()
    filming = FilmRecorder(**parts_of(settings, PREDICTION_PARTS))
    recording = open_recording(file)
    for seen in perceive_frames(recording, perception_of(settings), still=recording.frames == 1):
        filming.add(seen, scoring(seen))
        tracks.add(seen)
    filming.draw(tracks, folder / f"{picture_of(file)}.png", file.name)
    return scoring, tracks


def picture_of(file: Path) -> str:
    """Name of a recording's picture."""
    return "demo" if file.name == DEMO else file.stem
