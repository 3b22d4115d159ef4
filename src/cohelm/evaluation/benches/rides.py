"""Every local planner in the same scenes with the same seeds, Xu et al., Table 3 and beyond.

A seed gives everyone the same people, the same errors of localisation, the same rider. The scenes
of the paper come by default; any scenario can be named. ``distracted`` is ridden with the moment of
the turn swept over 20 values, see ``rides_scenes``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cohelm import plugins
from cohelm.evaluation.benches.bench import (
    LOCAL_PLANNERS,
    Report,
    Result,
    Task,
    check_free,
    parted,
)
from cohelm.evaluation.benches.rides_report import make_report
from cohelm.evaluation.benches.rides_scenes import (
    DYNAMIC,
    OWN_SETTINGS,
    Contender,
    Scene,
    comparisons,
    scenario_of,
    scenes_of,
)
from cohelm.evaluation.benches.rides_verdicts import OURS
from cohelm.evaluation.presets import tuned_settings
from cohelm.evaluation.results import write_results
from cohelm.evaluation.results.measures import SHOWN
from cohelm.evaluation.sweeps import ride_row

TITLE = "Local planners in the same scenes, ride by ride (Xu et al., Table 3)"
SEEDS = 20
WORKERS = None
LIMITATIONS = (
    "People who see the chair are ORCA's: they do much of the avoiding themselves. With --blind "
    "nobody sees it.",
    "Planners ride with the parameters they come with, or with --tuned those of one search for "
    "all; a planner's author may find better ones.",
)
"""In words, for the page."""
MEASURES = (*SHOWN, "social_space_intrusion", "pedestrian_delay", "pedestrian_deviation")
"""In the page's tables."""


@dataclass(frozen=True)
class RidesBench:
    """The benchmark with some planners in some scenes."""

    planners: tuple[Contender, ...]
    scenes: tuple[Scene, ...]
    TITLE: str = TITLE
    SEEDS: int = SEEDS
    WORKERS: int | None = WORKERS

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One for each seed and scene, so that an interrupt leaves whole comparisons."""
        return comparisons(self.scenes, self.planners, seeds)

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """The ride of every planner."""
        return [ride_row(each) for each in task]

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """A table for each scene, paired differences, and what was asked for."""
        made = make_report([result.row for result in results], folder)
        written = write_results(
            results,
            folder,
            title=TITLE,
            base=OURS,
            measures=MEASURES,
            report=made,
            limitations=LIMITATIONS,
        )
        return replace(made, files=(*made.files, *written))


def on(
    planners: str | None = None,
    scenes: str | None = None,
    settings: Sequence[str] = (),
    *,
    blind: bool = False,
    both: bool = False,
    true_people: bool = False,
    tuned: bool = False,
) -> RidesBench:
    """The benchmark as options ask for it; names are parted by commas.

    Raises:
        ScenarioError, PluginError, ConfigError: if a scene, a planner or a setting does not exist,
            before anything is ridden.
    """
    sight = {"people.see_robot": "--blind and --both"} if blind or both else {}
    check_free(settings, {**LOCAL_PLANNERS, **sight})
    chosen = parted(planners, "--planners") or installed()
    contenders = tuple(
        Contender(name=name, planner=name, settings=tuned_settings(name) if tuned else ())
        for name in chosen
    )
    where = scenes_of(
        parted(scenes, "--scenes") or DYNAMIC,
        blind=blind,
        both=both,
        true_people=true_people,
        settings=tuple(settings),
    )
    for scene in where:
        for contender in contenders:
            plugins.build(
                "local_planners", scenario_of(scene, contender, 0).local_planner,
                key="local_planner",
            )  # fmt: skip
    return RidesBench(planners=contenders, scenes=where)


def installed() -> tuple[str, ...]:
    """The local planners there are: ours first, those that are no rivals last."""
    names = plugins.names("local_planners")
    return tuple(sorted(names, key=lambda name: (name in OWN_SETTINGS, name != OURS, name)))
