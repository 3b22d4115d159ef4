"""Riders × modes × scenes on the same seeds: what ``paper-static`` and ``riders`` share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from cohelm import plugins
from cohelm.errors import ConfigError
from cohelm.evaluation.benches.bench import Report, Result, Task, parted
from cohelm.evaluation.benches.rides_scenes import Contender, Scene, scenes_of
from cohelm.evaluation.benches.rides_verdicts import OURS
from cohelm.evaluation.benches.steering_report import make_report
from cohelm.evaluation.sweeps import RideTask, check_rides, ride_row
from cohelm.messages import Mode

MODES = tuple(each.value for each in (Mode.MANUAL, Mode.ASSISTED, Mode.SHARED, Mode.AUTONOMOUS))
STEER_NOWHERE = ("none", "idle", "nudge", "watchful")
"""Riders with no way of their own: nobody, who does nothing, who nudges once, who looks out."""


@dataclass(frozen=True)
class SteeringBench:
    """The benchmark with some riders in some scenes."""

    riders: tuple[str, ...]
    modes: tuple[str, ...]
    scenes: tuple[Scene, ...]
    asks: Literal["paper", "limits"]
    """What is judged: what the paper concludes, or what any rider may ask for."""
    TITLE: str = ""
    SEEDS: int = 10
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """The modes of one rider in one scene with one seed each: whole comparisons."""
        return [
            tuple(self.ride(scene, rider, mode, seed) for mode in self.modes)
            for seed in seeds
            for scene in self.scenes
            for rider in self.riders
        ]

    def ride(self, scene: Scene, rider: str, mode: str, seed: int) -> RideTask:
        """One ride; the person at the stick is the same whoever is listened to."""
        who = Contender(rider, OURS, (f"rider.use={rider}", f"mode={mode}"))
        return RideTask(
            columns=(("scene", scene.label), ("rider", rider), ("mode", mode)),
            scenario=scene.scenario,
            settings=scene.settings_for(who, seed),
            seed=seed,
        )

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """The rides of a task."""
        return [ride_row(each) for each in task]

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """Tables by mode, scene and rider, paired differences, and what was asked for."""
        return make_report(results, folder, self.asks, self.TITLE)


def known_riders() -> tuple[str, ...]:
    """The installed riders who steer somewhere; ``ideal`` first."""
    names = [name for name in plugins.names("riders") if name not in STEER_NOWHERE]
    return tuple(sorted(names, key=lambda name: (name != "ideal", name)))


def chosen(
    scenes: Iterable[str],
    riders: str | None,
    modes: str | None,
    settings: Sequence[str],
    *,
    true_people: bool,
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[Scene, ...]]:
    """(Riders, modes, scenes) as options ask for them, each tried before anything is ridden.

    Raises:
        ScenarioError, PluginError, ConfigError: if something does not exist.
    """
    names = parted(riders, "--riders") or known_riders()
    ways = parted(modes, "--modes") or MODES
    for mode in ways:
        if mode not in MODES:
            raise ConfigError(
                f"no mode is called {mode!r}; there are {', '.join(MODES)}", key="--modes"
            )
    where = scenes_of(
        scenes, blind=False, both=False, true_people=true_people, settings=tuple(settings)
    )
    trial = SteeringBench(riders=names, modes=ways[:1], scenes=where, asks="limits")
    check_rides(trial.tasks(range(1)), "rider")
    return names, ways, where
