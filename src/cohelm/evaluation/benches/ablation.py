"""What each idea in our planner is worth: everything as it is, then one thing at a time left out.

All variants ride the same scenes with the same seeds, people who do not see the chair included, so
that nobody else's caution stands in for what is left out. Sharing is judged by rides with a rider
who steers, beside the same rides in which the stick counts for nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cohelm.evaluation.benches.ablation_report import make_report
from cohelm.evaluation.benches.bench import Report, Result, Task, check_free, parted
from cohelm.evaluation.benches.rides_scenes import (
    Contender,
    Scene,
    comparisons,
    scenario_of,
    scenes_of,
)
from cohelm.evaluation.benches.rides_verdicts import OURS
from cohelm.evaluation.presets import tuned_settings
from cohelm.evaluation.results import write_results
from cohelm.evaluation.scenario import PARTS
from cohelm.evaluation.sweeps import ride_row

TITLE = "What each idea is worth: one at a time left out"
SEEDS = 20
WORKERS = None
WHOLE, STEERED = "whole", "whole, a rider steers"
LIMITATIONS = (
    "One idea is left out at a time, with all other parameters as they were found with it: what is "
    "left could be tuned to do without.",
    f"Differences on the page are from {WHOLE!r}, that of 'η = 0' too; the bench's own tables "
    "compare it with the same rides in which the chair listens.",
    "What is called clear is so by an interval of 95 % of its own: of twenty differences that are "
    "none, one is called so.",
)
"""In words, for the page."""

SCENES = ("crossing", "aggressive", "distracted", "talking", "hospital")
_MARGINS = ("wall", "people", "squeezing", "squeezing_wall")
_RIDER = ("rider.use=ideal", "mode=shared")


@dataclass(frozen=True)
class Variant:
    """One idea left out."""

    says: str
    """What is done instead."""
    settings: tuple[str, ...]
    base: str = WHOLE
    """What it is compared with."""


VARIANTS: Mapping[str, Variant] = {
    WHOLE: Variant("everything as it is", ()),
    "γ = 1": Variant(
        "barriers are plain distance constraints, without foresight in how they close",
        tuple(
            f"local_planner.{each}.gamma=1" for each in ("bodies", "social_space", "group_space")
        ),
    ),
    "no social space": Variant(
        "people are bodies without personal space",
        ("social_model.contour_scale=1e-6", "profile.social_distance=0"),
    ),
    "no groups": Variant(
        "people who belong together are taken one by one", ("group_detector.use=alone",)
    ),
    "no prediction": Variant(
        "people are expected to stand where they are",
        ("predictor.use=constant_velocity", "predictor.lasting=0"),
    ),
    "one future": Variant(
        "people are expected to keep going", ("predictor.use=constant_velocity",)
    ),
    "five futures": Variant(
        "people may keep going, stop, turn back or aside", ("predictor.use=hypotheses",)
    ),
    "one candidate": Variant(
        "the last plan goes on, and others are looked for only where that fails",
        ("local_planner.candidates=1",),
    ),
    "short look": Variant(
        "ways are judged no farther ahead than they are planned",
        ("local_planner.arcs.horizon=0.1",),
    ),
    "thin verification": Variant(
        "plans are checked without margins, for the moment only",
        (
            *(f"local_planner.verification.{each}_margin=0" for each in _MARGINS),
            "local_planner.verification.agility=0",
            "local_planner.verification.time=0.01",
        ),
    ),
    STEERED: Variant("an ideal rider steers along, and the chair listens", _RIDER),
    "η = 0": Variant(
        "the same rider steers, and the chair does not listen",
        (*_RIDER, "mode=autonomous"),
        base=STEERED,
    ),
}
"""Name → what is left out; the settings are those of a scenario."""


@dataclass(frozen=True)
class AblationBench:
    """The benchmark with some variants in some scenes."""

    variants: tuple[Contender, ...]
    scenes: tuple[Scene, ...]
    TITLE: str = TITLE
    SEEDS: int = SEEDS
    WORKERS: int | None = WORKERS

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One for each seed and scene, so that an interrupt leaves whole comparisons."""
        return comparisons(self.scenes, self.variants, seeds)

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """The ride of every variant."""
        return [ride_row(each) for each in task]

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """Each variant less what it is compared with."""
        bases = {name: each.base for name, each in VARIANTS.items()}
        says = {name: each.says for name, each in VARIANTS.items()}
        made = make_report([result.row for result in results], bases, says, folder)
        written = write_results(
            results, folder, title=TITLE, base=WHOLE, report=made, limitations=LIMITATIONS
        )
        return replace(made, files=(*made.files, *written))


def on(
    scenes: str | None = None,
    settings: Sequence[str] = (),
    *,
    blind: bool = True,
    true_people: bool = False,
    tuned: bool = False,
) -> AblationBench:
    """The benchmark as options ask for it; names are parted by commas.

    Raises:
        ScenarioError, PluginError, ConfigError: if a scene or a setting does not exist, before
            anything is ridden.
    """
    check_free(settings, {"people.see_robot": "--seeing"} if blind else {})
    where = scenes_of(
        parted(scenes, "--scenes") or SCENES,
        blind=blind,
        both=False,
        true_people=true_people,
        settings=tuple(settings),
    )
    best = tuned_settings(OURS) if tuned else ()
    contenders = tuple(
        Contender(name=name, planner=OURS, settings=(*best, *variant.settings))
        for name, variant in VARIANTS.items()
        if not _is_usual(variant)
    )
    for scene in where:
        for contender in contenders:
            scenario_of(scene, contender, 0)
    return AblationBench(variants=contenders, scenes=where)


def _is_usual(variant: Variant) -> bool:
    """Whether it names just the predictor that is used anyway."""
    return variant.settings == (f"predictor.use={PARTS['predictor'][1]}",)
