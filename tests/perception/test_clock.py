"""Clocks: each sensor is compared with itself."""

import numpy as np
import pytest

from cohelm.messages import Observation, PointCloud, Scan, Sensing
from cohelm.perception.clock import Clocks, read_clocks

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
    """What is said of moments, the readings of one observation each, at the newest of their times."""
    memory, told = Clocks(), []
    for k, readings in enumerate(moments):
        now = max((reading.time for reading in readings), default=0.1 * k)
        sensing, memory = read_clocks(observed(now, *readings), memory)
        told.append(sensing.value)
    return told


def test_sensors_that_speak_at_one_instant_one_after_the_other_are_no_trouble():
    moments = [[scan(0.0)], [scan(0.0, BACK)], [cloud(0.0)], [scan(0.1)], [cloud(0.1)]]
    assert said(*moments) == ["ok"] * 5


def test_a_sensor_may_be_late_behind_another():
    moments = [[scan(1.0)], [cloud(0.8)], [scan(1.1)], [cloud(0.9)], [scan(1.2, BACK), cloud(1.0)]]
    assert said(*moments) == ["ok"] * 5


def test_a_sensor_that_says_the_same_time_again_stands():
    assert said([scan(1.0)], [scan(1.0)], [scan(1.1)]) == ["ok", "clock_stands", "ok"]
    assert said([scan(1.0), cloud(1.0)], [scan(1.0), cloud(1.1)])[-1] == "ok"  # one goes on
    assert said([cloud(1.0)], [cloud(1.0)])[-1] == "clock_stands"  # of a height not known


def test_a_reading_older_than_the_newest_of_its_sensor_is_told_until_it_catches_up():
    moments = [[scan(t)] for t in (1.0, 0.7, 0.9, 1.0, 1.1)]
    assert said(*moments) == ["ok", "clock_back", "clock_back", "clock_stands", "ok"]


def test_where_time_runs_back_by_more_than_a_second_all_sensors_begin_anew():
    moments = [[scan(5.0)], [cloud(5.0)], [scan(3.9)], [cloud(3.9)], [scan(4.0)]]
    assert said(*moments) == ["ok", "ok", "clock_back", "ok", "ok"]
    assert said([scan(5.0)], [], [])[1:] == ["clock_back", "silent"]


def test_nobody_speaks():
    assert said([], []) == ["silent", "silent"]


@pytest.mark.parametrize("time", [np.nan, -np.inf])
def test_a_time_that_is_no_number_is_none(time):
    assert said([scan(1.0), cloud(time)])[-1] == "ok"
    sensing, memory = read_clocks(observed(1.0, scan(time)), Clocks())
    assert sensing is Sensing.CLOCK_STANDS
    assert memory.heard == ()


def test_a_mount_that_moves_costs_no_memory():
    memory = Clocks()
    for k in range(100):
        turned = scan(0.1 * k, (0.0, 0.0, 0.01 * k))
        sensing, memory = read_clocks(observed(0.1 * k, turned), memory)
        assert sensing is Sensing.OK
    assert len(memory.heard) < 20
