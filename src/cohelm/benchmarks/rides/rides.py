"""All local planners in the same scenes with the same seeds: Xu et al., Table 3 and beyond.

A seed gives every planner the same people, localisation errors and rider. The dynamic scenes of the
paper are the default. The turn in ``distracted`` is swept over 20 moments, see ``cases``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from cohelm import plugins
from cohelm.benchmarks.bench import LOCAL_PLANNERS, BenchReport, Result, Task, split_names, unset
from cohelm.benchmarks.claims import (
    ALL,
    NONE,
    Bound,
)
from cohelm.benchmarks.ride_claims import (
    FewestOf,
    NearFastest,
    Requirement,
)
from cohelm.benchmarks.rides.cases import (
    DYNAMIC,
    BenchScene,
    Contender,
    comparisons,
    installed,
    is_rival,
    scenario_of,
    scenes_of,
)
from cohelm.benchmarks.rides.report import ReportSpec, ride_report
from cohelm.evaluation.metrics.measures import REPORTED
from cohelm.evaluation.sweeps import ride_row
from cohelm.scenarios.presets import tuned_settings

TITLE = "Local planners in the same scenes, ride by ride (Xu et al., Table 3)"

_FLAWLESS, _BLIND = ("crossing", "aggressive"), ("*, blind", "aggressive", "distracted")
_PEOPLE_BLIND = "all scenes with blind people"
CLAIMS = (
    Requirement("reached", ALL, _FLAWLESS),
    Requirement("collisions", NONE, _FLAWLESS),
    Requirement("person_collisions", Bound(high=0.02), ("distracted",)),
    Requirement("contact_speed", Bound(high=0.3), ("distracted",)),
    Requirement("standing_contacts", Bound(), ("distracted",)),
    FewestOf("person_collisions", ("distracted",), is_rival, strict=True),
    Requirement("time_ratio", Bound(high=1.4), DYNAMIC),
    Requirement("reached", ALL, ("corridor-[0-9]",)),
    Requirement("contacts", NONE, ("corridor-[0-9]",)),
    Requirement("reached", Bound(low=0.95), _BLIND, pooled=_PEOPLE_BLIND),
    FewestOf("collisions", _BLIND, is_rival, pooled=_PEOPLE_BLIND),
    NearFastest(Bound(high=1.15), _BLIND, is_rival, pooled=_PEOPLE_BLIND),
    # The comparison is valid only if the baselines behave as intended.
    Requirement("collisions", NONE, ("aggressive",), contender="mpc_dcbf"),
    Requirement("gap", Bound(low=0.6), ("crossing",), contender="social_mpc"),
)
"""Requirements, written down before the rides."""
SPEC = ReportSpec(
    title=TITLE,
    claims=CLAIMS,
    page=(*REPORTED, "social_space_intrusion", "pedestrian_delay", "pedestrian_deviation"),
    limitations=(
        "People avoid the chair by ORCA; with --blind none of them sees it.",
        "Planners use their default parameters, or with --tuned those of one search for all; a "
        "planner's author may find better ones.",
    ),
    picture="rides.png",
)


@dataclass(frozen=True)
class RidesBench:
    """The benchmark with some planners in some scenes."""

    planners: tuple[Contender, ...]
    scenes: tuple[BenchScene, ...]
    TITLE: str = TITLE
    SEEDS: int = 20
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per seed and scene."""
        return comparisons(self.scenes, self.planners, seeds)

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Ride with every planner."""
        return [ride_row(each) for each in task]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Table per scene, paired differences, verdicts."""
        return ride_report(results, folder, SPEC)


def create(
    planners: str | None = None,
    scenes: str | None = None,
    settings: Sequence[str] = (),
    *,
    blind: bool = False,
    both: bool = False,
    true_people: bool = False,
    tuned: bool = False,
) -> RidesBench:
    """Create the benchmark from its options; names are comma-separated.

    Raises:
        ScenarioError, PluginError, ConfigError: if a scene, a planner or a setting does not exist.
    """
    sight = {"people.see_robot": "--blind and --both"} if blind or both else {}
    unset(settings, {**LOCAL_PLANNERS, **sight})
    contenders = tuple(
        Contender(name=name, planner=name, settings=tuned_settings(name) if tuned else ())
        for name in split_names(planners, "--planners") or installed()
    )
    requested = scenes_of(
        split_names(scenes, "--scenes") or DYNAMIC,
        blind=blind,
        both=both,
        true_people=true_people,
        settings=tuple(settings),
    )
    for scene in requested:
        for contender in contenders:
            planner = scenario_of(scene, contender, 0).local_planner
            plugins.build("local_planners", planner, key="local_planner")
    return RidesBench(planners=contenders, scenes=requested)
