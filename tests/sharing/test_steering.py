"""What a stick asks for over the horizon."""

import math

import numpy as np
import pytest

from cohelm.geometry import wrap_angle
from cohelm.messages import Authority, Observation, Reference
from cohelm.robots import load_robot
from cohelm.sharing import InputHorizon, SteeringParameters, rider_intent

HORIZON = InputHorizon(steps=40, step=0.16)
CHAIR = load_robot("quantum_q6_edge")
P = SteeringParameters()


def asked(stick, *, time=0.0, heading=0.0, twist=(0.0, 0.0, 0.0), memory=None, p=P):
    pose = np.array([1.0, 2.0, heading])
    seen = Observation(time=time, pose=pose, twist=np.array(twist), pose_time=time, twist_time=time)
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
