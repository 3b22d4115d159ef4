"""The benchmark that leaves one idea out at a time."""

import math

import numpy as np
import pytest

from cohelm.evaluation import set_stage
from cohelm.evaluation.benches import ablation
from cohelm.evaluation.benches.ablation import STEERED, VARIANTS, WHOLE
from cohelm.evaluation.benches.ablation_report import make_report
from cohelm.evaluation.benches.rides_scenes import Contender, Scene, scenario_of
from cohelm.messages import Groups
from cohelm.testing.problems import random_problem
from cohelm.testing.scenes import local_problem


@pytest.mark.parametrize("name", VARIANTS)
def test_every_variant_is_a_ride_that_can_be_set_up(name):
    contender = Contender(name, "ss_mpc_dcbf", VARIANTS[name].settings)
    stage = set_stage(scenario_of(Scene("talking"), contender, 0), 0)
    assert stage.navigator.local_planner is not None


def test_every_variant_but_the_bases_changes_something():
    whole = scenario_of(Scene("talking"), Contender(WHOLE, "ss_mpc_dcbf"), 0)
    for contender in ablation.on(scenes="talking").variants:
        changed = scenario_of(Scene("talking"), contender, 0)
        assert (changed != whole) == (contender.name != WHOLE)


def part(name, kind):
    """The part of that kind which the variant rides with."""
    contender = Contender(name, "ss_mpc_dcbf", VARIANTS[name].settings)
    return getattr(set_stage(scenario_of(Scene("talking"), contender, 0), 0).navigator, kind)


def test_without_social_space_nobody_has_any():
    contender = Contender("", "ss_mpc_dcbf", VARIANTS["no social space"].settings)
    scenario = scenario_of(Scene("talking"), contender, 0)
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


def test_a_short_look_is_as_long_as_a_plan():
    planner = part("short look", "local_planner")
    problem = local_problem(steps=planner.steps, step=planner.step)
    ways = planner.arcs.ways(problem, np.zeros(2))
    stride = planner.parameters.arcs.stride
    assert planner.steps <= ways.inputs.shape[1] < planner.steps + stride
    assert planner.steps == planner.parameters.steps


def test_what_a_variant_is_compared_with_is_ridden_too():
    names = {each.name for each in ablation.on(scenes="crossing").variants}
    assert {VARIANTS[name].base for name in names} <= names
    assert VARIANTS["η = 0"].base == STEERED


def row(variant, seed, scene, **changes):
    return {
        "scene": scene,
        "planner": variant,
        "seed": seed,
        "outcome": "reached",
        "time": 12.0,
        "time_alone": 10.0,
        "collision_speed": math.nan,
        "min_distance": 0.5,
        "collisions_person": 0,
        "collisions_wall": 0,
        "standing_contacts": 0,
        "proxemics_intimate": 0.1,
        "stalled_time": 0.0,
        "solve_median_ms": 1.0,
        "solve_p99_ms": 2.0,
        "people_from": "tracker",
        "error": "",
        **changes,
    }


def test_differences_are_those_of_the_rides(tmp_path):
    bases = {"whole": "whole", "less": "whole"}
    rows = [row("whole", s, scene) for scene in ("one", "two") for s in range(10)]
    rows += [row("less", s, "one", time=13.0, min_distance=0.3) for s in range(10)]
    rows += [row("less", s, "two", time=11.0, min_distance=0.3) for s in range(10)]
    made = make_report(rows, bases, {"less": "what it does without"}, tmp_path)
    less = made.summary["differences"]
    assert less["one"]["less"]["time"] == {"mean": 1.0, "low": 1.0, "high": 1.0, "count": 10}
    assert less["all scenes"]["less"]["time"]["mean"] == 0.0
    assert less["all scenes"]["less"]["time"]["low"] < 0.0
    assert np.isclose(less["all scenes"]["less"]["min_distance"]["mean"], -0.2)
    assert "less (what it does without): clearly worse: gap, m -0.20" in made.notes
    assert made.sheets[0].title.startswith("all scenes")
    assert (tmp_path / "ablation.png").stat().st_size > 0


def test_a_few_rides_are_no_finding(tmp_path):
    rows = [row("whole", s, "one") for s in range(19)]
    rows += [row("less", s, "one", time=13.0) for s in range(19)]
    bases = {"whole": "whole", "less": "whole"}
    made = make_report(rows, bases, {"less": "what it does without"}, tmp_path)
    assert "less (what it does without): 19 rides are too few to judge by" in made.notes
