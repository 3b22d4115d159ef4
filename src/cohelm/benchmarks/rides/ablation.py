"""Ablation of our planner: the complete planner, and variants that lack one component.

All variants ride the same scenes with the same seeds. People do not see the chair, because their
avoidance would replace the missing component. Sharing is judged by rides with a rider who steers,
compared with equal rides in which the rider's input is ignored.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from cohelm.arrays import Floats
from cohelm.benchmarks.bench import BenchReport, Result, chosen_names, unset
from cohelm.benchmarks.claims import ENOUGH, OURS
from cohelm.benchmarks.options import Scenes, Settings, TruePeople, Tuned, flag
from cohelm.benchmarks.rides.cases import contender_of, scenes_of
from cohelm.benchmarks.rides.report import MEASURES, Findings, ReportSpec, finish
from cohelm.benchmarks.study import Axis, Grid, Study, common
from cohelm.benchmarks.tables import (
    as_dict,
    differences_sheet,
    group_table,
    groups_of,
    measure,
    paired_differences,
    value_text,
)
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.statistics import Estimate, bootstrap_mean
from cohelm.scenarios.presets import tuned_settings
from cohelm.scenarios.scenario import PARTS

TITLE = "Ablation: one component left out at a time"
WHOLE, STEERED = "complete", "complete, with a rider"
SCENES = ("crossing", "aggressive", "distracted", "talking", "hospital")
COMPARED = ("reached", "person_collision", "time", "min_distance", "proxemics_intimate")
ALL_SCENES = "all scenes"
_RIDER = ("rider.use=ideal", "mode=shared")


@dataclass(frozen=True)
class Ablation:
    """Variant that lacks one component."""

    text: str
    """Behaviour without it."""
    settings: tuple[str, ...]
    base: str = WHOLE
    """Variant that it is compared with."""


VARIANTS: Mapping[str, Ablation] = {
    WHOLE: Ablation("nothing left out", ()),
    "γ = 1": Ablation(
        "barriers are plain distance constraints, without the rate at which they close",
        tuple(f"local_planner.terms.{each}.gamma=1" for each in ("bodies", "social_space")),
    ),
    "no social space": Ablation(
        "people are bodies without personal space",
        ("social_model.contour_scale=1e-6", "profile.social_distance=0"),
    ),
    "no groups": Ablation(
        "members of a group are treated as single people", ("group_detector.use=no_groups",)
    ),
    "no prediction": Ablation(
        "people are expected to stand still",
        ("predictor.velocity_share=0",),
    ),
    "no barriers": Ablation(
        "people are costs by distance only, in the search and in the program",
        tuple(
            f"local_planner.terms.{each}.{price}=0"
            for each in ("bodies", "social_space")
            for price in ("l1", "l2")
        ),
    ),
    "one candidate": Ablation(
        "the last plan continues; others are sampled only where it fails",
        ("local_planner.candidates=1",),
    ),
    "short horizon": Ablation(
        "candidates are evaluated no farther ahead than they are planned",
        ("local_planner.sampling.horizon=0.1",),
    ),
    "reduced verification": Ablation(
        "plans are verified without margins and for the present only",
        (
            "local_planner.verification.wall_margin=0",
            "local_planner.verification.clearance_share=0",
            "local_planner.verification.people_acceleration=0",
            "local_planner.verification.horizon=0.01",
        ),
    ),
    STEERED: Ablation("an ideal rider steers too, and the chair follows", _RIDER),
    "η = 0": Ablation(
        "the same rider steers, and the chair ignores it",
        (*_RIDER, "mode=autonomous"),
        base=STEERED,
    ),
}
"""Name → variant; its settings are those of a scenario."""
SPEC = ReportSpec(
    title=TITLE,
    compared=COMPARED,
    base=WHOLE,
    limitations=(
        "One component is left out at a time; all other parameters stay as tuned with it. "
        "The rest could be tuned for its absence.",
        f"Differences on the page are from {WHOLE!r}, that of 'η = 0' too; the tables of the "
        "benchmark compare it with equal rides in which the chair follows the rider.",
        "A difference is called clear by its own 95 % interval: of twenty differences that do not "
        "exist, one is called clear.",
    ),
    picture="ablation.png",
)


def create(
    scenes: Scenes = None,
    settings: Settings = (),
    *,
    seeing: Annotated[
        bool, flag("--seeing", "People see the chair as the scenario specifies.")
    ] = False,
    true_people: TruePeople = False,
    tuned: Tuned = False,
) -> Study:
    """Create the study from its options; names are comma-separated.

    Raises:
        ScenarioError, PluginError, ConfigError: if a scene or a setting does not exist.
    """
    unset(settings, {} if seeing else {"people.see_robot": "--seeing"})
    ridden = scenes_of(
        chosen_names(scenes, "--scenes", SCENES),
        blind=not seeing,
        true_people=true_people,
        settings=tuple(settings),
    )
    plan = Grid((ridden, common(settings), variants(tuned=tuned)))
    return Study(TITLE, plan, ablation_report).checked()


def variants(*, tuned: bool = False) -> Axis:
    """Axis of ``VARIANTS``; ``tuned``: with the parameters of the common search."""
    best = tuned_settings(OURS) if tuned else ()
    return tuple(
        contender_of(name, OURS, variant.settings, best)
        for name, variant in VARIANTS.items()
        if not _is_default(variant)
    )


def ablation_report(results: Sequence[Result], folder: Path) -> BenchReport:
    """Difference of each variant from its base, over all scenes and scene by scene."""
    groups = groups_of([result.row for result in results])
    return finish(results, folder, SPEC, ablation_findings(groups), groups)


def _is_default(variant: Ablation) -> bool:
    """Check that a variant only names the default predictor."""
    return variant.settings == (f"predictor.use={PARTS['predictor'][1]}",)


Differences = Mapping[str, Mapping[str, Estimate]]
"""Variant → measure → difference from its base."""


def ablation_findings(groups: Mapping[str, Mapping[str, Rides]]) -> Findings:
    """Tables of differences and of rides, and one sentence per variant.

    Args:
        groups: scene → variant → rides.
    """
    by_scene = {scene: _differences(each) for scene, each in groups.items()}
    pooled = {
        name: {m: np.concatenate([d[name][m] for d in by_scene.values() if name in d])
               for m in COMPARED}
        for name in dict.fromkeys(name for d in by_scene.values() for name in d)
    }  # fmt: skip
    means = {
        scene: {name: {m: bootstrap_mean(x) for m, x in by.items()} for name, by in each.items()}
        for scene, each in {ALL_SCENES: pooled, **by_scene}.items()
    }
    title = "difference from the complete planner on equal seeds"
    sheets = [
        differences_sheet(f"{scene}: {title}", each, COMPARED, "left out")
        for scene, each in means.items()
    ]
    sheets += [group_table(scene, each, MEASURES, "variant") for scene, each in groups.items()]
    summary = {
        scene: {name: {m: as_dict(x) for m, x in by.items()} for name, by in each.items()}
        for scene, each in means.items()
    }
    return Findings(tuple(sheets), _sentences(means[ALL_SCENES]), {"differences": summary})


def _differences(by_variant: Mapping[str, Rides]) -> dict[str, dict[str, Floats]]:
    """Variant → measure → its difference from the base, by ride."""
    out = {}
    for name, rides in by_variant.items():
        base = VARIANTS[name].base
        if base != name and base in by_variant:
            out[name] = {m: paired_differences(rides, by_variant[base], m) for m in COMPARED}
    return out


def _sentences(differences: Differences) -> tuple[str, ...]:
    """Measures that get clearly better or worse without each component."""
    out = []
    for name, by_measure in differences.items():
        found: dict[str, list[str]] = {"worse": [], "better": []}
        for key, each in by_measure.items():
            if each.count >= ENOUGH and not each.low <= 0.0 <= each.high:
                word = "better" if each.mean * measure(key).better > 0.0 else "worse"
                sign = "+" if each.mean > 0.0 else ""
                found[word].append(f"{measure(key).label} {sign}{value_text(each.mean, key)}")
        clear = "; ".join(f"clearly {w}: {', '.join(what)}" for w, what in found.items() if what)
        count = max((each.count for each in by_measure.values()), default=0)
        none = "no clear difference" if count >= ENOUGH else f"{count} rides are too few to judge"
        out.append(f"{name} ({VARIANTS[name].text}): {clear or none}")
    return tuple(out)
