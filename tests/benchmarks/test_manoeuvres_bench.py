"""The benchmark of narrow places: floors, starts, destinations and options."""

import numpy as np
import pytest

from cohelm.benchmarks.rides import manoeuvres
from cohelm.benchmarks.rides.manoeuvres import draw
from cohelm.errors import ConfigError
from cohelm.evaluation import Outcome, run
from cohelm.maps import distance_field
from cohelm.robots import load_robot
from cohelm.robots.turning_room import can_turn
from cohelm.scenarios.build import floor_of
from cohelm.scenarios.scenario import load_scenario

CASES = [(place, way) for place in manoeuvres.PLACES for way in ("in", "out")]


def drawn(place, way, robot, seed):
    return load_scenario("lift", [f"robot={robot}", *draw(place, way, load_robot(robot), seed)])


@pytest.mark.parametrize("robot", manoeuvres.CHAIRS)
@pytest.mark.parametrize(("place", "way"), CASES)
def test_a_chair_fits_where_it_starts(place, way, robot):
    chair = load_robot(robot)
    for seed in range(5):
        scenario = drawn(place, way, robot, seed)
        walls = distance_field(floor_of(scenario).grid)
        pose = np.array([*scenario.start[:2], np.radians(scenario.start[2])])
        edge = np.linspace(chair.outline, np.roll(chair.outline, -1, axis=0), 20).reshape(-1, 2)
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        corners = pose[:2] + edge @ np.array([[cos, sin], [-sin, cos]])
        assert walls.at(corners).min() > 0.03
        if way == "out" and place != "side door":
            assert not can_turn(chair, pose, np.pi, walls, margin=0.02)


def test_both_chairs_get_the_same_floor_and_each_seed_another_one():
    one, other = (drawn("lift", "in", robot, 3) for robot in manoeuvres.CHAIRS)
    assert one.floor_plan == other.floor_plan
    assert one.start == other.start
    assert drawn("niche", "in", "rear_drive", 4).floor_plan != (
        drawn("niche", "in", "rear_drive", 5).floor_plan
    )


@pytest.mark.parametrize("given", [{"places": "attic"}, {"settings": ("start=[1, 1]",)}])
def test_what_does_not_exist_or_is_drawn_cannot_be_set(given):
    with pytest.raises(ConfigError):
        manoeuvres.create(**given)


def test_a_chair_backs_out_of_a_lift_without_a_stop():
    ride = run(load_scenario("lift"), seed=0)
    assert ride.outcome is Outcome.REACHED
    assert max((stop.duration for stop in ride.stops), default=0.0) < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("robot", manoeuvres.CHAIRS)
@pytest.mark.parametrize(("place", "way"), CASES)
def test_narrow_places_are_entered_and_left(place, way, robot):
    ride = run(drawn(place, way, robot, 0), seed=0)
    assert ride.outcome is Outcome.REACHED


def test_the_report_judges_every_chair(tmp_path):
    bench = manoeuvres.create(places="niche")
    task = next(
        task for task in bench.tasks(range(1)) if dict(task[0].columns)["scene"].endswith("out")
    )
    report = bench.report(bench.work(task, tmp_path), tmp_path)
    assert [verdict["result"] for verdict in report.summary["verdicts"]] == ["met"] * 4
