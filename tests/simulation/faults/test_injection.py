"""Each fault has its effect, and only while it is active."""

from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from cohelm.arrays import identical
from cohelm.messages import Observation, PointCloud, RiderCommand, Scan
from cohelm.simulation import FAULT_KINDS, Fault
from cohelm.simulation.faults import injection
from cohelm.simulation.faults.api import FaultMemory


def observation(time):
    scan = Scan(
        time=time,
        mount=np.zeros(3),
        angle_min=0.0,
        angle_increment=1.0,
        range_max=10.0,
        ranges=np.array([1.0, np.inf, 3.0]),
    )
    cloud = PointCloud(
        time=time,
        mount=np.array([0.0, 0.0, 1.3, 0.0, 0.0, 0.0]),
        points=np.ones((2, 3), dtype=np.float32),
        range_max=10.0,
    )
    return Observation(
        time=time,
        pose=np.array([time, 1.0, np.pi / 2]),
        pose_time=time,
        twist=np.array([time, 0.0, 0.0]),
        twist_time=time,
        scans=(scan,),
        clouds=(cloud,),
        rider=RiderCommand(heartbeat=time, deflection=np.array([time / 100.0, 0.0])),
    )


LAST, NOW = observation(4.95), observation(5.0)
SILENT = NOW.scans[0].ranges * np.nan

EXPECTED = {
    "scan_silent": replace(NOW, scans=(), clouds=()),
    "pose_silent": replace(NOW, pose=LAST.pose, pose_time=4.95),
    "twist_silent": replace(NOW, twist=LAST.twist, twist_time=4.95),
    "rider_silent": replace(NOW, rider=LAST.rider),
    "scan_nan": replace(
        NOW,
        scans=(replace(NOW.scans[0], ranges=np.full(3, np.nan)),),
        clouds=(replace(NOW.clouds[0], points=np.full((2, 3), np.nan, dtype=np.float32)),),
    ),
    "pose_nan": replace(NOW, pose=np.full(3, np.nan)),
    "twist_nan": replace(NOW, twist=np.full(3, np.nan)),
    "rider_nan": replace(NOW, rider=replace(NOW.rider, deflection=np.full(2, np.nan))),
    "late": replace(NOW, late=0.5),
}


def with_faults(observation, faults, last):
    """Delivered observation, after ``last`` was delivered as it was."""
    before = FaultMemory() if last is None else FaultMemory(last=last, recent=(last,))
    streams = [np.random.default_rng(i) for i in range(len(faults))]
    return injection.with_faults(observation, faults, before, lambda i, _: streams[i])[0]


def faulty(kind, *, at=5.0, duration=1.0):
    size = 0.5 if FAULT_KINDS[kind].unit else None
    return (Fault(kind=kind, at=at, duration=duration, magnitude=size),)


@pytest.mark.parametrize("kind", EXPECTED)
def test_what_arrives(kind):
    assert identical(with_faults(NOW, faulty(kind), LAST), EXPECTED[kind])


def test_a_jump_is_to_the_left():
    jumped = with_faults(NOW, faulty("pose_jump"), LAST)
    np.testing.assert_allclose(jumped.pose, [4.5, 1.0, np.pi / 2])  # facing +y, left is −x
    assert identical(replace(jumped, pose=NOW.pose), NOW)


def test_a_clock_that_goes_back_takes_all_stamps_along():
    back = with_faults(NOW, faulty("clock_backwards"), LAST)
    sensors = (back.scans[0].time, back.clouds[0].time)
    stamps = (back.time, back.pose_time, back.twist_time, *sensors, back.rider.heartbeat)
    assert stamps == (4.5,) * 6


@pytest.mark.parametrize("kind", [*EXPECTED, "pose_jump", "clock_backwards"])
@pytest.mark.parametrize("at", [5.05, 3.9])
def test_nothing_before_and_after(kind, at):
    assert with_faults(NOW, faulty(kind, at=at, duration=1.1), LAST) is NOW


@pytest.mark.parametrize("kind", [*EXPECTED, "pose_jump", "clock_backwards"])
def test_without_a_device_or_a_past(kind):
    with_faults(replace(NOW, rider=None), faulty(kind), None)


def test_faults_add_up():
    both = with_faults(NOW, faulty("late") + faulty("pose_silent"), LAST)
    assert both.late == 0.5
    assert both.pose_time == 4.95


def test_an_unknown_kind_is_refused():
    with pytest.raises(ValidationError):
        Fault(kind="gremlins", at=1.0)
