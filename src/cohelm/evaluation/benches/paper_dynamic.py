"""Table 3 of Xu et al.: every local planner in the three dynamic scenes, beside the paper's rows.

All planners are told where people truly are; ours rides with its sensors besides. Everybody rides
at one speed, which the paper's own means imply, and again at the 1.2 m/s that its text names. The
moment of the turn of ``distracted`` is swept over the seeds, see ``rides_scenes``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from cohelm.config import read_yaml
from cohelm.evaluation.benches.bench import (
    LOCAL_PLANNERS,
    Report,
    Result,
    Task,
    check_free,
    parted,
)
from cohelm.evaluation.benches.paper_dynamic_report import SENSED, SLOW, make_report
from cohelm.evaluation.benches.rides import installed
from cohelm.evaluation.benches.rides_scenes import DYNAMIC, OWN_SETTINGS, Contender, Scene
from cohelm.evaluation.benches.rides_verdicts import OURS
from cohelm.evaluation.presets import as_settings, tuned_settings
from cohelm.evaluation.sweeps import RideTask, check_rides, ride_row

TITLE = "The paper's dynamic scenes, every local planner beside the paper's figures (Table 3)"
SEEDS = 20
WORKERS = None

NAMED = 1.2
"""The preferred speed that the paper's text names, m/s."""
FEWER, LEAST = 0.25, 20
"""Share of the seeds, and how many at least, that are ridden at it."""


@dataclass(frozen=True)
class PaperDynamicBench:
    """The benchmark with some planners."""

    contenders: tuple[Contender, ...]
    """Who rides; ``SENSED`` with its own sensors, all others told of people."""
    paces: Mapping[str, tuple[str, ...]]
    """Pace → settings of everybody's rides at it."""
    settings: tuple[str, ...] = ()
    """Of every ride, after all others."""
    TITLE: str = TITLE
    SEEDS: int = SEEDS
    WORKERS: int | None = WORKERS

    def tasks(self, seeds: range) -> Sequence[Task]:
        """The rides of one seed in one scene at one pace each: whole comparisons.

        All but the first pace, which is judged, are ridden on the first ``FEWER`` of the seeds.
        """
        some = seeds[: max(math.ceil(FEWER * len(seeds)), LEAST)]
        return [
            tuple(self.ride(who, pace, scene, seed) for who in self.contenders)
            for seed in seeds
            for pace in list(self.paces)[: None if seed in some else 1]
            for scene in DYNAMIC
        ]

    def ride(self, who: Contender, pace: str, scene: str, seed: int) -> RideTask:
        """One ride."""
        where = Scene(scene, true_people=who.name != SENSED, settings=self.paces[pace])
        return RideTask(
            columns=(("pace", pace), ("scene", scene), ("planner", who.name)),
            scenario=scene,
            settings=(
                f"local_planner.use={who.planner}",
                *where.settings_for(who, seed),
                *self.settings,
            ),
            seed=seed,
        )

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """The rides of a task."""
        return [ride_row(each) for each in task]

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """The tables, the verdict cell by cell, and the paper's claims."""
        return make_report(results, folder, TITLE)


def preset() -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Settings of (everybody, ours) in the paper's scenes.

    Raises:
        ConfigError: if the file does not hold a mapping.
    """
    found: dict[str, Any] = read_yaml(Path(str(files("cohelm.evaluation") / "paper_dynamic.yaml")))
    common, ours = (
        tuple(
            setting
            for part, parameters in found[who].items()
            for setting in as_settings(parameters, part)
        )
        for who in ("everyone", "ours")
    )
    return common, ours


def on(planners: str | None = None, settings: Sequence[str] = ()) -> PaperDynamicBench:
    """The benchmark as options ask for it; planners are parted by commas.

    Ours rides with the parameters of ``paper_dynamic.yaml``, the others with those that the search
    for all found, where there are any.

    Raises:
        PluginError, ConfigError, ScenarioError: if a planner or a setting does not exist, before
            anything is ridden.
    """
    said = {"profile.preferred_speed": "the pace of each table", "tracker": "the rows"}
    check_free(settings, {**LOCAL_PLANNERS, **said})
    everyone, ours = preset()
    names = parted(planners, "--planners") or [n for n in installed() if n not in OWN_SETTINGS]
    contenders = [
        Contender(name, name, ours if name == OURS else tuned_settings(name)) for name in names
    ]
    if OURS in names:
        contenders.insert(names.index(OURS) + 1, Contender(SENSED, OURS, ours))
    bench = PaperDynamicBench(
        contenders=tuple(contenders),
        paces={SLOW: everyone, f"{NAMED:g} m/s": (*everyone, f"profile.preferred_speed={NAMED}")},
        settings=tuple(settings),
    )
    check_rides(bench.tasks(range(1)), "local_planner")
    return bench
