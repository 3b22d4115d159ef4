"""Disagreement of rider and chair: persistence, release, and the hysteresis of yielding."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.sharing import (
    SteeringParameters,
    YieldingParameters,
    update_yielding,
    with_literal_stick,
)

TICK = 0.05
P = YieldingParameters()


def run(measured, *, memory=None, parameters=P, **changes):
    """State after one call per measured angle."""
    given = {"deflected": True, "stands": False, "docking": 1.0, **changes}
    start = 0.0 if memory is None else memory.time + TICK
    for k, angle in enumerate(measured):
        memory = update_yielding(start + k * TICK, angle, memory, parameters, **given)
    return memory


def test_a_constant_angle_is_reached_with_the_time_constant():
    # 20 updates of 0.05 s after the first call: 0.4 (1 − e⁻¹)
    state = run([0.4] * 21)
    assert state.disagreement == pytest.approx(0.4 * (1.0 - math.exp(-1.0)), rel=1e-9)
    assert state.yields


def test_a_tremor_is_no_disagreement():
    # 5 Hz, ±0.5 rad: the low-pass leaves 0.5 / (2π · 5 Hz · 1 s) = 0.016 rad
    tremor = [0.5 * math.sin(2.0 * math.pi * 5.0 * k * TICK + 0.3) for k in range(400)]
    state = run(tremor)
    assert abs(state.disagreement) < 0.03
    assert not state.yields


def test_it_yields_from_begin_down_to_end():
    above = run([0.11] * 200)  # converged
    assert above.yields
    between = run([0.07] * 200, memory=above)
    assert between.yields
    assert not run([0.04] * 200, memory=between).yields
    assert not run([0.07] * 200).yields


def test_a_released_stick_keeps_the_way_for_a_while():
    led = run([0.5] * 200)
    # 0.5 e^(−t/3) > 0.05 for t < 3 ln 10 = 6.9 s
    assert run([math.nan] * 130, memory=led, deflected=False).yields
    assert not run([math.nan] * 145, memory=led, deflected=False).yields


def test_a_rider_whose_way_leads_nowhere_gets_help_sooner():
    led = run([0.5] * 200)
    # while the chair stands it fades with 1 s instead of 3 s: ln 10 = 2.3 s
    assert not run([math.nan] * 50, memory=led, stands=True).yields
    assert run([math.nan] * 50, memory=led).yields


def test_near_the_goal_it_takes_more():
    assert run([0.2] * 200).yields
    assert not run([0.2] * 200, docking=0.0).yields
    assert run([0.4] * 200, docking=0.0).yields


def test_without_use_and_after_a_gap_it_starts_anew():
    assert not run([0.5] * 200, parameters=YieldingParameters(use=False)).yields
    led = run([0.5] * 200)
    later = update_yielding(led.time + 1.0, 0.5, led, P, deflected=True, stands=False, docking=1.0)
    assert later.disagreement == 0.0


@given(st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=60))
def test_mirrored_angles_mirror_it(angles):
    left, right = run(angles), run([-a for a in angles])
    assert left.disagreement == -right.disagreement
    assert left.yields == right.yields
    assert abs(left.disagreement) <= 0.5  # no angle counts for more


def test_a_chair_that_yields_takes_every_hand_with_literal_stick():
    steering = SteeringParameters()
    led = with_literal_stick(steering, P)
    # a coarse hand waits between both times: they are one
    assert led.clear_time == led.steady_clear_time == steering.steady_clear_time
    assert led.attraction == 0.0
    # never farther from walls than usual help
    assert led.wall_gap == P.wall_gap < steering.wall_gap
    assert with_literal_stick(SteeringParameters(wall_gap=0.0), P).wall_gap == 0.0
    # how far the chair may turn from the stick is not touched
    assert led.max_deviation == steering.max_deviation
