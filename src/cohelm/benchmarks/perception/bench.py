"""Perception in one table: labelled recordings, filmed crowds, invalid readings, cost.

Each seed adds a window of the filmed crowds; with as many seeds as a film has windows the whole
film is replayed. All other rows do not depend on the seeds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cohelm.benchmarks.bench import BenchReport, Result, Task, known_name
from cohelm.benchmarks.claims import measured_notes, measured_sheets
from cohelm.benchmarks.options import repeatable
from cohelm.benchmarks.perception import (
    cost,
    empty_floors,
    filmed_crowds,
    held_out,
    invalid_readings,
    recordings,
    walking_aids,
)
from cohelm.evaluation.perception.recording_view import DETECTION_PARTS, PREDICTION_PARTS, parts_of

TITLE = "Perception: people, their motion and groups, and computing time"


@dataclass(frozen=True)
class PerceptionBench:
    """The benchmark with default parts, or with settings of theirs."""

    settings: tuple[str, ...] = ()
    """``part.parameter=value`` of detectors, tracker, predictor, groups and social model."""
    parts: tuple[str, ...] = ()
    """Parts of the table; empty: all."""
    TITLE: str = TITLE
    SEEDS: int = 1
    WORKERS: int | None = 1

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per part of the table."""
        window = (seeds.start, len(seeds))
        tasks: list[Task] = [
            ("held_out",),
            ("walking_aids",),
            ("demo",),
            ("kitti",),
            *(("crowd", *each, *window) for each in filmed_crowds.CROWDS),
            ("prediction",),
            ("prediction_cost",),
            ("groups",),
            *(("empty", *each) for each in empty_floors.DRIVES),
            ("invalid",),
            ("tracking",),
            ("cloud",),
            ("costs",),
        ]
        return [task for task in tasks if not self.parts or task[0] in self.parts]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Rows of one part."""
        return [Result(row) for row in _rows(task, folder, self.settings)]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Table per part, and the figures that missed their bounds or were not measured."""
        rows = [result.row for result in results]
        return BenchReport(
            sheets=measured_sheets(rows),
            notes=measured_notes(rows),
            summary={},
            files=tuple(sorted(folder.glob("*.png"))),
        )


def create(
    settings: Annotated[
        tuple[str, ...],
        repeatable("--set", "KEY=VALUE", "Parameter of a perception part: tracker.gate=4"),
    ] = (),
    parts: Annotated[
        tuple[str, ...],
        repeatable(
            "--part",
            "NAME",
            "held_out, walking_aids, crowd, …; default: all",
        ),
    ] = (),
) -> PerceptionBench:
    """Create the benchmark with some parts of the table, and settings of perception's parts.

    Raises:
        ConfigError, PluginError: if there is no such part, or it has no such parameter.
    """
    parts_of(settings, (*DETECTION_PARTS, *PREDICTION_PARTS))
    known = list(dict.fromkeys(str(task[0]) for task in PerceptionBench().tasks(range(1))))
    for part in parts:
        known_name(part, known, "part", "--part")
    return PerceptionBench(settings=tuple(settings), parts=tuple(parts))


def _rows(task: Task, folder: Path, settings: Sequence[str]) -> Iterator[dict[str, Any]]:
    kind, *given = task
    parts: Mapping[str, Callable[..., Iterator[dict[str, Any]]]] = {
        "held_out": lambda: held_out.held_out(settings),
        "walking_aids": lambda: walking_aids.walking_aids(settings),
        "demo": lambda: recordings.demo(folder, settings),
        "kitti": lambda: recordings.kitti(folder, settings),
        "crowd": lambda name, drive, first, count: filmed_crowds.crowd(
            name, drive, first, count, settings
        ),
        "prediction": lambda: filmed_crowds.prediction(settings),
        "prediction_cost": lambda: filmed_crowds.cost(settings),
        "groups": lambda: filmed_crowds.groups(settings),
        "empty": lambda floor, sensor: empty_floors.empty(floor, sensor, settings),
        "invalid": lambda: invalid_readings.rows(settings),
        "tracking": lambda: cost.tracking(settings=settings),
        "cloud": lambda: cost.cloud(settings=settings),
        "costs": lambda: cost.costs(folder, settings=settings),
    }
    yield from parts[kind](*given)
