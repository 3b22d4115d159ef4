"""Perception in one table: recordings that others made, filmed crowds, odd inputs, and its cost.

Each seed adds a window of the filmed crowds; with as many seeds as a film has windows the whole of
it is walked. All other rows are the same whatever the seeds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
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
from cohelm.evaluation.watching import SEEING, SPACING, parts_of

TITLE = "Perception: people, their ways, their groups, and what finding them costs"
SEEDS = 1
WORKERS = 1

_COLUMNS = ("", "figure", "wanted", "", "of what")


@dataclass(frozen=True)
class PerceptionBench:
    """The benchmark with the parts as they come, or with settings of theirs."""

    settings: tuple[str, ...] = ()
    """``part.parameter=value`` of the parts that see, foresee and give space."""
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
        return [Result(row) for row in _rows(task, folder, self.settings)]

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


def on(settings: Sequence[str] = ()) -> PerceptionBench:
    """The benchmark, its parts with settings.

    Raises:
        ConfigError, PluginError: if there is no such part, or it has no such parameter.
    """
    parts_of(settings, (*SEEING, *SPACING))
    return PerceptionBench(settings=tuple(settings))


def _rows(task: Task, folder: Path, settings: Sequence[str]) -> Iterator[Row]:
    kind, *which = task
    parts: Mapping[str, Any] = {
        "legs": lambda: perception_recordings.legs(folder, settings),
        "demo": lambda: perception_recordings.demo(folder, settings),
        "kitti": lambda: perception_recordings.kitti(folder, settings),
        "crowd": lambda: partial(perception_crowds.crowd, settings=settings)(*which),
        "prediction": lambda: perception_crowds.prediction(settings),
        "maneuvers": lambda: perception_crowds.maneuvers(settings),
        "groups": lambda: perception_crowds.groups(settings),
        "empty": lambda: partial(perception_rooms.empty, settings=settings)(*which),
        "odd": lambda: perception_odd.rows(settings),
        "tracking": lambda: perception_speed.tracking(settings=settings),
        "cloud": lambda: perception_speed.cloud(settings=settings),
        "costs": lambda: perception_speed.costs(folder, settings=settings),
    }
    yield from parts[kind]()


def _cells(row: Mapping[str, Any]) -> tuple[str, ...]:
    figure = "" if row["met"] == NOT_RUN else f"{row['figure']:.4g} {row['unit']}".strip()
    return row["what"], figure, row["wanted"], row["met"], row["remark"]


def _verdict(row: Mapping[str, Any]) -> str:
    return f"MISSED: {row['part']}, {row['what']}: {row['figure']:.4g}, wanted {row['wanted']}"
