"""What ``cohelm bench cards`` says: card by card, who arrives, who is touched, how they pass."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.evaluation.benches.bench import Report, Result, Sheet
from cohelm.evaluation.benches.rides_verdicts import ENOUGH, OURS, few
from cohelm.evaluation.bootstrap import middle_of
from cohelm.evaluation.results import write_results
from cohelm.evaluation.results.summary import case_name
from cohelm.evaluation.sweeps.ride_task import ERROR

Row = Mapping[str, Any]
Rows = Sequence[Row]

MEASURES = (
    "reached", "hit_moving", "hit_wall", "hit_standing", "time", "time_ratio",
    "min_distance", "social_space_intrusion", "social_space_intrusion_share", "proxemics_intimate",
    "group_space_intrusion", "pedestrian_delay", "pedestrian_deviation",
    "time_to_collision", "stalled_time", "beside_share",
)  # fmt: skip
"""In the page's tables."""
LIMITATIONS = (
    "The cards are drawn for this simulator: the situation of each after Francis et al. 2023, all "
    "figures of floors and people ours.",
    "In accompanying no goal moves: chair and companion go to two places side by side, each at "
    "their own pace; what is measured is the share of time side by side.",
)


def make_report(results: Sequence[Result], folder: Path, by: Sequence[str], title: str) -> Report:
    """Tables, sentences and the files that every bench of rides writes.

    Args:
        results: a ride each.
        folder: to write to.
        by: columns that tell rides apart, the planner's last.
        title: of the page.
    """
    rows = [result.row for result in results]
    report = Report(
        sheets=tuple(_sheet(rows, by, head, cell) for head, cell in _CELLS.items()),
        notes=tuple(_notes(rows, by)),
        summary={"cards": _summary(rows, by)},
    )
    files = write_results(
        results, folder, by=by, title=title, base=OURS, measures=MEASURES, report=report,
        limitations=LIMITATIONS,
    )  # fmt: skip
    return replace(report, files=files)


def _groups(rows: Rows, by: Sequence[str]) -> dict[tuple[str, ...], dict[str, list[Row]]]:
    """Card and what is varied → planner → rides, in the order of the rows."""
    found: dict[tuple[str, ...], dict[str, list[Row]]] = {}
    for row in rows:
        case = tuple(str(row[key]) for key in by[:-1])
        found.setdefault(case, {}).setdefault(str(row[by[-1]]), []).append(row)
    return found


def _sheet(rows: Rows, by: Sequence[str], head: str, cell: Callable[[Rows], str]) -> Sheet:
    """A line for each card, a column for each planner."""
    groups = _groups(rows, by)
    planners = tuple(dict.fromkeys(str(row[by[-1]]) for row in rows))
    return Sheet(
        title=head,
        columns=(*by[:-1], *planners),
        rows=tuple(
            (*case, *(cell(each[name]) if name in each else "" for name in planners))
            for case, each in groups.items()
        ),
    )


def _reached(rides: Rows) -> str:
    return f"{sum(ride['outcome'] == 'reached' for ride in rides)}/{len(rides)}"


def _touched(rides: Rows) -> str:
    moving = sum(ride["collisions_person"] > 0 for ride in rides)
    wall = sum(ride["collisions_wall"] > 0 for ride in rides)
    standing = sum(ride["standing_contacts"] > 0 for ride in rides)
    return f"{moving}/{wall}/{standing}"


def _median(key: str, digits: int) -> Callable[[Rows], str]:
    def cell(rides: Rows) -> str:
        found = _middle(rides, key)
        return f"{found:.{digits}f}" if math.isfinite(found) else "–"

    return cell


def _middle(rides: Rows, key: str) -> float:
    return middle_of(np.array([ride.get(key, math.nan) for ride in rides], dtype=float))


_CELLS: Mapping[str, Callable[[Rows], str]] = {
    "Rides that reached the goal": _reached,
    "Rides with contacts: moving chair and person / wall / person and standing chair": _touched,
    "Least gap to a person, median, m": _median("min_distance", 2),
    "Intrusion into personal space, median, s": _median("social_space_intrusion", 2),
    "Time, median of those that reached, s": _median("time", 1),
}


def _notes(rows: Rows, by: Sequence[str]) -> list[str]:
    groups = _groups(rows, by)
    fewest = min((len(each) for case in groups.values() for each in case.values()), default=0)
    out = [] if fewest >= ENOUGH else [f"{few(fewest)}: what follows is no finding"]
    for case, each in groups.items():
        ours = each.get(OURS, [])
        failed = [ride for ride in ours if ride["outcome"] != "reached"]
        if failed:
            seeds = ", ".join(str(ride["seed"]) for ride in failed)
            where, count = case_name(case, by), f"{len(failed)} of {len(ours)}"
            out.append(f"{where}, {OURS}: {count} not reached (seeds {seeds})")
    for case, each in groups.items():
        beside = {planner: _middle(rides, "beside_share") for planner, rides in each.items()}
        shares = [f"{name} {100 * x:.0f} %" for name, x in beside.items() if math.isfinite(x)]
        if shares:
            out.append(f"{case_name(case, by)}, time side by side: {', '.join(shares)}")
    broken = {row["error"] for row in rows if row["outcome"] == ERROR}
    return [*out, *(f"rides broke off: {error}" for error in sorted(broken))]


def _summary(rows: Rows, by: Sequence[str]) -> dict[str, Any]:
    return {
        case_name(case, by): {
            planner: {
                "rides": len(rides),
                "reached": sum(ride["outcome"] == "reached" for ride in rides),
                "hit_moving": sum(ride["collisions_person"] > 0 for ride in rides),
                "hit_wall": sum(ride["collisions_wall"] > 0 for ride in rides),
                **{key: _middle(rides, key) for key in ("time", "min_distance", *_PASSING)},
            }
            for planner, rides in each.items()
        }
        for case, each in _groups(rows, by).items()
    }


_PASSING = (
    "social_space_intrusion", "social_space_intrusion_share", "group_space_intrusion",
    "pedestrian_delay", "pedestrian_deviation", "beside_share",
)  # fmt: skip
