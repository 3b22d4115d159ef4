import json

import numpy as np
import pytest

from cohelm.benchmarks.external import barn as bench
from cohelm.benchmarks.external.barn import difficulty
from cohelm.errors import ConfigError
from cohelm.evaluation.external.barn import (
    BarnOutcome,
    barn_setup,
    read_barn,
    ride_barn,
    score,
)
from cohelm.recordings.outside_data import outside_data
from cohelm.robots import load_robot


@pytest.fixture
def data(tmp_path):
    """Two worlds: a gate of two cylinders beside the straight way, and one in it."""
    worlds = {"0": [[-3.2, 6.0], [-1.3, 6.0]], "1": [[-2.3, 6.0]]}
    (tmp_path / "barn").mkdir()
    (tmp_path / "barn" / "barn_worlds.json").write_text(
        json.dumps(
            {
                "source": "made for a test",
                "radius": 0.075,
                "start": [-2.25, 3, 1.57],
                "goal": [-2.25, 13],
                "goal_tolerance": 1.0,
                "time_limit": 100,
                "worlds": worlds,
                "reference_path_length": [10.0, 10.4],
            }
        )
    )
    return tmp_path


def test_the_score_is_clipped_between_twice_and_eight_times_the_optimal_time():
    assert score(3.0, 5.0) == 0.5  # 5 / (2 · 5)
    assert score(20.0, 5.0) == 0.25
    assert score(99.0, 5.0) == 0.125  # 5 / (8 · 5)
    assert score(12.0, 5.0, least=4.0) == 0.25  # until March 2026: 5 / (4 · 5)


def test_the_optimal_time_is_the_reference_path_at_two_metres_a_second(data):
    worlds = read_barn(data)
    assert worlds.optimal_time(1) == pytest.approx(5.2)
    assert difficulty(worlds) == pytest.approx([1.0, 1.04])


def test_it_says_where_the_worlds_are_not_there(tmp_path, monkeypatch):
    with pytest.raises(ConfigError, match="COHELM_DATA"):
        read_barn(None)
    with pytest.raises(ConfigError, match="barn_worlds"):
        read_barn(tmp_path)
    monkeypatch.delenv("COHELM_DATA", raising=False)
    with pytest.raises(ConfigError, match="outside data"):
        bench.create().tasks(range(1))


def test_worlds_are_asked_for_by_number_or_spread_evenly():
    assert bench.create(worlds="3,299").worlds == (3, 299)
    assert bench.create(worlds="3").worlds == (0, 100, 200)
    assert len(bench.create().worlds) == 300
    for wrong in ("0", "301", "3,300", "x", "", " ", ","):
        with pytest.raises(ConfigError, match="0 to 299"):
            bench.create(worlds=wrong)
    with pytest.raises(ConfigError, match="dwaa"):
        bench.create(planners="dwaa")
    with pytest.raises(ConfigError, match=r"--planners.*names nothing"):
        bench.create(planners=",")


def test_the_robot_is_the_benchmarks_and_its_scanner_sees_three_quarters():
    robot = load_robot("jackal")
    assert np.ptp(robot.outline, axis=0) == pytest.approx([0.51, 0.43])
    assert robot.max_speed == 2.0
    assert robot.lasers[0].field_of_view_deg == 270.0


def test_the_true_world_has_the_cylinders_and_the_map_has_nothing(data, tmp_path):
    worlds = read_barn(data)
    stage = barn_setup(worlds, 0, "dwa", tmp_path)
    assert not stage.grid.blocked().any()
    truth = stage.world.grid
    area = truth.occupied().sum() * truth.resolution**2
    assert area == pytest.approx(2.0 * np.pi * 0.075**2, rel=0.05)
    assert stage.navigator.tracker.track.__self__.__class__.__name__ == "GivenPeople"


@pytest.mark.slow
def test_a_ride_ends_within_a_metre_of_the_goal_past_what_it_sees(data, tmp_path):
    worlds = read_barn(data)
    ride = ride_barn(worlds, 1, barn_setup(worlds, 1, "dwa", tmp_path))
    assert ride.outcome is BarnOutcome.SUCCESS
    assert np.hypot(*(ride.pose[-1, :2] - worlds.goal)) <= 1.0
    assert 0.0 < ride.least_gap < 0.6
    assert len(ride.seen)  # the cylinder is in the layer now


@pytest.mark.slow
def test_the_bench_rides_and_reports(data, tmp_path, monkeypatch):
    monkeypatch.setenv("COHELM_DATA", str(data))
    chosen = bench.create(planners="dwa", worlds="0,1")
    results = [r for task in chosen.tasks(range(1)) for r in chosen.work(task, tmp_path)]
    assert [r.row["outcome"] for r in results] == ["success", "success"]
    found = chosen.report(results, tmp_path)
    assert all(file.stat().st_size > 0 for file in found.files)
    assert found.sheets[0].rows[0][0] == "dwa"
    assert any("2-D port" in note for note in found.notes)


@pytest.mark.slow
@pytest.mark.data
def test_worlds_as_they_are_can_be_ridden(tmp_path):
    try:
        worlds = read_barn(outside_data())
    except ConfigError as missing:
        pytest.skip(str(missing))
    assert len(worlds.cylinders) == len(worlds.length) == 300
    for world in (90, 150):
        stage = barn_setup(worlds, world, "dwa", tmp_path)
        assert ride_barn(worlds, world, stage).outcome is BarnOutcome.SUCCESS
