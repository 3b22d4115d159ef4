"""A computer that is too slow: time runs slower, the chair drives on, and it is said once.

The latency of the navigator is an input of these tests; no clock of this machine is read.
"""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.live.control.step_timing import STEP
from cohelm.live.control.time_rate import MIN_RATE, PROMPT, RISE, STALL, TimeRate
from cohelm.live.control.watchdog import MAX_ANSWER_LATENCY
from cohelm.live.messages import SetGoal, StopCommand
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario

from .rig import Rig


@pytest.fixture(scope="module")
def hall():
    return build_scenario(load_scenario("empty"), 0)


@pytest.fixture
def rig(hall):
    rig = Rig(hall)
    rig.drive()
    return rig


def stopped(states):
    return sum(state.command == (0.0, 0.0) for state in states)


def rate_of(states):
    """Simulated time per real time."""
    return (states[-1].time - states[0].time) / (STEP * (len(states) - 1))


# ------------------------------------------------------------------ the rate


@given(st.lists(st.floats(0.0, 3.0), min_size=1, max_size=60))
def test_the_rate_stays_within_its_bounds_and_rises_no_faster_than_it_may(latencies):
    state, now, before = TimeRate(), 0.0, 1.0
    for latency in latencies:
        now += max(latency, STEP)
        state = state.answered(latency, now)
        assert MIN_RATE <= state.rate <= 1.0
        assert state.rate - before <= RISE * max(latency, STEP) + 1e-9
        before = state.rate


@given(st.floats(PROMPT, STALL))
def test_an_answer_of_any_latency_up_to_a_stall_is_young_in_simulated_time(latency):
    state = TimeRate().answered(latency, 1.0).answered(latency, 1.0 + latency)
    assert latency * state.rate <= MAX_ANSWER_LATENCY


@given(st.floats(MIN_RATE, 1.0))
def test_the_world_advances_as_often_as_the_rate_says(rate):
    state, advanced, now = TimeRate(rate=rate), 0, 0.0
    for _ in range(400):
        now += STEP
        state = state.stepped(STEP, now)
        advanced += state.advances
    assert advanced == pytest.approx(400 * rate, abs=1.0)
    assert state.measured == pytest.approx(rate, abs=0.1)


def test_late_steps_count_as_slow_although_every_one_advances():
    state, now = TimeRate(), 0.0
    for _ in range(100):
        now += 2.0 * STEP
        state = state.stepped(STEP, now)
        assert state.advances
    assert state.measured == pytest.approx(0.5, abs=0.01)
    assert state.slow


# ------------------------------------------------------------------ the chair


@pytest.mark.parametrize("latency", [0.15, 0.2, 0.3, 0.5, 0.8])
def test_a_navigator_that_is_slow_all_the_time_drives_the_chair_without_a_confirmation(
    rig, latency
):
    rig.navigator.takes = latency
    rig.steps(round(3.0 / STEP), 0.6)  # the first late answers may stop it
    states = rig.steps(round(6.0 / STEP), 0.6)
    assert stopped(states) == 0
    assert {state.link for state in states} == {"ready"}
    assert rate_of(states) == pytest.approx(PROMPT / latency, rel=0.25)
    assert states[-1].rate == pytest.approx(rate_of(states), abs=0.1)
    assert states[-1].pose[0] > states[0].pose[0]
    assert [notice.code for notice in rig.of("notice")].count("slow") == 1


def test_a_navigator_that_gets_slower_little_by_little_never_stops_the_chair(rig):
    """From 30 ms to half a second within ten seconds, and back again."""
    rig.say(SetGoal(id=1, point=(11.0, 7.0)))
    rig.steps(40, 0.0)
    states = []
    for share in (*np.linspace(0.0, 1.0, 200), *np.linspace(1.0, 0.0, 200)):
        rig.navigator.takes = 0.03 + 0.47 * share
        states += rig.steps(1, 0.0 if len(states) % 2 == 0 else None)
    assert stopped(states) == 0
    assert min(state.rate for state in states) < 0.4
    falls = [b.rate - a.rate for a, b in itertools.pairwise(states)]
    assert min(falls) > -0.15
    codes = [notice.code for notice in rig.of("notice")]
    assert codes.count("slow") == 1
    rig.navigator.takes = 0.012
    after = rig.steps(100, 0.0)
    assert after[-1].rate == pytest.approx(1.0, abs=0.02)
    assert after[-1].link == "ready"


def test_a_sudden_overload_stops_the_chair_for_less_than_a_second_and_it_goes_on_by_itself(rig):
    rig.steps(20, 0.6)
    rig.navigator.takes = 0.4
    states = rig.steps(round(4.0 / STEP), 0.6)
    assert STEP * stopped(states) <= 1.0
    assert {state.link for state in states} == {"ready"}
    assert stopped(states[-20:]) == 0


@pytest.mark.parametrize("seconds", [0.5, 1.5, 4.0])
def test_after_a_stall_the_chair_goes_on_by_itself(rig, seconds):
    rig.steps(20, 0.6)
    rig.navigator.frozen = True
    states = rig.steps(round(seconds / STEP), 0.6)
    assert all(state.command == (0.0, 0.0) for state in states[4:])
    rig.navigator.frozen = False
    states = rig.steps(40, 0.6)
    assert states[-1].speed > 0.1
    assert {state.link for state in states} == {"ready"}


@pytest.mark.parametrize("latency", [0.3, 0.8])
def test_stop_is_as_quick_as_ever_on_a_slow_computer(rig, latency):
    rig.navigator.takes = latency
    rig.steps(round(4.0 / STEP), 0.6)
    rig.say(StopCommand())
    states = rig.steps(10, 0.6)
    assert stopped(states) == len(states)


def test_no_scan_is_lost_and_none_is_sent_twice_while_time_is_slow(rig):
    rig.navigator.takes = 0.3
    rig.steps(round(8.0 / STEP), 0.6)
    asked = rig.navigator.requests[-15:]
    times = [request.observation.time for request in asked]
    assert all(b > a for a, b in itertools.pairwise(times))
    swept = [scan.time for request in asked for scan in request.observation.scans]
    assert np.diff(swept) == pytest.approx(0.1, abs=1e-6)


def test_speed_rises_no_faster_in_simulated_time(hall):
    rig = Rig(hall, max_acceleration=0.3)
    rig.drive()
    rig.navigator.takes = 0.3
    states = rig.steps(round(8.0 / STEP), 1.0)
    for a, b in itertools.pairwise(states):
        assert b.command[0] - a.command[0] <= 0.3 * STEP + 2e-4
    distance = states[-1].pose[0] - states[0].pose[0]
    time = states[-1].time - states[0].time
    assert distance <= 0.5 * 0.3 * time**2 + 0.05
