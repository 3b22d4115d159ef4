"""Riders in all modes on the same seeds: ``paper-static`` and ``riders``.

In the paper people rode the corridors (Xu et al., Fig. 13); here simulated riders do. The paper's
shared control is ``shared``; ``assisted`` helps the rider with steering, ``stop_only`` is the rider
behind the safety gate. Satisfaction was not measured with people: effort and agreement are reported
as proxies.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from cohelm import plugins
from cohelm.benchmarks.bench import BenchReport, Result, chosen_names, unset
from cohelm.benchmarks.claims import (
    AGREES,
    CONTRADICTS,
    NONE,
    UNCLEAR,
    Bound,
    Verdict,
)
from cohelm.benchmarks.options import Modes, Riders, Scenes, Settings, TruePeople
from cohelm.benchmarks.ride_claims import (
    Claim,
    Groups,
    Ordering,
    Requirement,
    within,
)
from cohelm.benchmarks.rides.cases import scenes_of
from cohelm.benchmarks.rides.report import Findings, ReportSpec, finish, rides_by
from cohelm.benchmarks.study import Axis, Grid, Study, axis, common
from cohelm.benchmarks.tables import (
    difference_table,
    figures,
    group_table,
    paired_differences,
)
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.statistics import bootstrap_mean
from cohelm.messages import Mode

MODES = tuple(
    each.value
    for each in (Mode.MANUAL, Mode.STOP_ONLY, Mode.ASSISTED, Mode.SHARED, Mode.AUTONOMOUS)
)
WITHOUT_DESTINATION = ("none", "idle", "nudge", "watchful")
"""Riders that do not steer to a destination."""
LATER = ("eight_directions", "looks_away")
"""Riders of the study of sharing; left out by default, so that older tables stay comparable."""
BY = ("scene", "rider", "mode")
ALL_RIDES = "all rides"
_FIGURES = ("time", "path_length", "heading_change", "rider_effort", "agreement", "conflict_share")
MEASURES = ("reached", "any_collision", "touch_speed", "standing_contact", *_FIGURES)
LIMITATIONS = (
    "collision: the moving chair touches a person, or it touches a wall; the ride ends there",
    "effort (stick movement, in full deflections), agreement and fights (share of time in which "
    "requested and given turn are opposite) are proxies for a rider's opinion",
    "riders are simulated; intervals of differences take the rides of one scene and seed together, "
    "those of shares and medians treat rides as independent and are too narrow",
)
REQUIREMENTS = (
    Requirement("fast_contacts", NONE, (ALL_RIDES,), "assisted"),
    Requirement("fast_contacts", NONE, (ALL_RIDES,), "shared"),
    Requirement("reached", Bound(low=0.95), (ALL_RIDES,), "assisted"),
    Requirement("reached", Bound(low=0.95), (ALL_RIDES,), "shared"),
    Requirement("time_ratio", Bound(high=1.4), (ALL_RIDES,), "shared"),
    Requirement("fast_contacts", NONE, ("rider *",), "assisted", only_missed=True),
    Requirement("fast_contacts", NONE, ("rider *",), "shared", only_missed=True),
    Requirement("reached", Bound(low=0.95), ("rider *",), "shared", only_missed=True),
)
"""Requirements for every rider: no fast contact, nearly all arrive, and in time."""
SOURCE = "Xu et al., Fig. 13"


@dataclass(frozen=True)
class BetterThanAlone:
    """Statement that shared control is better than autonomous driving, scene by scene.

    Better is to arrive more often, or as often and clearly sooner.
    """

    def verdicts(self, groups: Groups) -> Iterator[Verdict]:
        """See :class:`~cohelm.benchmarks.claims.Claim`."""
        for case, by_mode in groups.items():
            if case.startswith("scene ") and {"shared", "autonomous"} <= by_mode.keys():
                yield self._verdict(case, by_mode["shared"], by_mode["autonomous"])

    @staticmethod
    def _verdict(case: str, shared: Rides, alone: Rides) -> Verdict:
        more, later = (
            bootstrap_mean(paired_differences(shared, alone, key)) for key in ("reached", "time")
        )
        if more.low > 0.0 or (more.low >= 0.0 and later.count and later.high < 0.0):
            result = AGREES
        elif more.high < 0.0 or (later.count and later.low > 0.0):
            result = CONTRADICTS
        else:
            result = UNCLEAR
        found = (
            f"{int(shared.reached.sum())} of {len(shared)} arrive, autonomous "
            f"{int(alone.reached.sum())} of {len(alone)}, time {later.mean:+.1f} s"
        )
        faultless = result != AGREES and alone.reached.all() and not alone.any_collision.any()
        remark = "the autonomous chair neither fails nor freezes here" if faultless else ""
        text = f"shared control is better than autonomous driving in {case.removeprefix('scene ')}"
        return Verdict(SOURCE, text, found, result=result, remark=remark)


def _less(one: str, measure: str, text: str) -> Ordering:
    return Ordering(text, (measure,), -1, within((ALL_RIDES,), one, ("manual",)), SOURCE)


PAPER = (
    _less("shared", "any_collision", "shared control collides less than manual driving"),
    _less("assisted", "any_collision", "assisted driving collides less than manual driving"),
    _less("shared", "heading_change", "shared control turns less than manual driving"),
    BetterThanAlone(),
)
"""Conclusions of the paper on its corridors."""


@dataclass(frozen=True)
class Experiment:
    """Defaults and claims of one benchmark."""

    title: str
    claims: tuple[Claim, ...]
    scenes: tuple[str, ...]
    seeds: int


CORRIDORS = Experiment(
    title="Driving modes in the paper's corridors (Xu et al., Fig. 13)",
    claims=PAPER,
    scenes=("corridor-1", "corridor-2", "corridor-3", "corridor-4"),
    seeds=5,
)
"""Each scene has an obstacle near its centre line, and a turn of at most 1.3 m."""
ALL_RIDERS = Experiment(
    title="Driving modes with all simulated riders",
    claims=REQUIREMENTS,
    scenes=("corridor-1", "corridor-4", "crossing", "distracted", "talking"),
    seeds=10,
)


def modes_report(results: Sequence[Result], folder: Path, experiment: Experiment) -> BenchReport:
    """Report of rides with columns ``scene``, ``rider`` and ``mode``."""
    rides = Rides([result.row for result in results], BY)
    scenes, riders = rides_by(rides, "scene"), rides_by(rides, "rider")
    modes = rides_by(rides, "mode")
    by_scene = {scene: rides_by(each, "mode") for scene, each in scenes.items()}
    by_rider = {rider: rides_by(each, "mode") for rider, each in riders.items()}
    groups = {
        ALL_RIDES: modes,
        **{f"scene {scene}": each for scene, each in by_scene.items()},
        **{f"rider {rider}": each for rider, each in by_rider.items()},
    }
    sheets = [group_table("all riders in all scenes", modes, MEASURES, "mode")]
    sheets += [
        group_table(f"{mode}, all scenes", rides_by(each, "rider"), MEASURES, "rider")
        for mode, each in modes.items()
    ]
    sheets += [
        group_table(f"{scene}, all riders", each, MEASURES, "mode")
        for scene, each in by_scene.items()
    ]
    compared = ("reached", "any_collision", *_FIGURES)
    sheets += [
        difference_table(where, each, "shared", compared, "mode")
        for where, each in {"all scenes": modes, **by_scene}.items()
    ]
    summary = {
        "modes": figures(modes, MEASURES),
        "riders": {rider: figures(each, MEASURES) for rider, each in by_rider.items()},
    }
    spec = ReportSpec(
        title=experiment.title,
        claims=experiment.claims,
        by=BY,
        base="shared",
        page=("reached", "person_collision", "wall_collision", *_FIGURES),
        limitations=LIMITATIONS,
    )
    return finish(results, folder, spec, Findings(tuple(sheets), summary=summary), groups)


def known_riders() -> tuple[str, ...]:
    """Installed riders with a destination but the later ones; ``ideal`` first."""
    left_out = {*WITHOUT_DESTINATION, *LATER}
    names = [name for name in plugins.names("riders") if name not in left_out]
    return tuple(sorted(names, key=lambda name: (name != "ideal", name)))


def create(
    experiment: Experiment,
    riders: Riders = None,
    modes: Modes = None,
    scenes: Scenes = None,
    settings: Settings = (),
    *,
    true_people: TruePeople = False,
) -> Study:
    """Create the study of an experiment from its options; names are comma-separated.

    Raises:
        ScenarioError, PluginError, ConfigError: if a name or a setting does not exist.
    """
    unset(settings, {"rider": "--riders", "mode": "--modes"})
    ridden = scenes_of(chosen_names(scenes, "--scenes", experiment.scenes), true_people=true_people)
    hands = riders_of(chosen_names(riders, "--riders", known_riders()))
    return Study(
        experiment.title,
        Grid((ridden, common(settings), hands, modes_of(modes))),
        partial(modes_report, experiment=experiment),
        SEEDS=experiment.seeds,
    ).checked("rider")


def riders_of(names: Iterable[str]) -> Axis:
    """Axis of simulated riders; their draws do not depend on the mode."""
    return axis("rider", {name: (f"rider.use={name}",) for name in names})


def modes_of(names: str | None) -> Axis:
    """Axis of driving modes of the option ``--modes``, by default all.

    Raises:
        ConfigError: if there is no such mode.
    """
    found = chosen_names(names, "--modes", MODES, kind="mode", known=MODES)
    return axis("mode", {name: (f"mode={name}",) for name in found})


create_corridors = partial(create, CORRIDORS)
create_riders = partial(create, ALL_RIDERS)
