"""What ``cohelm bench paper-static`` and ``riders`` say: by mode, by scene, by rider, in pairs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cohelm.evaluation.benches.bench import Report, Result, Sheet
from cohelm.evaluation.benches.rides_report import faults, signed, sources
from cohelm.evaluation.benches.rides_verdicts import as_percent
from cohelm.evaluation.benches.steering_rows import (
    BY,
    differences,
    in_order,
    touch_speed,
)
from cohelm.evaluation.benches.steering_verdicts import SOFT, limits, paper
from cohelm.evaluation.bootstrap import Estimate, mean_of, median_of, share
from cohelm.evaluation.results import write_results
from cohelm.evaluation.results.rides import Rides, Row


class Shown(NamedTuple):
    """How a measure is shown."""

    head: str
    digits: int
    factor: float = 1.0


SHOWN: Mapping[str, Shown] = {
    "time": Shown("time, s", 1),
    "path_length": Shown("length, m", 2),
    "heading_change": Shown("turning, rad", 1),
    "rider_effort": Shown("effort", 1),
    "agreement": Shown("agreement", 2),
    "fight_rate": Shown("fights, %", 1, 100.0),
}
"""Medians; of time, length and turning over the rides that arrived."""
COMPARED: Mapping[str, Shown] = {
    "reached": Shown("reached, %", 1, 100.0),
    "touched": Shown("collided, %", 1, 100.0),
    **SHOWN,
}
BASE = "shared"
"""What the other modes are compared with."""
COLUMNS = (
    "rides", "reached, %", "collided, %", "m/s", "walked into", *(e.head for e in SHOWN.values()),
)  # fmt: skip
"""``m/s``: the fastest touch of the moving chair; ``walked into``: rides in which people walked
into the standing chair."""
_NOTES = (
    "collided: the moving chair touched a person, or it touched a wall; such a ride ends there",
    "effort (stick movement, in full deflections), agreement and fights (share of time in which "
    "asked and given turn opposite ways) stand in for a rider's opinion, and are none",
    "riders are simulated; intervals of differences take the rides of one scene and seed together, "
    "those of shares and medians take each ride for itself and are narrower than they should be",
)

JUDGES = {"paper": paper, "limits": limits}


def make_report(results: Sequence[Result], folder: Path, asks: str, title: str) -> Report:
    """Tables, sentences, a summary, and what every bench of rides writes.

    Args:
        results: as ``ride_row`` gives them, with columns ``scene``, ``rider`` and ``mode``.
        folder: to write to.
        asks: key of ``JUDGES``.
        title: of the page.
    """
    rows = [result.row for result in results]
    rides = Rides(rows, BY)
    scenes, riders, modes = (in_order(rows, key) for key in ("scene", "rider", "mode"))
    sheets = [
        _sheet("all riders in all scenes", "mode", [(m, rides.only(mode=m)) for m in modes]),
        *(
            _sheet(f"{mode}, all scenes", "rider",
                   [(each, rides.only(mode=mode, rider=each)) for each in riders])
            for mode in modes
        ),
        *(
            _sheet(f"{scene}, all riders", "mode",
                   [(each, rides.only(scene=scene, mode=each)) for each in modes])
            for scene in scenes
        ),
        *(_less(where, rides.only(**what), modes) for where, what in _cases(scenes)),
    ]  # fmt: skip
    says = list(JUDGES[asks](rides))
    report = Report(
        sheets=tuple(sheets),
        notes=(*_NOTES, *sources(rows), *faults_by(rows), *says),
        summary={
            "verdicts": says,
            "modes": {mode: _figures(rides.only(mode=mode)) for mode in modes},
            "riders": {
                rider: {mode: _figures(rides.only(rider=rider, mode=mode)) for mode in modes}
                for rider in riders
            },
            "seeds": sorted({int(row["seed"]) for row in rows}),
        },
    )
    return replace(
        report,
        files=write_results(
            results,
            folder,
            by=BY,
            title=title,
            base=BASE,
            measures=("reached", "hit_moving", "hit_wall", *SHOWN),
            report=report,
            limitations=_NOTES,
        ),
    )


def faults_by(rows: Sequence[Row]) -> list[str]:
    """Rides that broke off, each fault once, by rider and mode."""
    return faults([{**row, "planner": f"{row['rider']}, {row['mode']}"} for row in rows])


def _cases(scenes: Iterable[str]) -> list[tuple[str, dict[str, str]]]:
    return [("all scenes", {}), *((scene, {"scene": scene}) for scene in scenes)]


def _sheet(title: str, head: str, groups: Iterable[tuple[str, Rides]]) -> Sheet:
    """A line for each group that has rides."""
    return Sheet(
        title=f"{title}: share or median [95 % interval]",
        columns=(head, *COLUMNS),
        rows=tuple((name, *_cells(each)) for name, each in groups if len(each)),
    )


def _cells(rides: Rides) -> tuple[str, ...]:
    speed = touch_speed(rides)
    return (
        str(len(rides)),
        as_percent(share(rides.reached)),
        as_percent(share(rides.touched)),
        f"{np.nanmax(speed):.2f}" if np.isfinite(speed).any() else "",
        str(int((rides.column("standing_contacts") > 0).sum())),
        *(
            f"{_scaled(median_of(rides.column(key)), how.factor):.{how.digits}f}"
            for key, how in SHOWN.items()
        ),
    )


def _less(where: str, rides: Rides, modes: Iterable[str]) -> Sheet:
    """Every other mode less ``shared``, on the same scenes, seeds and riders."""
    base = rides.only(mode=BASE)
    rows = []
    for mode in modes if len(base) else ():
        other = rides.only(mode=mode)
        if mode != BASE and len(other):
            less = {key: mean_of(differences(other, base, key)) for key in COMPARED}
            cells = (signed(less[k], how.factor, how.digits) for k, how in COMPARED.items())
            rows.append((mode, *cells))
    return Sheet(
        title=f"{where}: less {BASE}, on the same seeds (mean [95 % interval])",
        columns=("mode", *(each.head for each in COMPARED.values())),
        rows=tuple(rows),
    )


def _figures(rides: Rides) -> dict[str, Any]:
    medians = {key: median_of(rides.column(key)) for key in SHOWN}
    return {
        "rides": len(rides),
        "reached": int(rides.reached.sum()),
        "touched": int(rides.touched.sum()),
        "touched_fast": int((touch_speed(rides) > SOFT).sum()),
        "medians": {k: {"value": e.mean, "low": e.low, "high": e.high} for k, e in medians.items()},
    }


def _scaled(each: Estimate, factor: float) -> Estimate:
    return Estimate(
        mean=factor * each.mean, low=factor * each.low, high=factor * each.high, count=each.count
    )
