"""The drivetrain against the integrals of ramps and lags."""

import numpy as np
import pytest

from cohelm.messages import Decision
from cohelm.robots import Robot
from cohelm.simulation.drivetrain import at_rest, drive_command, step_drivetrain

DT = 0.001


def run(robot, wheels, decision, seconds):
    states = [wheels]
    for _ in range(round(seconds / DT)):
        states.append(step_drivetrain(robot, states[-1], drive_command(robot, decision), DT))
    return states


@pytest.fixture
def cruising(robot):
    return run(robot, at_rest(robot, np.zeros(3)), Decision(twist=np.array([1.0, 0, 0])), 4.0)[-1]


def test_a_ramp_followed_with_a_lag(robot):
    states = run(robot, at_rest(robot, np.zeros(3)), Decision(twist=np.array([9.0, 0, 0])), 4.0)
    speed = np.array([s.twist[0] for s in states])
    a, lag = robot.max_acceleration, robot.actuation_lag
    # v(t) = a (t − τ (1 − e^{−t/τ})) while the set-point climbs
    assert speed[500] == pytest.approx(a * (0.5 - lag * (1 - np.exp(-0.5 / lag))), abs=1e-3)
    assert speed[-1] == pytest.approx(robot.max_speed)  # 9 m/s is more than it can do
    assert np.diff(speed).max() <= a * DT + 1e-12


@pytest.mark.parametrize("emergency", [False, True])
def test_braking_takes_v2_over_2a_and_the_lag(robot, cruising, emergency):
    states = run(robot, cruising, Decision(twist=np.zeros(3), emergency=emergency), 3.0)
    a = robot.emergency_deceleration if emergency else robot.max_deceleration
    # ∫v = ∫set-point + τ v₀, a first-order lag: 1/2a + τ
    distance = states[-1].pose[0] - cruising.pose[0]
    assert distance == pytest.approx(1.0 / (2 * a) + robot.actuation_lag, abs=2e-3)
    np.testing.assert_array_equal(states[-1].twist, 0.0)


def test_turning_has_its_own_limit(robot):
    states = run(robot, at_rest(robot, np.zeros(3)), Decision(twist=np.array([0, 0, 9.0])), 2.0)
    turn = np.array([s.twist[2] for s in states])
    assert np.diff(turn).max() <= robot.max_turn_acceleration * DT + 1e-12
    assert turn[-1] == pytest.approx(robot.max_turn_rate)
    np.testing.assert_allclose(states[-1].pose[:2], 0.0, atol=1e-12)


def test_reversing_stops_at_the_reverse_limit(robot):
    states = run(robot, at_rest(robot, np.zeros(3)), Decision(twist=np.array([-9.0, 0, 0])), 2.0)
    assert states[-1].twist[0] == pytest.approx(-robot.max_reverse_speed)


def test_who_moves_any_way_is_no_faster_aslant(robot):
    build = robot.model_dump() | {"kinematics": "holonomic"}
    sideways = Robot(**build)
    wanted = Decision(twist=np.array([1.2, 1.2, 0.0]))
    end = run(sideways, at_rest(sideways, np.zeros(3)), wanted, 5.0)[-1]
    assert end.twist[:2] == pytest.approx(np.full(2, robot.max_speed / np.sqrt(2.0)))
    assert end.pose[0] > 1.0
    assert end.pose[1] > 1.0


def test_a_command_that_is_not_a_number_moves_nothing(robot):
    for bad in (np.nan, np.inf, -np.inf):
        order = drive_command(robot, Decision(twist=np.full(3, bad)))
        after = step_drivetrain(robot, at_rest(robot, np.zeros(3)), order, DT)
        np.testing.assert_array_equal(after.pose, 0.0)
