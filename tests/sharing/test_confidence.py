"""The law of confidence: η of a steady, a trembling and an idle rider beside a chair."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.messages import ChairConfidence, Observation, RiderCommand, RiderProfile
from cohelm.sharing import AuthorityParameters, InputHorizon, authority
from cohelm.sharing.authority import confidence_eta, rider_confidence

P = AuthorityParameters(law="confidence")
SHARES = st.floats(0.0, 1.0)


def eta_of(chair_robot, sticks, chair=1.0):
    memory, out = None, None
    for k, stick in enumerate(sticks):
        time = 0.05 * k
        observation = Observation(
            time=time,
            pose=np.zeros(3),
            pose_time=time,
            twist=np.zeros(3),
            twist_time=time,
            rider=RiderCommand(heartbeat=time, deflection=np.array(stick)),
        )
        out, memory = authority(
            observation,
            RiderProfile(dead_zone=0.0),
            chair_robot,
            horizon=InputHorizon(steps=4, step=0.1),
            speed_limit=1.0,
            memory=memory,
            parameters=P,
            chair=chair,
        )
    return out.eta


def test_a_steady_push_beside_a_sure_chair(chair):
    # r = 1, c = 1: 1 / 1.2
    assert eta_of(chair, [(0.6, 0.2)] * 200) == pytest.approx(1.0 / 1.2, abs=1e-3)


def test_a_chair_that_sees_half_leaves_more_to_the_rider(chair):
    assert eta_of(chair, [(0.6, 0.2)] * 200, chair=0.5) == pytest.approx(1.0 / 1.1, abs=1e-3)


def test_an_erratic_stick_has_less_say_and_an_idle_one_none(chair):
    # ±45° with equal sizes: ‖mean‖ / mean size = cos 45°, so r = 1/2 and η = 0.5 / 0.7
    erratic = [(0.5, 0.5 * (-1) ** k) for k in range(400)]
    assert eta_of(chair, erratic) == pytest.approx(0.5 / 0.7, abs=0.01)
    assert eta_of(chair, [(0.0, 0.0)] * 5) == 0.0


@given(rider=SHARES, more=SHARES, chair=SHARES)
def test_eta_grows_with_the_rider_and_falls_with_the_chair(rider, more, chair):
    eta = confidence_eta(rider, chair, P)
    assert 0.0 <= eta <= 1.0
    assert confidence_eta(max(rider, more), chair, P) >= eta
    assert confidence_eta(rider, max(chair, more), P) <= eta


@given(angle=st.floats(-3.1, 3.1), size=st.floats(0.01, 1.0))
def test_the_riders_confidence_does_not_depend_on_the_direction(angle, size):
    mean = size * np.array([np.cos(angle), np.sin(angle)])
    assert rider_confidence(mean, size, P) == pytest.approx(min(size / 0.3, 1.0))


def test_total_is_the_product():
    assert ChairConfidence().total == 1.0
    assert ChairConfidence(beams=0.5, coverage=0.5, map_agreement=0.8).total == pytest.approx(0.2)
