"""Stops, braking and felt jerk on rides made by hand."""

import math

import numpy as np
import pytest

from cohelm.evaluation import measure
from cohelm.evaluation.episode.ride import StopEvent
from cohelm.evaluation.metrics import comfort
from cohelm.messages import Reason

STEP = 0.1


def driven(made_ride, speed, **changes):
    """A ride along x with speeds (k,) at ticks 0.1 s apart; the goal is 10 m ahead."""
    speed = np.asarray(speed, dtype=float)
    pose = np.zeros((len(speed), 3))
    pose[1:, 0] = np.cumsum(speed[:-1]) * STEP
    twist = np.zeros((len(speed), 3))
    twist[:, 0] = speed
    return made_ride(pose, twist=twist, **{"step": STEP, **changes})


def stop(time, duration, reason=Reason.NO_SAFE_PLAN):
    return StopEvent(time=time, duration=duration, reason=reason)


def test_a_step_of_the_acceleration_is_felt_as_a_decaying_jerk(made_ride):
    # a = 1 m/s² from the first tick on: y = 1 − e^(−k) after k ticks of one time constant,
    # so that Δy/Δt = 10 (e − 1) e^(−k)
    ride = driven(made_ride, STEP * np.arange(6), step=STEP)
    expected = 10.0 * (math.e - 1.0) * np.exp(-np.arange(1.0, 6.0))
    np.testing.assert_allclose(comfort.felt_jerk(ride), expected)
    values = measure(ride)
    assert values["jerk_felt_rms"] == pytest.approx(np.sqrt(np.mean(expected**2)))
    # the 99th percentile of five values lies 0.96 of the way from the second to the largest
    assert values["jerk_felt_p99"] == pytest.approx(
        expected[1] + 0.96 * (expected[0] - expected[1])
    )


def test_felt_jerk_of_a_constant_acceleration_does_not_depend_on_the_step(made_ride):
    # the filter is exact: after 0.2 s, y = 1 − e^−2 for every step that divides it
    for step in (0.2, 0.1, 0.05):
        k = round(0.2 / step)
        ride = driven(made_ride, step * np.arange(k + 1), step=step)
        assert comfort.felt_jerk(ride).sum() * step == pytest.approx(1.0 - math.exp(-2.0))


def test_a_constant_speed_and_a_ride_of_one_tick_are_not_felt(made_ride):
    for ride in (driven(made_ride, [0.7] * 5), driven(made_ride, [0.7])):
        values = measure(ride)
        assert values["jerk_felt_rms"] == values["jerk_felt_p99"] == 0.0
        assert values["hard_braking"] == values["braking_time"] == 0.0
        assert math.isnan(values["gentle_braking"])
    assert math.isnan(measure(driven(made_ride, [0.7]))["stop_rate"])


def test_braking_counts_by_time_and_in_both_directions(made_ride):
    # decelerations: 0.8 exactly, 0.9, 0.04 (coasting), −1 (faster), then backwards 0.5 and 1.0
    forward = np.cumsum([1.0, -0.08, -0.09, -0.004, 0.1])
    backward = np.cumsum([-0.3, 0.05, 0.1])
    ride = driven(made_ride, forward)
    values = measure(ride)
    assert values["braking_time"] == pytest.approx(0.2)
    assert values["hard_braking"] == pytest.approx(1 / 4)
    assert values["gentle_braking"] == pytest.approx(1 / 2)
    values = measure(driven(made_ride, backward))
    assert values["braking_time"] == pytest.approx(0.2)
    assert values["hard_braking"] == values["gentle_braking"] == pytest.approx(1 / 2)


def test_a_stand_without_a_reason_is_a_stop(made_ride):
    # stands at the ticks 0 to 4 (start), and at 10 to 12: 0.2 s; 6 s in all
    speed = np.full(61, 0.5)
    speed[:5] = speed[10:13] = 0.0
    ride = driven(made_ride, speed)
    np.testing.assert_allclose(comfort.stop_intervals(ride), [[1.0, 1.2]])
    values = measure(ride)
    assert values["stop_rate"] == pytest.approx(10.0)
    assert values["short_stops"] == 1


def test_a_stop_of_three_tenths_is_not_short(made_ride):
    speed = np.full(61, 0.5)
    speed[10:14] = 0.0
    ride = driven(made_ride, speed)
    np.testing.assert_allclose(comfort.stop_intervals(ride), [[1.0, 1.3]])
    assert measure(ride)["short_stops"] == 0


def test_a_chair_that_turns_on_the_spot_does_not_stand(made_ride):
    twist = np.zeros((61, 3))
    twist[:, 0], twist[10:13, 0], twist[10:13, 2] = 0.5, 0.0, 0.5
    ride = driven(made_ride, twist[:, 0])
    turning = made_ride(ride.pose, twist=twist, step=STEP)
    assert measure(turning)["stop_rate"] == 0.0


def test_braking_for_a_reason_and_the_stand_that_follows_are_one_stop(made_ride):
    speed = np.full(61, 0.5)
    speed[20:31] = 0.0  # stands from 2.0 to 3.0 s
    stops = (stop(1.5, 0.7), stop(4.5, 0.1))  # the second one 1.5 s later, without a stand
    ride = driven(made_ride, speed, stops=stops)
    np.testing.assert_allclose(comfort.stop_intervals(ride), [[1.5, 3.0], [4.5, 4.6]])
    assert measure(ride)["stop_rate"] == pytest.approx(20.0)
    assert measure(ride)["short_stops"] == 1


@pytest.mark.parametrize(("again", "count"), [(3.9, 1), (4.2, 2)])
def test_stops_less_than_a_second_apart_are_one(made_ride, again, count):
    stops = (stop(2.0, 1.0), stop(again, 0.5))
    ride = driven(made_ride, np.full(61, 0.5), stops=stops)
    assert len(comfort.stop_intervals(ride)) == count


def test_arrival_and_the_wait_before_the_start_are_no_stops(made_ride):
    # 0.5 m/s from 1 s to 5 s: 2 m, where the goal is; brakes there for a reason and stands
    speed = np.zeros(71)
    speed[10:50] = 0.5
    stops = (stop(0.0, 0.5), stop(5.0, 0.2))
    ride = driven(made_ride, speed, stops=stops, goal=[2.0, 0.0])
    assert comfort.stop_intervals(ride).shape == (0, 2)
    assert measure(ride)["stop_rate"] == 0.0
    away = driven(made_ride, speed, stops=stops, goal=[2.3, 0.0])
    np.testing.assert_allclose(comfort.stop_intervals(away), [[5.0, 7.0]])


def test_a_chair_that_never_moves_does_not_come_to_a_stand(made_ride):
    ride = driven(made_ride, np.zeros(30), stops=(stop(0.0, 2.9),))
    assert measure(ride)["stop_rate"] == measure(ride)["short_stops"] == 0.0
