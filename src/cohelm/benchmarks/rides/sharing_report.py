"""Report of the study of sharing: outcomes by family and mode, differences, gains and losses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cohelm.benchmarks.bench import BenchReport, Result, Sheet
from cohelm.benchmarks.claims import AGREES, CONTRADICTS, UNCLEAR, Verdict
from cohelm.benchmarks.ride_figures import SOFT
from cohelm.benchmarks.rides.report import Findings, ReportSpec, finish, rides_by
from cohelm.benchmarks.rides.sharing_families import FAMILIES, FAST, SPLIT
from cohelm.benchmarks.tables import (
    column,
    difference_table,
    figures,
    group_table,
    paired_differences,
    signed_text,
)
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.statistics import Estimate, bootstrap_mean

BY = ("family", "scene", "rider", "mode")
SHARED = "shared"
OUTCOME = "as_wanted"
_PROXIES = ("time", "rider_effort", "disagreement", "intervention_share")
MEASURES = (OUTCOME, "any_collision", "touch_speed", "standing_contact", *_PROXIES)
COMPARED = (OUTCOME, "any_collision", *_PROXIES)
LIMITATIONS = (
    "collision: the moving chair touches a person, or it touches a wall; the ride ends there",
    "alone, the chair carries a rider without a device: it has no effort and no disagreement",
    "riders are simulated; effort, disagreement and interventions are proxies for an opinion",
    "intervals of differences take the rides of one scene and seed together; those of shares and "
    "medians treat rides as independent and are too narrow",
)


class Hypothesis(NamedTuple):
    """Statement about two modes in one family, made before the rides."""

    family: str
    """Or ``EVERY``."""
    worse: str
    """Mode than which ``shared`` is expected to be better."""


EVERY = "all families"
HYPOTHESES = (
    *(Hypothesis(family, "autonomous") for family in SPLIT),
    Hypothesis("hands", "manual"),
)
ALONE = ("manual", "autonomous")
"""Modes in which only one of the two drives."""
CROSSED_HYPOTHESES = tuple(
    Hypothesis(family, alone) for family in (EVERY, *SPLIT) for alone in ALONE
)


def sharing_report(
    results: Sequence[Result],
    folder: Path,
    title: str,
    hypotheses: Sequence[Hypothesis] = HYPOTHESES,
) -> BenchReport:
    """Report of rides with the columns of ``BY``."""
    rides = Rides([result.row for result in results], BY)
    modes = rides_by(rides, "mode")
    families = {name: rides_by(each, "mode") for name, each in rides_by(rides, "family").items()}
    scenes = {name: rides_by(each, "mode") for name, each in rides_by(rides, "scene").items()}
    sheets = [
        *(group_table(_heading(name), each, MEASURES, "mode") for name, each in families.items()),
        *(
            difference_table(_heading(name), each, SHARED, COMPARED, "mode")
            for name, each in families.items()
        ),
        both_sheet(rides),
        collision_sheet(families),
        count_sheet(rides),
        gain_sheet(scenes),
    ]
    found = Findings(
        sheets=tuple(sheet for sheet in sheets if sheet.rows),
        notes=gain_notes(scenes),
        summary={
            "families": {name: figures(each, MEASURES) for name, each in families.items()},
            "scenes": {name: figures(each, MEASURES) for name, each in scenes.items()},
            "modes": figures(modes, MEASURES),
        },
        verdicts=tuple(
            _judged(each, {**families, EVERY: modes})
            for each in hypotheses
            if _is_ridden(each, {**families, EVERY: modes})
        ),
    )
    spec = ReportSpec(
        title=title,
        by=BY,
        base=SHARED,
        page=(OUTCOME, "reached", "person_collision", "wall_collision", *_PROXIES),
        limitations=LIMITATIONS,
    )
    return finish(results, folder, spec, found, families)


def both_sheet(rides: Rides) -> Sheet:
    """Gain of ``shared`` over either side alone, by family, by hand, and by both.

    The last column is ``yes`` where both intervals lie above 0, ``no`` where one lies below.
    """
    families, hands = rides_by(rides, "family"), rides_by(rides, "rider")
    groups = {(EVERY, "all hands"): rides}
    groups |= {(name, "all hands"): each for name, each in families.items()}
    groups |= {(EVERY, hand): each for hand, each in hands.items()}
    groups |= {
        (name, hand): each.only(rider=hand) for name, each in families.items() for hand in hands
    }
    rows = []
    for names, each in groups.items():
        by = rides_by(each, "mode")
        if not {SHARED, *ALONE} <= by.keys():
            continue
        gains = [gain(by[SHARED], by[mode]) for mode in ALONE]
        better = "yes" if all(g.low > 0.0 for g in gains) else "open"
        rows.append(
            (
                *names,
                *(_count(by[mode]) for mode in (SHARED, *ALONE)),
                *(signed_text(g, OUTCOME) for g in gains),
                "no" if any(g.high < 0.0 for g in gains) else better,
            )
        )
    return Sheet(
        title="shared better than either side alone: arrived as wanted, points [95 % interval]",
        columns=("family", "rider", SHARED, *ALONE, *(f"shared - {m}" for m in ALONE), "both"),
        rows=tuple(rows),
    )


def collision_sheet(families: Mapping[str, Mapping[str, Rides]]) -> Sheet:
    """Number of collisions by the chair's speed, and of contacts while standing."""
    rows = []
    for family, by_mode in families.items():
        for mode, rides in by_mode.items():
            speed, hit = column(rides, "touch_speed"), rides.any_collision
            counts = (
                len(rides),
                int((hit & ~(speed > SOFT)).sum()),
                int((hit & (speed > SOFT) & (speed <= FAST)).sum()),
                int((hit & (speed > FAST)).sum()),
                int((rides.column("standing_contact") > 0.0).sum()),
                int((rides.column("avoided_floor") > 0.0).sum()),
                int((rides.column("places_missed") > 0.0).sum()),
            )
            rows.append((family, mode, *map(str, counts)))
    return Sheet(
        title="collisions by speed, and other failures, number of rides",
        columns=(
            *("family", "mode", "rides", f"collision up to {SOFT:g} m/s"),
            *(f"{SOFT:g} to {FAST:g} m/s", f"above {FAST:g} m/s", "contact while standing"),
            *("on floor to avoid", "past no wanted place"),
        ),
        rows=tuple(rows),
    )


