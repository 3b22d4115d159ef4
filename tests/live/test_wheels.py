"""Before the wheels: a watchdog that never trusts an old word, and speed that rises gently."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cohelm.live.control.watchdog import MAX_ANSWER_AGE, Watchdog, limit_acceleration
from cohelm.messages import Decision
from cohelm.reasons import Reason

twists = st.tuples(*[st.floats(-1.5, 1.5)] * 3).map(np.array)


def decision(v=0.5, omega=0.2, **given):
    return Decision(twist=np.array([v, 0.0, omega]), **given)


def decided(**given):
    """A decision that came at 10 s."""
    return Watchdog(decision=decision(**given), at=10.0, time=10.0)


def test_nothing_moves_before_the_first_decision():
    command = Watchdog().select_command(10.0, None)
    assert not command.twist.any()
    assert command.reason is Reason.NAVIGATOR_TIMEOUT


@given(st.floats(0.0, 1.0))
def test_a_decision_moves_the_chair_for_150_ms_and_no_longer(age):
    watch = decided()
    command = watch.select_command(10.0 + age, None)
    if age <= MAX_ANSWER_AGE + 1e-6:
        assert command is watch.decision
    else:
        assert not command.twist.any()
        assert command.emergency
        assert command.reason is Reason.NAVIGATOR_TIMEOUT


def test_a_clock_that_is_not_a_number_stops_the_chair():
    assert not decided().select_command(math.nan, None).twist.any()


def test_whatever_holds_the_chair_comes_before_the_navigator():
    command = decided().select_command(10.0, Reason.CONNECTION_LOST)
    assert not command.twist.any()
    assert command.reason is Reason.CONNECTION_LOST


def test_a_twist_that_is_not_a_number_goes_no_further():
    command = decided(v=math.nan).select_command(10.0, None)
    assert not command.twist.any()
    assert command.reason is Reason.NOT_FINITE


@given(twists, twists, st.floats(0.1, 2.0))
def test_speed_never_rises_faster_than_allowed_and_never_more_than_wanted(wanted, before, most):
    out = limit_acceleration(Decision(twist=wanted), before, most, 0.05)
    speed, then = math.hypot(*out.twist[:2]), math.hypot(*before[:2])
    assert speed <= math.hypot(*wanted[:2]) + 1e-12
    assert speed <= then + most * 0.05 + 1e-12


@given(twists, twists)
def test_the_curve_stays_the_same(wanted, before):
    out = limit_acceleration(Decision(twist=wanted), before, 0.5, 0.05)
    assert np.abs(np.cross(out.twist, wanted)).max() < 1e-12
    assert out.twist @ wanted >= 0.0


@given(twists, st.floats(0.0, 1.0))
def test_braking_is_never_limited(before, share):
    wanted = Decision(twist=share * before)
    assert limit_acceleration(wanted, before, 0.1, 0.05) is wanted
    hard = Decision(twist=np.zeros(3), emergency=True)
    assert limit_acceleration(hard, before, 0.1, 0.05) is hard


def test_to_turn_back_the_chair_stands_first():
    """From −0.3 m/s, forwards: 0.5 m/s² for 0.05 s from standing is 0.025 m/s."""
    out = limit_acceleration(decision(v=0.6, omega=0.0), np.array([-0.3, 0.0, 0.0]), 0.5, 0.05)
    assert out.twist[0] == 0.025
