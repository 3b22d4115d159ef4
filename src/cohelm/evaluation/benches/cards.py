"""Social navigation cards (Francis et al. 2023), every local planner in each.

A card is a situation that people know and robots get wrong. Where somebody names a map of their
own, the cards are laid on it, where it is most like the floor they were drawn for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from cohelm.errors import ConfigError
from cohelm.evaluation.benches.bench import (
    LOCAL_PLANNERS,
    Report,
    Result,
    Task,
    check_free,
    parted,
)
from cohelm.evaluation.benches.cards_report import make_report
from cohelm.evaluation.benches.rides import installed
from cohelm.evaluation.benches.rides_scenes import OWN_SETTINGS
from cohelm.evaluation.collection import Collection
from cohelm.evaluation.presets import tuned_settings
from cohelm.evaluation.scenario import load_scenario, scenario_names
from cohelm.evaluation.sweeps import RideTask, check_rides, ride_row
from cohelm.evaluation.sweeps.vary import Variant, columns_of, variants_of
from cohelm.maps import read_map

TITLE = "Social navigation cards, every local planner (Francis et al. 2023)"
SEEDS = 5
WORKERS = None

CARD, PLANNER = "card", "planner"


@dataclass(frozen=True)
class CardsBench:
    """The benchmark with some planners on some cards."""

    planners: tuple[str, ...]
    cards: tuple[str, ...]
    variants: tuple[Variant, ...] = (Variant(),)
    settings: tuple[str, ...] = ()
    """Of every ride, before what is varied."""
    tuned: bool = False
    TITLE: str = TITLE
    SEEDS: int = SEEDS
    WORKERS: int | None = WORKERS

    def tasks(self, seeds: range) -> Sequence[Task]:
        """The rides of one seed on one card in one variant each: whole comparisons."""
        return [
            tuple(self.ride(planner, card, variant, seed) for planner in self.planners)
            for seed in seeds
            for variant in self.variants
            for card in self.cards
        ]

    def ride(self, planner: str, card: str, variant: Variant, seed: int) -> RideTask:
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
        """The rides of a task."""
        return [ride_row(each) for each in task]

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """A table of who arrives, one of contacts, one of intrusion, card by card."""
        return make_report(results, folder, (CARD, *columns_of(self.variants), PLANNER), TITLE)


def known_cards() -> tuple[str, ...]:
    """The cards that come with cohelm."""
    return tuple(
        name for name in scenario_names() if load_scenario(name).collection is Collection.CARDS
    )


def on(
    planners: str | None = None,
    cards: str | None = None,
    settings: Sequence[str] = (),
    vary: Sequence[str] = (),
    map_file: Path | None = None,
    *,
    true_people: bool = False,
    tuned: bool = False,
) -> CardsBench:
    """The benchmark as options ask for it; names are parted by commas.

    Raises:
        ScenarioError, PluginError, ConfigError, MapError: if a card, a planner, a key or the map
            does not exist or cannot be read, before anything is ridden.
    """
    variants = variants_of(vary)
    varied = [each for variant in variants for each in variant.settings]
    check_free([*settings, *varied], LOCAL_PLANNERS)
    if map_file is not None:
        if not map_file.is_file():
            raise ConfigError(f"{map_file}: no such file", key="--map")
        read_map(map_file)  # what no ride could lay a card on
    laid = () if map_file is None else (f"onto.map={map_file.absolute()}",)
    told = ("tracker.use=given",) if true_people else ()
    bench = CardsBench(
        planners=parted(planners, "--planners") or installed(),
        cards=parted(cards, "--cards") or known_cards(),
        variants=variants,
        settings=(*laid, *told, *settings),
        tuned=tuned,
    )
    check_rides(bench.tasks(range(1)), "local_planner")
    return bench
