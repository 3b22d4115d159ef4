"""Riders × modes × scenes on the same seeds: what ``paper-static`` and ``riders`` share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple

from cohelm import plugins
from cohelm.errors import ConfigError
from cohelm.evaluation.benches.bench import Report, Result, Task, check_free, parted
from cohelm.evaluation.benches.rides_scenes import Contender, Scene, scenes_of
from cohelm.evaluation.benches.rides_verdicts import OURS
from cohelm.evaluation.benches.steering_report import make_report
from cohelm.evaluation.sweeps import RideTask, check_rides, ride_row
from cohelm.messages import Mode

MODES = tuple(each.value for each in (Mode.MANUAL, Mode.ASSISTED, Mode.SHARED, Mode.AUTONOMOUS))
STEER_NOWHERE = ("none", "idle", "nudge", "watchful")
"""Riders with no way of their own: nobody, who does nothing, who nudges once, who looks out."""


class Experiment(NamedTuple):
    """What is asked, and of which rides where nobody asks for others."""

    title: str
    asks: Literal["paper", "limits"]
    """What is judged: what the paper concludes, or what any rider may ask for."""
    scenes: tuple[str, ...]
    seeds: int


@dataclass(frozen=True)
class SteeringBench:
    """The benchmark with some riders in some scenes."""

    riders: tuple[str, ...]
    modes: tuple[str, ...]
    scenes: tuple[Scene, ...]
    asks: Literal["paper", "limits"]
    """See :class:`Experiment`."""
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


def steered(
    usual: Experiment,
    riders: str | None = None,
    modes: str | None = None,
    scenes: str | None = None,
    settings: Sequence[str] = (),
    *,
    true_people: bool = False,
) -> SteeringBench:
    """The benchmark as options ask for it; names are parted by commas.

    Raises:
        ScenarioError, PluginError, ConfigError: if something does not exist, before anything is
            ridden.
    """
    check_free(settings, {"rider": "--riders", "mode": "--modes"})
    names = parted(riders, "--riders") or known_riders()
    ways = parted(modes, "--modes") or MODES
    for mode in ways:
        if mode not in MODES:
            raise ConfigError(
                f"no mode is called {mode!r}; there are {', '.join(MODES)}", key="--modes"
            )
    where = scenes_of(
        parted(scenes, "--scenes") or usual.scenes,
        blind=False,
        both=False,
        true_people=true_people,
        settings=tuple(settings),
    )
    bench = SteeringBench(names, ways, where, usual.asks, usual.title, usual.seeds)
    check_rides(replace(bench, modes=ways[:1]).tasks(range(1)), "rider")
    return bench
