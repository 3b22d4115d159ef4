"""All local planners in the same scenes with the same seeds: Xu et al., Table 3 and beyond.

A seed gives every planner the same people, localisation errors and rider. The dynamic scenes of the
paper are the default. The turn in ``distracted`` is swept over 20 moments, see ``cases``.
"""

from __future__ import annotations

from functools import partial
from typing import Annotated

from cohelm.benchmarks.bench import LOCAL_PLANNERS, chosen_names, unset
from cohelm.benchmarks.claims import (
    ALL,
    NONE,
    Bound,
)
from cohelm.benchmarks.options import Planners, Scenes, Settings, TruePeople, Tuned, flag
from cohelm.benchmarks.ride_claims import (
    FewestOf,
    NearFastest,
    Requirement,
)
from cohelm.benchmarks.rides.cases import (
    DYNAMIC,
    installed,
    is_rival,
    planners_of,
    scenes_of,
)
from cohelm.benchmarks.rides.report import ReportSpec, ride_report
from cohelm.benchmarks.study import Grid, Study, common
from cohelm.evaluation.metrics.measures import REPORTED

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


def create(
    planners: Planners = None,
    scenes: Scenes = None,
    settings: Settings = (),
    *,
    blind: Annotated[bool, flag("--blind", "People do not see the chair.")] = False,
    both: Annotated[
        bool, flag("--both", "Ride every scenario unchanged and with --blind.")
    ] = False,
    true_people: TruePeople = False,
    tuned: Tuned = False,
) -> Study:
    """Create the study from its options; names are comma-separated.

    Raises:
        ScenarioError, PluginError, ConfigError: if a scene, a planner or a setting does not exist.
    """
    sight = {"people.see_robot": "--blind and --both"} if blind or both else {}
    unset(settings, {**LOCAL_PLANNERS, **sight})
    ridden = scenes_of(
        chosen_names(scenes, "--scenes", DYNAMIC),
        blind=blind,
        both=both,
        true_people=true_people,
        settings=tuple(settings),
    )
    compared = planners_of(chosen_names(planners, "--planners", installed()), tuned=tuned)
    plan = Grid((ridden, common(settings), compared))
    return Study(TITLE, plan, partial(ride_report, spec=SPEC)).checked()
