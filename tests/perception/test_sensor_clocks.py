"""Clocks: each sensor is compared with itself."""

import numpy as np
import pytest

from cohelm.messages import Observation, PointCloud, Scan, Sensing
from cohelm.perception.sensor_clocks import Clocks, check_clocks

FRONT, BACK = (0.4, 0.0, 0.0), (-0.4, 0.0, np.pi)
LIDAR = (0.0, 0.0, np.nan, 0.0, 0.0, 0.0)


def scan(time, mount=FRONT):
    return Scan(
        time=time,
        mount=np.array(mount),
        angle_min=0.0,
        angle_increment=0.1,
        range_max=10.0,
        ranges=np.ones(9),
    )


def cloud(time, mount=LIDAR):
    points = np.ones((1, 3), dtype=np.float32)
    return PointCloud(time=time, mount=np.array(mount), points=points, range_max=10.0)


def observed(now, *readings):
    return Observation(
        time=now,
        pose=np.zeros(3),
        pose_time=now,
        twist=np.zeros(3),
        twist_time=now,
        scans=tuple(each for each in readings if isinstance(each, Scan)),
        clouds=tuple(each for each in readings if isinstance(each, PointCloud)),
    )


def said(*moments):
    """What is said of moments, each the readings of one observation, at the newest of them."""
    return [use.sensing.value for use in used(*moments)]


def used(*moments):
    memory, out = Clocks(), []
    for k, readings in enumerate(moments):
        now = max((reading.time for reading in readings), default=0.1 * k)
        out.append(check_clocks(observed(now, *readings), memory))
        memory = out[-1].clocks
    return out


def kept(use):
    return len(use.observation.scans) + len(use.observation.clouds)


def test_sensors_that_speak_at_one_instant_one_after_the_other_are_no_trouble():
    moments = [[scan(0.0)], [scan(0.0, BACK)], [cloud(0.0)], [scan(0.1)], [cloud(0.1)]]
    assert said(*moments) == ["ok"] * 5


def test_a_sensor_may_be_late_behind_another():
    moments = [[scan(1.0)], [cloud(0.8)], [scan(1.1)], [cloud(0.9)], [scan(1.2, BACK), cloud(1.0)]]
    assert said(*moments) == ["ok"] * 5
    assert [kept(use) for use in used(*moments)] == [1, 1, 1, 1, 2]


def test_a_sensor_that_says_the_same_time_again_stands():
    assert said([scan(1.0)], [scan(1.0)], [scan(1.1)]) == ["ok", "clock_frozen", "ok"]
    assert said([scan(1.0), cloud(1.0)], [scan(1.0), cloud(1.1)])[-1] == "ok"  # one goes on
    assert said([cloud(1.0)], [cloud(1.0)])[-1] == "clock_frozen"  # of a height not known


def test_a_reading_that_was_overtaken_is_left_out():
    got = used([scan(1.0)], [scan(0.9)], [scan(1.1)], [scan(1.05)], [scan(1.2)])
    assert [use.sensing.value for use in got] == [
        "ok",
        "clock_backwards",
        "ok",
        "clock_backwards",
        "ok",
    ]
    assert [kept(use) for use in got] == [1, 0, 1, 0, 1]
    assert not any(use.reset for use in got)


def test_of_two_sensors_that_cannot_be_told_apart_the_later_one_is_believed():
    got = used(*([cloud(0.1 * k), cloud(0.1 * k - 0.3)] for k in range(5)))
    assert not any(use.reset for use in got)
    assert [kept(use) for use in got] == [2, 1, 1, 1, 1]


def test_behind_itself_twice_running_a_sensors_clock_ran_back():
    got = used(*([scan(t)] for t in (1.0, 0.5, 0.6, 0.7)))
    assert [use.sensing.value for use in got] == ["ok", "clock_backwards", "clock_backwards", "ok"]
    assert [use.reset for use in got] == [False, False, True, False]
    assert [kept(use) for use in got] == [1, 0, 1, 1]


def test_where_all_time_runs_back_by_more_than_a_second_all_sensors_begin_anew():
    got = used([scan(5.0)], [cloud(5.0)], [scan(3.9)], [cloud(3.9)], [scan(4.0)])
    assert [use.sensing.value for use in got] == ["ok", "ok", "clock_backwards", "ok", "ok"]
    assert [use.reset for use in got] == [False, False, True, False, False]
    assert said([scan(5.0)], [], [])[1:] == ["clock_backwards", "silent"]


def test_nobody_speaks():
    assert said([], []) == ["silent", "silent"]


@pytest.mark.parametrize("time", [np.nan, np.inf, -np.inf, 3600.0, -3600.0])
def test_a_reading_from_another_time_is_left_out_and_not_remembered(time):
    memory = check_clocks(observed(1.0, scan(1.0)), Clocks()).clocks
    use = check_clocks(observed(1.1, scan(time), cloud(1.1)), memory)
    assert use.sensing is Sensing.CLOCK_OFFSET
    assert (len(use.observation.scans), len(use.observation.clouds)) == (0, 1)
    assert check_clocks(observed(1.2, scan(1.2)), use.clocks).sensing is Sensing.OK


def test_a_mount_that_moves_costs_no_memory():
    memory = Clocks()
    for k in range(100):
        turned = scan(0.1 * k, (0.0, 0.0, 0.01 * k))
        use = check_clocks(observed(0.1 * k, turned), memory)
        memory = use.clocks
        assert use.sensing is Sensing.OK
    assert len(memory.sensors) < 20
