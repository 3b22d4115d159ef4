"""What ``cohelm bench crowds`` says: a table for each film, differences, and what was asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from cohelm.arrays import Booleans, Floats
from cohelm.evaluation.benches.bench import Report, Result, Sheet
from cohelm.evaluation.benches.rides_report import differences, faults, groups_of, sources
from cohelm.evaluation.benches.rides_verdicts import ENOUGH, OURS, as_percent, broken, few
from cohelm.evaluation.bootstrap import median_of, middle_of, share
from cohelm.evaluation.crossings import NEAR
from cohelm.evaluation.results import write_results
from cohelm.evaluation.results.measures import SHOWN
from cohelm.evaluation.results.rides import Rides

REACHED, MOVING = 0.95, 0.01
"""Least share of crossings that arrive, and greatest of those with a moving collision."""
COLUMNS = (
    "planner", "rides", "reached, %", "hit moving, %", "walked into standing, %", "time, s",
    "delay, s", "intrusion, s", "intruding, %", "in groups, s", "gap, m", "stood, s",
)  # fmt: skip
"""``delay``: over the same way with nobody there; ``intrusion``: of people's Gaussians; ``in
groups``: of the spaces of those who walk together."""
MEASURES = (*SHOWN, "social_space_intrusion", "group_space_intrusion", "stalled_time")
"""In the page's tables."""
_LIMITS = (
    "the people are replayed: they walk as they were filmed and do not react to the chair, so that "
    "all the avoiding is its own, and none of them is delayed; real people would give way",
    "people who walk into the chair while it stands are counted apart: it can do no more",
    "positions are known every 0.4 s; in between people are on a smooth curve",
    f"who would come into the picture within {NEAR:g} m of the chair comes once it is no nearer",
)


def make_report(results: Sequence[Result], folder: Path, title: str) -> Report:
    """Tables, sentences, a summary and the page."""
    rows = [result.row for result in results]
    groups = groups_of(rows)
    says = [line for scene in groups for line in verdicts(scene, groups[scene])]
    sheets = []
    for scene, by_planner in groups.items():
        sheets += [film_sheet(scene, by_planner), differences(scene, by_planner, OURS)]
    report = Report(
        sheets=tuple(sheets),
        notes=(*_LIMITS, *sources(rows), *faults(rows), *says),
        summary={
            "verdicts": says,
            "scenes": {
                scene: {name: _figures(group) for name, group in by_planner.items()}
                for scene, by_planner in groups.items()
            },
            "seeds": sorted({int(row["seed"]) for row in rows}),
        },
    )
    written = write_results(
        results,
        folder,
        title=title,
        base=OURS,
        measures=MEASURES,
        report=report,
        limitations=_LIMITS,
    )
    return replace(report, files=written)


def verdicts(scene: str, by_planner: Mapping[str, Rides]) -> Iterator[str]:
    """Sentences on ours in one film, each ending in met or MISSED."""
    ours = by_planner.get(OURS)
    if ours is None:
        return
    if len(ours) < ENOUGH:
        yield f"{scene}: {few(len(ours))}: what follows is no finding"
    reached, hits = float(ours.reached.mean()), 100.0 * float(ours.hit_moving.mean())
    at_most = float((ours.hit_moving | ours.broke_off).mean())
    for what, met in (
        (f"{100.0 * reached:.1f} % reached, 95 % asked", reached >= REACHED),
        (f"moving collisions in {hits:.1f} %{broken(ours)}, at most 1 % asked", at_most <= MOVING),
    ):
        yield f"{scene}: {what}: {'met' if met else 'MISSED'}"


def film_sheet(scene: str, by_planner: Mapping[str, Rides]) -> Sheet:
    """A line for each planner: shares with score intervals, medians with bootstrap intervals."""
    return Sheet(
        title=f"{scene}: share or median [95 % interval]",
        columns=COLUMNS,
        rows=tuple((name, *_cells(group)) for name, group in by_planner.items()),
    )


def delay(group: Rides) -> Floats:
    """Time over that of the same way with nobody there, (k,), s; NaN where it was not reached."""
    return group.column("time") - group.column("time_alone")


def walked_into(group: Rides) -> Booleans:
    """Rides in which somebody walked into the standing chair, (k,)."""
    return group.column("standing_contacts") > 0


def _cells(group: Rides) -> tuple[str, ...]:
    def median(values: Floats, digits: int) -> str:
        return f"{median_of(values):.{digits}f}"

    return (
        str(len(group)),
        as_percent(share(group.reached)),
        as_percent(share(group.hit_moving)),
        as_percent(share(walked_into(group))),
        median(group.column("time"), 1),
        median(delay(group), 1),
        median(group.column("social_space_intrusion"), 2),
        median(100.0 * group.column("social_space_intrusion_share"), 0),
        median(group.column("group_space_intrusion"), 2),
        median(group.column("min_distance"), 2),
        median(group.column("stalled_time"), 1),
    )


def _figures(group: Rides) -> dict[str, float | int]:
    """The table's figures for programs."""
    return {
        "rides": len(group),
        "reached": float(group.reached.mean()),
        "hit_moving": float(group.hit_moving.mean()),
        "walked_into": float(walked_into(group).mean()),
        "time": middle_of(group.column("time")),
        "delay": middle_of(delay(group)),
        "social_space_intrusion": middle_of(group.column("social_space_intrusion")),
        "group_space_intrusion": middle_of(group.column("group_space_intrusion")),
        "min_distance": middle_of(group.column("min_distance")),
        "stalled_time": middle_of(group.column("stalled_time")),
    }
