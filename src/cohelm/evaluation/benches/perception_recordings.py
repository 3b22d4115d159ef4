"""What perception makes of recordings that others made and labelled."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from cohelm.evaluation.benches.perception_rows import Row, absent, not_run, row
from cohelm.evaluation.filming import Filming
from cohelm.evaluation.labelled import Own, Scoring, Truth, read_truth
from cohelm.evaluation.perceived_scores import WITHIN
from cohelm.evaluation.watching import SPACING, Tracks, parts_of, perception_of, watch
from cohelm.recordings import open_recording
from cohelm.recordings.outside import outside_file

LEGS = ("legtracker_positive_1_extracted.bag", "legtracker_positive_2_extracted.bag")
DEMO = "legtracker_demo_stationary_simple.bag"
KITTI = "kitti_obj_000000"
LEAST_FOUND, MOST_UNLABELLED, NEAREST = 0.95, 1.0, 0.3
"""Share of the labels; people a frame without a label; m from the box's centre."""


def legs(folder: Path, settings: Sequence[str] = ()) -> Iterator[Row]:
    """The labelled legs of two bags."""
    for name in LEGS:
        part, file = "labelled legs", outside_file("lidar", name)
        if file is None:
            yield not_run(part, name, absent("lidar", name))
            continue
        scoring, tracks = _watch(file, folder, Own(), settings)
        scores = scoring.scores()
        said = f"{scores.labels} labels in {scores.instants} frames of {name}"
        share = f"labels with a person within {WITHIN:g} m"
        yield row(part, share, scores.found, least=LEAST_FOUND, remark=said)
        yield row(
            part,
            "people a frame without a label",
            scores.unlabelled,
            most=MOST_UNLABELLED,
            remark=f"worst frame: {scores.unlabelled_most}; {tracks.most} told at once at most",
        )


def demo(folder: Path, settings: Sequence[str] = ()) -> Iterator[Row]:
    """The long bag, which nobody has labelled: how many tracks, and how steady their ids."""
    part, file = "demo bag", outside_file("lidar", DEMO)
    if file is None:
        yield not_run(part, DEMO, absent("lidar", DEMO))
        return
    _, tracks = _watch(file, folder, None, settings)
    said = f"{tracks.frames} frames, {tracks.end - tracks.begin:.0f} s; see demo.png"
    lasting = len(tracks.lasting())
    yield row(part, "tracks that live longer than 2 s", lasting, unit="tracks", remark=said)
    yield row(part, "tracks of any length", len(tracks.trails), unit="tracks")
    yield row(
        part,
        "id changes",
        tracks.taken_over(),
        unit="changes",
        remark="a track begins within 1.5 s and 0.7 m of where one that ended was going: nobody "
        "labelled it",
    )


def kitti(folder: Path, settings: Sequence[str] = ()) -> Iterator[Row]:
    """The labelled pedestrian of one frame, from this frame alone."""
    part, file = "KITTI", outside_file("lidar", f"{KITTI}.bin")
    labels = outside_file("lidar", f"{KITTI}.label.txt")
    if file is None or labels is None:
        yield not_run(part, "frame 000000", absent("lidar", f"{KITTI}.bin"))
        return
    scoring, tracks = _watch(file, folder, read_truth(labels, file), settings)
    scores = scoring.scores()
    error = scores.error if scores.labels and scores.found == 1.0 else math.nan
    said = f"{scores.labels} labelled within reach; {tracks.most} told in all; see {file.stem}.png"
    yield row(part, "pedestrian from the box's centre", error, unit="m", most=NEAREST, remark=said)
    yield row(
        part, "people without a label", scores.unlabelled, unit="told",
        remark="labels are of what the camera sees, a quarter of the view, and of people only",
    )  # fmt: skip


def _watch(
    file: Path, folder: Path, truth: Truth | None, settings: Sequence[str]
) -> tuple[Scoring, Tracks]:
    """Go through a recording, and leave a picture of its busiest instant."""
    scoring, tracks = Scoring(truth or Own()), Tracks()
    filming = Filming(**parts_of(settings, SPACING))
    recording = open_recording(file)
    for seen in watch(recording, perception_of(settings), still=recording.frames == 1):
        filming.add(seen, scoring(seen))
        tracks.add(seen)
    filming.draw(tracks, folder / f"{picture_of(file)}.png", file.name)
    return scoring, tracks


def picture_of(file: Path) -> str:
    """The name of a recording's picture."""
    return "demo" if file.name == DEMO else file.stem
