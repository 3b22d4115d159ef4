"""A study of sharing: all driving modes where rider and chair know different things."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cohelm.benchmarks.bench import BenchReport, Result, Task, known_name, split_names, unset
from cohelm.benchmarks.rides.modes import MODES
from cohelm.benchmarks.rides.sharing_families import FAMILIES, SplitScene
from cohelm.benchmarks.rides.sharing_report import sharing_report
from cohelm.evaluation.episode.ride import Ride
from cohelm.evaluation.metrics.wanted import as_wanted, entered_avoided_floor, places_missed
from cohelm.evaluation.sweeps import RideTask, check_rides, ride_row
from cohelm.messages import Mode

TITLE = "Driving modes where rider and chair know different things"
COMPARED = {
    "rider": "the families",
    "mode": "--modes",
    "start": "the seed",
    "rider_plan": "a scene",
}
"""Keys that cannot be set for all rides → what sets them."""


@dataclass(frozen=True)
class SharingBench:
    """The study with some families and modes."""

    families: tuple[str, ...]
    modes: tuple[str, ...]
    settings: tuple[str, ...] = ()
    rotate: bool = False
    """One rider per scene and seed, in turn: a quarter of the rides in most families."""
    TITLE: str = TITLE
    SEEDS: int = 20
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per seed and scene, with the rides of all its riders in all modes."""
        return [
            tuple(self._rides(family, scene, seed))
            for seed in seeds
            for family in self.families
            for scene in FAMILIES[family].scenes
        ]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Ride; rides that differ in their columns alone are ridden once."""
        done: dict[Any, Result] = {}
        out = []
        for ride in task:
            key = (ride.scenario, ride.settings, ride.seed)
            if key not in done:
                done[key] = ride_row(ride, empty_floor=False, more=wanted_columns)
            found = done[key]
            # A ride that a program error ended did not arrive.
            row = {"as_wanted": 0.0, **found.row, **dict(ride.columns)}
            out.append(Result(row, found.arrays))
        return out

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Tables by family, mode and scene, paired differences, verdicts."""
        return sharing_report(results, folder, self.TITLE)

    def _rides(self, family: str, scene: SplitScene, seed: int) -> Iterator[RideTask]:
        """Rides of one world: nothing but rider and mode differs."""
        world = scene.settings_for(seed)
        for rider in scene.riders_of(seed) if self.rotate else scene.riders:
            for mode in self.modes:
                # Alone, the chair carries a rider without a device.
                hand = "none" if mode == Mode.AUTONOMOUS.value else rider
                yield RideTask(
                    columns=(
                        ("family", family),
                        ("scene", scene.scenario),
                        ("rider", rider),
                        ("mode", mode),
                    ),
                    scenario=scene.scenario,
                    settings=(f"mode={mode}", f"rider.use={hand}", *world, *self.settings),
                    seed=seed,
                )


def wanted_columns(ride: Ride) -> Mapping[str, Any]:
    """Columns of the outcome that the rider wants; yes or no as 1 or 0."""
    return {
        "as_wanted": float(as_wanted(ride)),
        "places_missed": places_missed(ride),
        "avoided_floor": float(entered_avoided_floor(ride)),
    }


def create(
    families: str | None = None,
    modes: str | None = None,
    settings: Sequence[str] = (),
    rotate: bool = False,
) -> SharingBench:
    """Create the study from its options; names are comma-separated.

    Raises:
        ConfigError, PluginError, ScenarioError: if a family, a mode or a setting does not exist.
    """
    unset(settings, COMPARED)
    chosen = split_names(families, "--families") or tuple(FAMILIES)
    for name in chosen:
        known_name(name, tuple(FAMILIES), "family", "--families")
    driven = split_names(modes, "--modes") or MODES
    for mode in driven:
        known_name(mode, MODES, "mode", "--modes")
    bench = SharingBench(chosen, driven, tuple(settings), rotate)
    check_rides(bench.tasks(range(1)), "rider")
    return bench
