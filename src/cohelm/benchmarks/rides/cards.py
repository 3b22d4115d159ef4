"""Social navigation cards (Francis et al. 2023): all local planners on each card.

A card is an everyday situation that is difficult for robots.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np

from cohelm.benchmarks.bench import (
    LOCAL_PLANNERS,
    BenchReport,
    Result,
    chosen_names,
    split_names,
    unset,
)
from cohelm.benchmarks.claims import OURS
from cohelm.benchmarks.options import Planners, Settings, TruePeople, Tuned, names, repeatable
from cohelm.benchmarks.ride_claims import few_rides
from cohelm.benchmarks.rides.cases import TRUE_PEOPLE, installed, planners_of
from cohelm.benchmarks.rides.report import Findings, ReportSpec, finish
from cohelm.benchmarks.study import Grid, Study, Variant, common, varied
from cohelm.benchmarks.tables import figures, matrix_table
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.summary import case_name
from cohelm.scenarios.collection import Collection
from cohelm.scenarios.scenario import load_scenario, scenario_names

TITLE = "Social navigation cards, all local planners (Francis et al. 2023)"
CARD, PLANNER = "card", "planner"
TABLES = (
    "reached", "person_collision", "wall_collision", "standing_contact", "min_distance",
    "social_space_intrusion", "time",
)  # fmt: skip
"""One table each: a line per card, a column per planner."""
MEASURES = (
    "reached", "person_collision", "wall_collision", "standing_contact", "time", "time_ratio",
    "min_distance", "social_space_intrusion", "social_space_intrusion_share", "proxemics_intimate",
    "group_space_intrusion", "pedestrian_delay", "pedestrian_deviation",
    "time_to_collision", "stalled_time", "side_by_side_share",
)  # fmt: skip
LIMITATIONS = (
    "The cards are made for this simulator: each situation is that of Francis et al. 2023, but "
    "the figures of floors and people are ours.",
    "In accompanying no goal moves: chair and companion go to two places side by side, each at "
    "their own speed; the share of time side by side is measured.",
)


def known_cards() -> tuple[str, ...]:
    """Cards that come with cohelm."""
    return tuple(
        name for name in scenario_names() if load_scenario(name).collection is Collection.CARDS
    )


def create(
    planners: Planners = None,
    cards: Annotated[str | None, names("Cards by name or file; default: all.")] = None,
    settings: Settings = (),
    vary: Annotated[
        tuple[str, ...],
        repeatable("--vary", "KEY=A,B,C", "Ride with each value; the key becomes a column"),
    ] = (),
    *,
    true_people: TruePeople = False,
    tuned: Tuned = False,
) -> Study:
    """Create the study from its options; names are comma-separated.

    Raises:
        ScenarioError, PluginError, ConfigError: if a card, a planner or a key does not exist.
    """
    variants = varied(vary)
    unset([*settings, *(each for v in variants for each in v.settings)], LOCAL_PLANNERS)
    if true_people:
        unset((each for v in variants for each in v.settings), {"tracker": "--true-people"})
    known = (TRUE_PEOPLE,) if true_people else ()
    ridden = tuple(
        Variant(((CARD, Path(card).stem),), known, scenario=card)
        for card in split_names(cards, "--cards") or known_cards()
    )
    compared = planners_of(chosen_names(planners, "--planners", installed()), tuned=tuned)
    by = (CARD, *(key for key, _ in variants[0].columns), PLANNER)
    return Study(
        TITLE,
        Grid((ridden, compared, common(settings), variants), compared=3),
        partial(cards_report, by=by),
        SEEDS=5,
    ).checked()


def cards_report(results: Sequence[Result], folder: Path, by: tuple[str, ...]) -> BenchReport:
    """Arrivals, contacts, distances and times, card by card."""
    rides = Rides([result.row for result in results], by)
    groups = {case_name(case, by): each for case, each in rides.split().items()}
    notes = [*few_rides(groups), *_failures(groups), *_beside(groups)]
    summary = {case: figures(each, MEASURES) for case, each in groups.items()}
    spec = ReportSpec(title=TITLE, by=by, page=MEASURES, limitations=LIMITATIONS)
    sheets = tuple(matrix_table(rides, name) for name in TABLES)
    found = Findings(sheets, tuple(notes), {"cards": summary})
    return finish(results, folder, spec, found, groups)


def _failures(groups: dict[str, dict[str, Rides]]) -> list[str]:
    """Rides of ours that did not reach the goal, with their seeds."""
    out = []
    for case, by_planner in groups.items():
        ours = by_planner.get(OURS)
        failed = [] if ours is None else [row for row in ours if row["outcome"] != "reached"]
        if ours is not None and failed:
            seeds = ", ".join(str(row["seed"]) for row in failed)
            out.append(f"{case}, {OURS}: {len(failed)} of {len(ours)} not reached (seeds {seeds})")
    return out


def _beside(groups: dict[str, dict[str, Rides]]) -> list[str]:
    """Median share of time beside the companion, where there is one."""
    out = []
    for case, by_planner in groups.items():
        shares = {name: rides.column("side_by_side_share") for name, rides in by_planner.items()}
        texts = [f"{n} {100 * np.nanmedian(x):.0f} %" for n, x in shares.items()
                 if np.isfinite(x).any()]  # fmt: skip
        if texts:
            out.append(f"{case}, time side by side: {', '.join(texts)}")
    return out
