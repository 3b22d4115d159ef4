import warnings

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.evaluation import Outcome, measure, run
from cohelm.scenarios import load_scenario
from cohelm.simulation import is_standing


@pytest.fixture(scope="module")
def empty():
    return run(load_scenario("empty"), 0)


def test_an_empty_hall_is_crossed(empty):
    assert empty.outcome is Outcome.REACHED
    assert np.hypot(*(empty.pose[-1, :2] - empty.goal)) <= 0.2
    assert is_standing(empty.twist[-1])
    values = measure(empty)
    assert values["path_length"] == pytest.approx(10.0, abs=0.05)
    assert values["collisions_wall"] == 0
    assert values["spl"] == pytest.approx(1.0, abs=0.01)


def test_a_ride_is_sampled_at_every_control_tick(empty):
    assert np.allclose(np.diff(empty.time), empty.step)
    assert len(empty.ticks) == pytest.approx(empty.time[-1] / 0.5, abs=2)
    assert set(empty.durations) > {"tick"}
    assert all(len(each) == len(empty.time) for each in empty.durations.values())


def test_the_same_seed_gives_the_same_ride_bit_for_bit():
    scenario = load_scenario("crossing", ["time_limit=3"])
    one, two = run(scenario, 5), run(scenario, 5)
    assert identical(one, two, ignore=frozenset({"durations", "scenario", "robot", "setup"}))
    other = run(scenario, 6)
    assert not np.array_equal(one.pose, other.pose)


def test_the_time_limit_ends_a_ride():
    ride = run(load_scenario("empty", ["time_limit=1.0"]), 0)
    assert ride.outcome is Outcome.TIMEOUT
    assert ride.time[-1] == pytest.approx(1.0)


def test_a_silent_laser_stops_the_chair_and_the_ride_says_why():
    settings = ["faults=[{kind: scan_silent, at: 2.0, duration: 100}]"]
    ride = run(load_scenario("empty", settings), 0)
    assert ride.outcome is Outcome.STOPPED
    assert ride.stops[-1].reason.value == "stale_scan"
    assert ride.stops[-1].time == pytest.approx(2.4, abs=0.5)
    assert ride.stops[-1].duration > 20.0


@pytest.mark.parametrize(
    ("kind", "reason"), [("scan_silent", "stale_scan"), ("scan_nan", "not_finite")]
)
def test_a_lidar_that_fails_stops_the_chair_and_the_ride_says_why(kind, reason):
    fault = f"faults=[{{kind: {kind}, at: 1.5, duration: 100}}]"
    robot = "robot=quantum_q6_edge_lidar"
    ride = run(load_scenario("empty", [robot, fault, "time_limit=3.5"]), 0)
    # silent: last heard at 1.4 s or later, the limit is 0.35 s; the last before it is still good
    assert [stop.reason.value for stop in ride.stops] == [reason]
    assert 1.5 <= ride.stops[0].time <= 1.5 + 0.35 + 0.05
    assert np.hypot(*(ride.pose[20, :2] - ride.pose[0, :2])) > 0.1  # it drove
    assert is_standing(ride.twist[-1])


def test_driving_blind_into_a_person_is_a_collision():
    # A rider who does not look, with nobody checking: manual is allowed to collide.
    settings = [
        "people={pedestrians: [{points: [[6, 7]]}], see_robot: false}",
        "mode=manual",
        "rider={use: ideal, avoids_obstacles: false}",
    ]
    ride = run(load_scenario("empty", settings), 0)
    assert ride.outcome is Outcome.COLLISION
    assert measure(ride)["collisions_person"] == 1
    assert measure(ride)["min_distance"] == 0.0
    assert ride.closest is not None


def test_a_watcher_sees_every_tick_and_changes_nothing(empty):
    seen = []
    ride = run(load_scenario("empty"), 0, lambda tick, truth: seen.append(truth.time))
    assert np.array_equal(seen, ride.time)
    assert np.array_equal(ride.pose, empty.pose)


def test_idle_in_shared_mode_is_autonomous_bit_for_bit():
    shared = run(load_scenario("empty", ["rider=idle", "time_limit=4"]), 0)
    alone = run(load_scenario("empty", ["mode=autonomous", "time_limit=4"]), 0)
    assert np.array_equal(shared.command, alone.command)


def test_a_fault_after_the_end_is_warned_of():
    fault = "faults=[{kind: scan_frozen, at: 2.0}]"
    late, early = (load_scenario("crossing", [fault, f"time_limit={t}"]) for t in (0.2, 2.1))
    with pytest.warns(UserWarning, match="scan_frozen begins at 2 s and never acts: time_limit is"):
        run(late, 0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run(early, 0)
