"""Narrow doorways among people, with hands of all kinds: how many get through, and whom they touch.

A door of 0.76 or 0.84 m for a chair of 0.61 m; a person comes through it the other way, or people
stand beside it. A seed moves and turns the start, and draws people, sensor noise and the hand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cohelm import plugins
from cohelm.benchmarks.bench import BenchReport, Result, Task, known_name, split_names, unset
from cohelm.benchmarks.claims import NONE, Bound
from cohelm.benchmarks.ride_claims import Requirement
from cohelm.benchmarks.rides.modes import (
    ALL_RIDES,
    MODES,
    WITHOUT_DESTINATION,
    Experiment,
    modes_report,
)
from cohelm.benchmarks.rides.sharing_families import SplitScene
from cohelm.evaluation.sweeps import RideTask, check_rides, ride_row

SCENES = ("doorway-oncoming", "doorway-standing")
RIDERS = ("one_switch", "eight_directions", "ideal", "tremor")
WIDTHS = (0.76, 0.84)
"""Widths of the door, m, on whole cells of the scenes."""
DOORWAYS = Experiment(
    title="Narrow doorways among people",
    claims=(
        Requirement("reached", Bound(low=0.9), (ALL_RIDES,), "assisted"),
        Requirement("reached", Bound(low=0.9), ("rider *",), "assisted"),
        Requirement("fast_contacts", NONE, (ALL_RIDES,), "assisted"),
    ),
    scenes=SCENES,
    seeds=5,
)
COMPARED = {
    "rider": "--riders",
    "mode": "--modes",
    "start": "the seed",
    "floor_plan.doors.0.width": "the benchmark, which rides several widths",
}
"""Keys that cannot be set for all rides → what sets them."""


@dataclass(frozen=True)
class DoorwaysBench:
    """The benchmark with some riders and modes."""

    riders: tuple[str, ...]
    modes: tuple[str, ...]
    settings: tuple[str, ...] = ()
    TITLE: str = DOORWAYS.title
    SEEDS: int = DOORWAYS.seeds
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per seed, scene, width and rider, with the rides of all modes."""
        return [
            tuple(self.ride(scene, width, rider, mode, seed) for mode in self.modes)
            for seed in seeds
            for scene in DOORWAYS.scenes
            for width in WIDTHS
            for rider in self.riders
        ]

    def ride(self, scene: str, width: float, rider: str, mode: str, seed: int) -> RideTask:
        """One ride; nothing but the mode differs between those of one task."""
        return RideTask(
            columns=(("scene", f"{scene}, {width:.2f} m"), ("rider", rider), ("mode", mode)),
            scenario=scene,
            settings=(
                f"floor_plan.doors.0.width={width}",
                f"rider.use={rider}",
                f"mode={mode}",
                *SplitScene(scene).settings_for(seed),
                *self.settings,
            ),
            seed=seed,
        )

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Ride in every mode."""
        return [ride_row(each, empty_floor=False) for each in task]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Tables by mode, scene and rider, and verdicts."""
        return modes_report(results, folder, DOORWAYS)


def create(
    riders: str | None = None, modes: str | None = None, settings: Sequence[str] = ()
) -> DoorwaysBench:
    """Create the benchmark from its options; names are comma-separated.

    Raises:
        ConfigError, PluginError, ScenarioError: if a rider, a mode or a setting does not exist.
    """
    unset(settings, COMPARED)
    chosen = split_names(modes, "--modes") or MODES
    for mode in chosen:
        known_name(mode, MODES, "mode", "--modes")
    known = tuple(name for name in plugins.names("riders") if name not in WITHOUT_DESTINATION)
    hands = split_names(riders, "--riders") or RIDERS
    for hand in hands:
        known_name(hand, known, "rider", "--riders")
    bench = DoorwaysBench(hands, chosen, tuple(settings))
    check_rides(replace(bench, modes=chosen[:1]).tasks(range(1)), "rider")
    return bench