def count_sheet(rides: Rides) -> Sheet:
    """Arrivals as wanted of every scene and rider, a column per mode."""
    modes = rides.contenders
    return Sheet(
        title="arrived as the rider wanted, by scene and rider",
        columns=(*BY[:-1], *modes),
        rows=tuple(
            (*case, *(_count(by_mode[mode]) if mode in by_mode else "–" for mode in modes))
            for case, by_mode in rides.split().items()
        ),
    )


def gain_sheet(scenes: Mapping[str, Mapping[str, Rides]]) -> Sheet:
    """Difference of ``shared`` from every other mode, scene by scene, in percentage points."""
    others = [mode for by in scenes.values() for mode in by if mode != SHARED]
    modes = tuple(dict.fromkeys(others))
    return Sheet(
        title="shared less each other mode: arrived as wanted, points [95 % interval]",
        columns=("scene", *modes),
        rows=tuple(
            (
                scene,
                *(
                    signed_text(gain(by[SHARED], by[mode]), OUTCOME) if mode in by else "–"
                    for mode in modes
                ),
            )
            for scene, by in scenes.items()
            if SHARED in by and modes
        ),
    )


def gain_notes(scenes: Mapping[str, Mapping[str, Rides]]) -> tuple[str, ...]:
    """Sentences on the scenes in which ``shared`` loses to another mode, for certain or not."""
    out = []
    for scene, by in scenes.items():
        for mode, rides in by.items():
            if mode == SHARED or SHARED not in by:
                continue
            found = gain(by[SHARED], rides)
            if found.count and found.mean < 0.0:
                sure = "" if found.high < 0.0 else ", may be chance"
                out.append(
                    f"shared loses to {mode} in {scene}: {_count(by[SHARED])}, {mode} "
                    f"{_count(rides)}, {signed_text(found, OUTCOME)} points{sure}"
                )
    return tuple(out) or ("shared loses to no other mode in any scene",)


def gain(one: Rides, other: Rides) -> Estimate:
    """Mean difference of arrivals as wanted on equal scenes, riders and seeds."""
    return bootstrap_mean(paired_differences(one, other, OUTCOME))


def _judged(claim: Hypothesis, families: Mapping[str, Mapping[str, Rides]]) -> Verdict:
    by_mode = families[claim.family]
    where = claim.family if claim.family == EVERY else f"family {claim.family}"
    shared, other = by_mode[SHARED], by_mode[claim.worse]
    found = gain(shared, other)
    result = AGREES if found.low > 0.0 else CONTRADICTS if found.high < 0.0 else UNCLEAR
    return Verdict(
        where,
        f"{SHARED} arrives as wanted more often than {claim.worse}",
        f"{_count(shared)}, {claim.worse} {_count(other)}, {signed_text(found, OUTCOME)} points",
        result=result,
    )


def _is_ridden(claim: Hypothesis, families: Mapping[str, Mapping[str, Rides]]) -> bool:
    return {SHARED, claim.worse} <= families.get(claim.family, {}).keys()


def _heading(family: str) -> str:
    return f"{family} ({FAMILIES[family].title})" if family in FAMILIES else family


def _count(rides: Rides) -> str:
    return f"{int(np.nansum(rides.column(OUTCOME)))} of {len(rides)}"
