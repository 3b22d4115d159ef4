"""Report of the benchmark ``calm``: arrivals, collisions, stops and jerk of each part."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.benchmarks.bench import BenchReport, Result, Sheet
from cohelm.benchmarks.rides.false_alarms import alarm_note
from cohelm.benchmarks.rides.report import faults, sources
from cohelm.evaluation.report import write_results
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.statistics import median

BY = ("part", "scene", "mode")
PAGE = (
    "reached", "person_collision", "standing_contact", "wall_collision", "time", "stop_rate",
    "short_stops", "gentle_braking", "hard_braking", "jerk_felt_rms", "jerk_felt_p99",
)  # fmt: skip
LIMITATIONS = (
    "People avoid the chair by ORCA, except in the part 'blind', where they do not see it.",
    "A ride ends at its first collision, so that it can have one at most.",
)


class _Column(NamedTuple):
    """Figure of a group of rides."""

    heading: str
    value: Callable[[Rides], float]
    digits: int = 0


def _rides_with(name: str) -> Callable[[Rides], float]:
    return lambda rides: float((rides.column(name) > 0.0).sum())


def _ended(outcome: str) -> Callable[[Rides], float]:
    return lambda rides: float(sum(row.get("outcome") == outcome for row in rides))


def _median(name: str) -> Callable[[Rides], float]:
    return lambda rides: median(rides.column(name))


def _extreme(name: str, choose: Callable[[Floats], Any]) -> Callable[[Rides], float]:
    """Largest or smallest value of a measure; NaN where no ride has one."""

    def value(rides: Rides) -> float:
        values = rides.column(name)
        there = values[np.isfinite(values)]
        return float(choose(there)) if len(there) else float("nan")

    return value


def gentle_share(rides: Rides) -> float:
    """Share of the braking time of all rides with at most 0.8 m/s², %; NaN without braking."""
    share, time = rides.column("gentle_braking"), rides.column("braking_time")
    there = np.isfinite(share) & (time > 0.0)
    if not there.any():
        return float("nan")
    return 100.0 * float(np.average(share[there], weights=time[there]))


ARRIVALS: Mapping[str, _Column] = {
    "rides": _Column("rides", lambda rides: float(len(rides))),
    "reached": _Column("reached", _rides_with("reached")),
    "timeouts": _Column("time limit", _ended("timeout")),
    "stopped": _Column("stood 20 s", _ended("stopped")),
    "errors": _Column("program error", _ended("error")),
    "person_collisions": _Column("moving into a person", _rides_with("person_collision")),
    "standing_contacts": _Column("person into standing chair", _rides_with("standing_contact")),
    "wall_collisions": _Column("wall", _rides_with("wall_collision")),
    "time_median": _Column("time to goal, s, median", _median("time"), 1),
}
CALMNESS: Mapping[str, _Column] = {
    "stop_rate_median": _Column("stops, 1/min, median", _median("stop_rate"), 1),
    "short_stops": _Column(
        "stops under 0.3 s, total", lambda rides: float(np.nansum(rides.column("short_stops")))
    ),
    "gentle_share": _Column("braking up to 0.8 m/s², %", gentle_share, 1),
    "gentle_share_min": _Column(
        "worst ride, %",
        lambda rides: 100.0 * _extreme("gentle_braking", np.min)(rides),
        1,
    ),
    "hard_braking_median": _Column(
        "time above 0.8 m/s², %, median",
        lambda rides: 100.0 * median(rides.column("hard_braking")),
        1,
    ),
    "jerk_felt_rms_median": _Column("RMS jerk, m/s³, median", _median("jerk_felt_rms"), 2),
    "jerk_felt_rms_max": _Column("maximum", _extreme("jerk_felt_rms", np.max), 2),
    "jerk_felt_p99_median": _Column("p99 jerk, m/s³, median", _median("jerk_felt_p99"), 2),
    "jerk_felt_p99_max": _Column("maximum", _extreme("jerk_felt_p99", np.max), 2),
}


def calm_report(results: Sequence[Result], folder: Path, title: str) -> BenchReport:
    """Tables by part and mode, and by floor; writes the files of all benchmarks of rides."""
    rows = [result.row for result in results]
    rides = Rides(rows, BY)
    groups = {
        f"{part}, {mode}": each for (part, mode), each in _grouped(rides, ("part", "mode")).items()
    }
    floors = {
        f"{scene}, {mode}": each
        for (scene, mode), each in _grouped(rides.only(part="floors"), ("scene", "mode")).items()
    }
    report = BenchReport(
        sheets=(
            _sheet("Rides by outcome", groups, ARRIVALS),
            _sheet("Calmness; jerk at the seat", groups, CALMNESS),
            _sheet("Floors: rides by outcome", floors, ARRIVALS),
            _sheet("Floors: calmness", floors, CALMNESS),
        ),
        notes=(*sources(rows), *faults(rows, BY), *failures(rides), *_alarms(rows)),
        summary={"groups": _figures(groups), "floors": _figures(floors)},
    )
    written = write_results(
        results, folder, by=BY, title=title, measures=PAGE, report=report,
        limitations=LIMITATIONS, panels=False,
    )  # fmt: skip
    return dataclasses.replace(report, files=written)


def failures(rides: Rides) -> tuple[str, ...]:
    """A line for each ride that did not reach its goal, with the command that repeats it."""
    return tuple(
        f"{row['part']}, {row['scene']}, {row['mode']}, seed {row['seed']}: {_end(row)}: "
        f"{row['replay']}"
        for row, reached in zip(rides, rides.reached, strict=True)
        if not reached
    )


def _alarms(rows: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """False alarms per hour, and each with the command of its ride; none of rides that failed."""
    ridden = [row for row in rows if row.get("outcome") != "error" and "alarms" in row]
    found = [
        f"false alarm: {row['alarm_reasons']}: {row['replay']}"
        for row in ridden
        if float(row["alarms"]) > 0.0
    ]
    return (*found, alarm_note(ridden)) if ridden else ()


def _end(row: Mapping[str, Any]) -> str:
    outcome = str(row["outcome"])
    if outcome != "collision":
        return outcome
    if row["collisions_person"] > 0:
        return f"collision with a person at {row['collision_speed']:.2f} m/s"
    return f"collision with a wall at {row['collision_speed_wall']:.2f} m/s"


def _grouped(rides: Rides, keys: tuple[str, str]) -> dict[tuple[str, str], Rides]:
    """Rides by two columns, in the order of the rows."""
    one, other = keys
    found = dict.fromkeys((str(row[one]), str(row[other])) for row in rides)
    return {(a, b): rides.only(**{one: a, other: b}) for a, b in found}


def _sheet(title: str, groups: Mapping[str, Rides], columns: Mapping[str, _Column]) -> Sheet:
    return Sheet(
        title=title,
        columns=("", *(each.heading for each in columns.values())),
        rows=tuple(
            (name, *(_text(each.value(rides), each.digits) for each in columns.values()))
            for name, rides in groups.items()
        ),
    )


def _figures(groups: Mapping[str, Rides]) -> dict[str, dict[str, float | None]]:
    """Figures for programs; None instead of NaN."""
    return {
        group: {
            name: value if np.isfinite(value := each.value(rides)) else None
            for name, each in {**ARRIVALS, **CALMNESS}.items()
        }
        for group, rides in groups.items()
    }


def _text(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if np.isfinite(value) else "–"
