"""Social navigation cards (Francis et al. 2023): all local planners on each card.

A card is an everyday situation that is difficult for robots.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cohelm.benchmarks.bench import LOCAL_PLANNERS, BenchReport, Result, Task, split_names, unset
from cohelm.benchmarks.claims import OURS
from cohelm.benchmarks.ride_claims import (
    few_rides,
)
from cohelm.benchmarks.rides.cases import OWN_SETTINGS, installed
from cohelm.benchmarks.rides.report import Findings, ReportSpec, finish
from cohelm.benchmarks.tables import figures, matrix_table
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.summary import case_name
from cohelm.evaluation.sweeps import RideTask, check_rides, ride_row
from cohelm.evaluation.sweeps.vary import SettingVariant, columns_of, variants_of
from cohelm.scenarios.collection import Collection
from cohelm.scenarios.presets import tuned_settings
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


@dataclass(frozen=True)
class CardsBench:
    """The benchmark with some planners on some cards."""

    planners: tuple[str, ...]
    cards: tuple[str, ...]
    variants: tuple[SettingVariant, ...] = (SettingVariant(),)
    settings: tuple[str, ...] = ()
    """Settings of every ride, before those that are varied."""
    tuned: bool = False
    TITLE: str = TITLE
    SEEDS: int = 5
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per seed, variant and card, with the rides of all planners."""
        return [
            tuple(self.ride(planner, card, variant, seed) for planner in self.planners)
            for seed in seeds
            for variant in self.variants
            for card in self.cards
        ]

    def ride(self, planner: str, card: str, variant: SettingVariant, seed: int) -> RideTask:
        """One ride."""
        return RideTask(
            columns=((CARD, Path(card).stem), *variant.columns, (PLANNER, planner)),
            scenario=card,
            settings=(
                f"local_planner.use={planner}",
                *OWN_SETTINGS.get(planner, ()),
                *(tuned_settings(planner) if self.tuned else ()),
                *self.settings,
                *variant.settings,
            ),
            seed=seed,
        )

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Ride with every planner."""
        return [ride_row(each) for each in task]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Arrivals, contacts, distances and times, card by card."""
        by = (CARD, *columns_of(self.variants), PLANNER)
        rides = Rides([result.row for result in results], by)
        groups = {case_name(case, by): each for case, each in rides.split().items()}
        notes = [*few_rides(groups), *_failures(groups), *_beside(groups)]
        summary = {case: figures(each, MEASURES) for case, each in groups.items()}
        spec = ReportSpec(title=TITLE, by=by, page=MEASURES, limitations=LIMITATIONS)
        sheets = tuple(matrix_table(rides, name) for name in TABLES)
        found = Findings(sheets, tuple(notes), {"cards": summary})
        return finish(results, folder, spec, found, groups)


def known_cards() -> tuple[str, ...]:
    """Cards that come with cohelm."""
    return tuple(
        name for name in scenario_names() if load_scenario(name).collection is Collection.CARDS
    )


def create(
    planners: str | None = None,
    cards: str | None = None,
    settings: Sequence[str] = (),
    vary: Sequence[str] = (),
    *,
    true_people: bool = False,
    tuned: bool = False,
) -> CardsBench:
    """Create the benchmark from its options; names are comma-separated.

    Raises:
        ScenarioError, PluginError, ConfigError: if a card, a planner or a key does not exist.
    """
    variants = variants_of(vary)
    varied = [each for variant in variants for each in variant.settings]
    unset([*settings, *varied], LOCAL_PLANNERS)
    given = ("tracker.use=given",) if true_people else ()
    bench = CardsBench(
        planners=split_names(planners, "--planners") or installed(),
        cards=split_names(cards, "--cards") or known_cards(),
        variants=variants,
        settings=(*given, *settings),
        tuned=tuned,
    )
    check_rides(bench.tasks(range(1)), "local_planner")
    return bench


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
