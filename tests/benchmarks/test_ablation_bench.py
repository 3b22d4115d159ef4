"""The benchmark that leaves one idea out at a time."""

import math

import numpy as np
import pytest

from cohelm.benchmarks.rides import ablation
from cohelm.benchmarks.rides.ablation import STEERED, VARIANTS, WHOLE, ablation_findings
from cohelm.benchmarks.rides.cases import contender_of, scene_of
from cohelm.benchmarks.study import scenario_of
from cohelm.benchmarks.tables import groups_of
from cohelm.messages import Groups
from cohelm.scenarios import build_scenario
from cohelm.testing.problems import random_problem
from cohelm.testing.scenes import local_problem


@pytest.mark.parametrize("name", VARIANTS)
def test_every_variant_is_a_ride_that_can_be_set_up(name):
    variant = contender_of(name, "ss_mpc_dcbf", VARIANTS[name].settings)
    stage = build_scenario(scenario_of((scene_of("talking"), variant), 0), 0)
    assert stage.navigator.local_planner is not None


def test_every_variant_but_the_bases_changes_something():
    whole = scenario_of((scene_of("talking"), contender_of(WHOLE, "ss_mpc_dcbf")), 0)
    for variant in ablation.variants():
        changed = scenario_of((scene_of("talking"), variant), 0)
        assert (changed != whole) == (variant.label != WHOLE)


def part(name, kind):
    """The part of that kind which the variant rides with."""
    variant = contender_of(name, "ss_mpc_dcbf", VARIANTS[name].settings)
    return getattr(
        build_scenario(scenario_of((scene_of("talking"), variant), 0), 0).navigator, kind
    )


def test_without_social_space_nobody_has_any():
    variant = contender_of("", "ss_mpc_dcbf", VARIANTS["no social space"].settings)
    scenario = scenario_of((scene_of("talking"), variant), 0)
    problem = random_problem(np.random.default_rng(2), 3).problem
    spaces = part("no social space", "social_model").spaces(
        problem.people,
        Groups.alone(3),
        problem.predictions,
        np.array([0.8, 0.0, 0.0]),
        scenario.profile,
    )
    # of a person at 1.5 m/s: σ_h √(2c) = 3 m √(2·10⁻⁶)
    assert np.sqrt(2.0 * spaces.scale) * spaces.front.max() < 0.01
    assert spaces.floor == spaces.robot_floor == 0.0


def test_a_short_horizon_is_as_long_as_a_plan():
    planner = part("short horizon", "local_planner")
    problem = local_problem(steps=planner.steps, step=planner.step)
    plan = planner.plan(problem, None)
    p = planner.parameters
    assert len(plan.inputs) == p.steps
    assert p.steps <= planner.steps < p.steps + p.sampling.stride
    assert len(plan.memory.tail) == planner.steps - p.steps


def test_what_a_variant_is_compared_with_is_ridden_too():
    names = {each.label for each in ablation.variants()}
    assert {VARIANTS[name].base for name in names} <= names
    assert VARIANTS["η = 0"].base == STEERED


def row(variant, seed, scene, **changes):
    return {
        "scene": scene,
        "planner": variant,
        "seed": seed,
        "outcome": "reached",
        "time": 12.0,
        "time_empty_floor": 10.0,
        "collision_speed": math.nan,
        "min_distance": 0.5,
        "collisions_person": 0,
        "collisions_wall": 0,
        "standing_contacts": 0,
        "proxemics_intimate": 0.1,
        "stalled_time": 0.0,
        "solve_median_ms": 1.0,
        "solve_p99_ms": 2.0,
        "people_source": "tracker",
        "error": "",
        **changes,
    }


LESS = "no groups"


def test_differences_are_those_of_the_rides():
    rows = [row(WHOLE, s, scene) for scene in ("one", "two") for s in range(10)]
    rows += [row(LESS, s, "one", time=13.0, min_distance=0.3) for s in range(10)]
    rows += [row(LESS, s, "two", time=11.0, min_distance=0.3) for s in range(10)]
    made = ablation_findings(groups_of(rows))
    found = made.summary["differences"]
    assert found["one"][LESS]["time"] == {"value": 1.0, "low": 1.0, "high": 1.0, "count": 10}
    assert found["all scenes"][LESS]["time"]["value"] == 0.0
    assert found["all scenes"][LESS]["time"]["low"] < 0.0
    assert np.isclose(found["all scenes"][LESS]["min_distance"]["value"], -0.2)
    assert any("clearly worse: " in note and note.endswith(" -0.20") for note in made.notes)
    assert made.sheets[0].title.startswith("all scenes")


def test_a_few_rides_are_no_finding():
    rows = [row(WHOLE, s, "one") for s in range(19)]
    rows += [row(LESS, s, "one", time=13.0) for s in range(19)]
    (note,) = ablation_findings(groups_of(rows)).notes
    assert note.endswith("19 rides are too few to judge")
