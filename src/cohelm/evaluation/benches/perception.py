"""Perception in one table: recordings that others made, filmed crowds, odd inputs, and its cost.

Each seed adds a window of the filmed crowds; with as many seeds as a film has windows the whole of
it is walked. All other rows are the same whatever the seeds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from cohelm.evaluation.benches import (
    perception_crowds,
    perception_odd,
    perception_recordings,
    perception_rooms,
    perception_speed,
)
from cohelm.evaluation.benches.bench import Report, Result, Sheet, Task
from cohelm.evaluation.benches.perception_rows import MET, MISSED, NOT_RUN, Row

TITLE = "Perception: people, their ways, their groups, and what finding them costs"
SEEDS = 1
WORKERS = 1

_COLUMNS = ("", "figure", "wanted", "", "of what")


@dataclass(frozen=True)
class PerceptionBench:
    """The benchmark; it has no options."""

    TITLE: str = TITLE
    SEEDS: int = SEEDS
    WORKERS: int | None = WORKERS

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One for each part of the table."""
        window = (seeds.start, len(seeds))
        return [
            ("legs",),
            ("demo",),
            ("kitti",),
            *(("crowd", *each, *window) for each in perception_crowds.CROWDS),
            ("prediction",),
            ("maneuvers",),
            ("groups",),
            *(("empty", *each) for each in perception_rooms.DRIVES),
            ("odd",),
            ("tracking",),
            ("cloud",),
            ("costs",),
        ]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """The rows of one part."""
        return [Result(row) for row in _rows(task, folder)]

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """A table for each part, and what was met, missed and left out."""
        rows = [result.row for result in results]
        counts = {word: sum(row["met"] == word for row in rows) for word in (MET, MISSED, NOT_RUN)}
        notes = [f"{counts[MET]} met, {counts[MISSED]} missed, {counts[NOT_RUN]} not run"]
        notes += [_verdict(row) for row in rows if row["met"] == MISSED]
        notes += [f"not run: {row['part']}, {row['what']}: {row['remark']}" for row in rows
                  if row["met"] == NOT_RUN]  # fmt: skip
        sheets = tuple(
            Sheet(title=part, columns=_COLUMNS, rows=tuple(_cells(row) for row in each))
            for part, each in groupby(rows, key=lambda row: str(row["part"]))
        )
        pictures = sorted(folder.glob("*.png"))
        return Report(sheets=sheets, notes=tuple(notes), summary=counts, files=tuple(pictures))


def on() -> PerceptionBench:
    """The benchmark."""
    return PerceptionBench()


def _rows(task: Task, folder: Path) -> Iterator[Row]:
    kind, *which = task
    parts: Mapping[str, Any] = {
        "legs": lambda: perception_recordings.legs(folder),
        "demo": lambda: perception_recordings.demo(folder),
        "kitti": lambda: perception_recordings.kitti(folder),
        "crowd": lambda: perception_crowds.crowd(*which),
        "prediction": perception_crowds.prediction,
        "maneuvers": perception_crowds.maneuvers,
        "groups": perception_crowds.groups,
        "empty": lambda: perception_rooms.empty(*which),
        "odd": perception_odd.rows,
        "tracking": perception_speed.tracking,
        "cloud": perception_speed.cloud,
        "costs": lambda: perception_speed.costs(folder),
    }
    yield from parts[kind]()


def _cells(row: Mapping[str, Any]) -> tuple[str, ...]:
    figure = "" if row["met"] == NOT_RUN else f"{row['figure']:.4g} {row['unit']}".strip()
    return row["what"], figure, row["wanted"], row["met"], row["remark"]


def _verdict(row: Mapping[str, Any]) -> str:
    return f"MISSED: {row['part']}, {row['what']}: {row['figure']:.4g}, wanted {row['wanted']}"
