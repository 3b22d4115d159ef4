"""The bench of speed: what it counts, and what it says of it."""

import pytest

from cohelm.benchmarks import ride_speed as speed
from cohelm.benchmarks.bench import Result
from cohelm.errors import ConfigError
from cohelm.robots import load_robot


def row(case, factor, planner="ss_mpc_dcbf"):
    stages = {f"{name}_ms": 1.0 for name in (*speed.STAGES, "world")}
    return {"scene": "crossing", "case": case.name, "planner": planner, "people": 5,
            "factor": factor, **stages}  # fmt: skip


def test_a_ride_of_a_second_has_its_times(tmp_path):
    bench = speed.SpeedBench(("path_follower",), ("empty",), ("time_limit=1",))
    (task,) = (t for t in bench.tasks(range(1)) if t[2] == 0)
    (result,) = bench.work(task, tmp_path)
    told = result.row
    assert told["simulated"] == pytest.approx(1.0)
    assert told["factor"] == pytest.approx(told["simulated"] / told["cpu"])
    # 21 ticks and the set-up are all that there is
    spent = sum(told[f"{name}_ms"] for name in (*speed.STAGES, "world"))
    assert told["cpu"] == pytest.approx(1e-3 * (21 * spent + told["build_ms"]), rel=1e-6)


def test_what_is_asked_is_said_to_be_met_or_missed():
    scanner, lidar, _ = speed.CASES
    said = speed.SpeedBench((), ()).report(
        [Result(row(scanner, 10.0)), Result(row(lidar, 1.9))], None
    )
    assert [each["result"] for each in said.summary["verdicts"]] == ["met", "MISSED"]
    assert len(said.sheets[0].rows) == 2


def test_the_lidar_has_the_rays_that_are_asked_for(tmp_path):
    robot = load_robot(speed._lidar(tmp_path))
    assert [(each.rings, each.azimuths, each.rate) for each in robot.cloud_mounts] == [
        (16, 360, 10.0)
    ]
    assert robot.lasers == ()


def test_a_planner_that_is_none_is_refused():
    with pytest.raises(ConfigError, match="--planners"):
        speed.create(planners=" ")
