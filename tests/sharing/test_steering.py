"""What a stick asks for over the horizon."""

import math

import numpy as np
import pytest

from cohelm.geometry import wrap_angle
from cohelm.messages import Authority, Observation, Reference, RiderCommand
from cohelm.robots import load_robot
from cohelm.sharing import InputHorizon, SteeringParameters, rider_intent

HORIZON = InputHorizon(steps=40, step=0.16)
CHAIR = load_robot("quantum_q6_edge")
P = SteeringParameters()


def asked(stick, *, time=0.0, heading=0.0, twist=(0.0, 0.0, 0.0), memory=None, p=P):
    pose = np.array([1.0, 2.0, heading])
    seen = Observation(
        time=time,
        pose=pose,
        twist=np.array(twist),
        pose_time=time,
        twist_time=time,
        rider=RiderCommand(heartbeat=time, deflection=np.array(stick)),
    )
    poses = np.tile(pose, (HORIZON.steps + 1, 1))
    authority = Authority(
        eta=0.0,
        intent=0.0,
        deflection=np.array(stick),
        twist=np.zeros(3),
        states=Reference(step=0.16, poses=poses, speeds=np.zeros(HORIZON.steps + 1)),
        wants_stop=False,
    )
    return rider_intent(
        seen, authority, CHAIR, horizon=HORIZON, speed_limit=0.8, memory=memory, parameters=p
    )


def test_a_push_ahead_leads_straight_on_at_the_speed_of_the_stick():
    intent, _ = asked((0.5, 0.0))
    assert intent.forward
    assert intent.speed == pytest.approx(0.4)
    assert np.allclose(intent.reference.poses[:, 1:], [2.0, 0.0])
    assert intent.reference.speeds[-1] == pytest.approx(0.4)


def test_a_turn_is_meant_for_a_while_and_then_straight_on():
    intent, _ = asked((0.5, 0.5))
    turned = np.abs(np.diff(intent.reference.poses[:, 2]))
    until = math.ceil((P.turn_time + P.turn_fade) / HORIZON.step) + 1
    assert turned[1] > 0.0
    assert np.allclose(turned[until:], 0.0)
    assert 0.2 < intent.reference.poses[-1, 2] < math.pi / 2


@pytest.mark.parametrize("stick", [(0.7, 0.4), (0.3, -0.9), (1.0, 0.1), (0.6, 0.0)])
def test_a_mirrored_stick_asks_for_the_mirrored_motion(stick):
    left, _ = asked(stick)
    right, _ = asked((stick[0], -stick[1]))
    assert np.allclose(left.reference.poses[:, 0], right.reference.poses[:, 0])
    assert np.allclose(left.reference.poses[:, 1] - 2.0, 2.0 - right.reference.poses[:, 1])
    assert np.allclose(left.reference.poses[:, 2], -right.reference.poses[:, 2])


def test_a_chair_that_was_led_aside_comes_back_to_the_direction_of_the_push():
    _, state = asked((0.8, 0.0))
    intent, state = asked((0.8, 0.0), time=0.05, heading=0.6, memory=state)
    end = intent.reference.poses[-1, 2]
    assert abs(wrap_angle(end)) < 0.12
    # what is kept gives way to where the chair goes …
    for tick in range(2, 400):
        intent, state = asked((0.8, 0.0), time=0.05 * tick, heading=0.6, memory=state)
    assert intent.reference.poses[-1, 2] == pytest.approx(0.6, abs=0.01)


def test_a_turn_or_a_released_stick_forgets_the_direction():
    _, kept = asked((0.8, 0.0))
    for stick in ((0.8, 0.9), (0.0, 0.0)):
        _, state = asked(stick, time=0.4, heading=0.5, memory=kept)
        assert math.isnan(state.heading)


def test_a_released_stick_is_no_push_at_once_and_a_pull_never_is():
    _, state = asked((1.0, 0.0))
    released, state = asked((0.0, 0.0), time=0.05, memory=state)
    assert not released.forward
    assert released.speed == 0.0
    assert not state.stick.any()
    assert not asked((-1.0, 0.0))[0].forward
    assert not asked((0.0, 1.0))[0].forward


def test_a_push_that_moves_nothing_squeezes_for_a_while():
    state, told = None, []
    for tick in range(140):
        intent, state = asked((0.6, 0.0), time=0.05 * tick, memory=state)
        told.append(intent.squeezes)
        if told[-1] and tick == 60:
            break
    first = told.index(True) * 0.05
    assert first == pytest.approx(P.stuck_time, abs=0.05)
    moving, state = asked((0.6, 0.0), time=3.05, twist=(0.2, 0.0, 0.0), memory=state)
    assert moving.squeezes  # until it has got through
    later, _ = asked((0.6, 0.0), time=12.0, twist=(0.2, 0.0, 0.0), memory=state)
    assert not later.squeezes


@pytest.mark.parametrize("side", [-1, 1])
def test_a_stick_that_leans_closes_the_other_side(side):
    # The chair was led 0.3 rad aside; a stick that leans that way does not turn it back, once it
    # has passed the low-pass: 0.09 · (1 − exp(−t / 0.25)) / 0.8 > 0.04 rad from 0.15 s on …
    _, state = asked((0.8, 0.0))
    for tick in range(1, 12):
        leaning, state = asked(
            (0.8, side * 0.09), time=0.05 * tick, heading=side * 0.3, memory=state
        )
        if tick > 3:
            assert leaning.lean == side
            assert side * leaning.return_rate >= 0.0
            assert (side * leaning.inputs[:, 1] >= 0.0).all()
    # … and one that leans the other way does.
    _, state = asked((0.8, 0.0))
    for tick in range(1, 12):
        back, state = asked((0.8, -side * 0.09), time=0.05 * tick, heading=side * 0.3, memory=state)
    assert side * back.return_rate < 0.0


def test_an_unsteady_stick_leans_less_and_is_helped_sooner():
    state = None
    for tick in range(80):
        left = 0.25 * math.sin(2.0 * math.pi * 5.0 * 0.05 * tick + 0.3)
        shaky, state = asked((0.7, left), time=0.05 * tick, memory=state)
        assert shaky.lean == 0 or tick < 20  # the unsteadiness must be seen first
    steady, _ = asked((0.7, 0.03))
    assert P.steady_clear_time <= steady.clear_time < shaky.clear_time <= P.clear_time
    assert steady.late_time < shaky.late_time


def test_the_direction_of_a_switch_is_an_interval_kept_in_the_memory():
    state = None
    for tick in range(15):
        intent, state = asked((0.6, 0.0), time=0.05 * tick, memory=state)
    assert state.hand.kind == "one_switch"
    assert state.hand.width == pytest.approx(math.pi / 4)
    assert intent.late_time == 0.0  # "on": the chair finds the way
