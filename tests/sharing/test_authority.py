"""From the stick to η: when an intent is counted, when it is forgotten, what the stick asks for."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.messages import Observation, RiderCommand, RiderProfile
from cohelm.sharing import (
    AuthorityParameters,
    InputHorizon,
    authority,
    limit_authority,
    stick_twist,
)

TICK = 0.05
N, STEP = 12, 0.1
PLAIN = RiderProfile(dead_zone=0.0)
AHEAD, CENTRE = (0.8, 0.0), (0.0, 0.0)


def observation(time, stick, twist=(0.0, 0.0, 0.0), pose=(0.0, 0.0, 0.0)):
    rider = None if stick is None else RiderCommand(heartbeat=time, deflection=np.array(stick))
    return Observation(
        time=time,
        pose=np.array(pose),
        pose_time=time,
        twist=np.array(twist),
        twist_time=time,
        rider=rider,
    )


@pytest.fixture
def ask(chair):
    """η and all the rest for a stick that was at ``sticks`` tick by tick from tick ``first`` on."""

    def call(sticks, *, first=0, twists=None, profile=PLAIN, tick=TICK, speed_limit=1.0, **changes):
        out, memory = [], None
        for k, stick in enumerate(sticks):
            twist = (*CENTRE, 0.0) if twists is None else twists[k]
            now, memory = authority(
                observation((first + k) * tick, stick, twist),
                profile,
                chair,
                horizon=InputHorizon(steps=N, step=STEP),
                speed_limit=speed_limit,
                memory=memory,
                parameters=AuthorityParameters(**changes),
            )
            out.append(now)
        return out

    return call


# ------------------------------------------------------------------ intent and η


@pytest.mark.parametrize("first", [0, 1, 3, 67, 343, 12345])
def test_a_held_stick_is_one_more_intent_every_sustained_while(ask, first):
    """The push counts, then every 0.25 s (5 ticks); with a frame of 1 s at most 4 are remembered.

    The tick at which the ride begins, and with it the rounding of its times, does not matter.
    """
    hands = ask([AHEAD] * 60, first=first)
    assert [h.intent for h in hands] == [min(1 + k // 5, 4) for k in range(60)]
    for hand, eta in zip(hands[0:20:5], (0.63, 0.86, 0.95, 0.98), strict=True):
        assert hand.eta == pytest.approx(eta, abs=0.005)


@pytest.mark.parametrize(("intents", "eta"), [(0, 0.0), (1, 0.63), (2, 0.86), (3, 0.95)])
def test_eta_is_eq_13_corrected(ask, intents, eta):
    # the third intent of a held stick comes at tick 10
    hand = ask([CENTRE] if intents == 0 else [AHEAD] * (5 * intents - 4))[-1]
    assert hand.intent == intents
    assert hand.eta == 1.0 - math.exp(-intents)
    assert hand.eta == pytest.approx(eta, abs=0.005)


def test_let_go_eta_decays_to_exactly_nothing(ask):
    # held at ticks 0 … 10: intents at 0, 0.25 and 0.5 s, forgotten at 1, 1.25 and 1.5 s
    hands = ask([AHEAD] * 11 + [CENTRE] * 25)
    expected = [3] * 9 + [2] * 5 + [1] * 5 + [0] * 6
    assert [h.intent for h in hands[11:]] == expected
    assert [h.eta for h in hands[30:]] == [0.0] * 6


def test_letting_go_asks_for_nothing_and_pushing_again_is_an_intent(ask):
    hands = ask([AHEAD, AHEAD, CENTRE, CENTRE, AHEAD, AHEAD])
    assert [h.intent for h in hands] == [1, 1, 1, 1, 2, 2]
    assert not hands[2].deflection.any()
    assert not hands[2].twist.any()


@pytest.mark.parametrize(("change", "intents"), [(0.29, 1), (0.31, 2)])
def test_a_change_of_the_stick_is_an_intent_of_its_own(ask, change, intents):
    # change: 0.3 of full deflection
    hands = ask([(0.5, 0.0), (0.5, change)])
    assert [h.intent for h in hands] == [1, intents]


def test_a_slow_change_counts_against_the_last_intent_not_the_last_message(ask):
    # 0.1 a tick: 0.3 away from the push of tick 0 at tick 3, and from that one at tick 6
    sticks = [(0.5, 0.1 * k) for k in range(7)]
    hands = ask(sticks, sustain=5.0)
    assert [h.intent for h in hands] == [1, 1, 1, 2, 2, 2, 3]


def test_counting_messages_is_what_was_printed(ask):
    """A held stick streams 20 messages a second: η is at once nearly 1."""
    hands = ask([AHEAD] * 30, count="messages")
    assert [h.intent for h in hands] == [min(k + 1, 20) for k in range(30)]
    assert hands[4].eta == pytest.approx(1.0 - math.exp(-5))


def test_a_centred_stick_or_none_at_all_has_no_authority(ask):
    for stick in (CENTRE, None):
        hands = ask([stick] * 30)
        assert all(h.eta == 0.0 and h.intent == 0.0 and not h.wants_stop for h in hands)
        assert not any(h.twist.any() for h in hands)


@given(
    st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=1, max_size=50),
    st.integers(0, 10_000),
)
def test_whatever_the_hand_does_the_chair_keeps_a_say(chair, sticks, first):
    memory = None
    for k, stick in enumerate(sticks):
        hand, memory = authority(
            observation((first + k) * TICK, stick),
            RiderProfile(),
            chair,
            horizon=InputHorizon(steps=N, step=STEP),
            speed_limit=1.0,
            memory=memory,
            parameters=AuthorityParameters(),
        )
        assert hand.eta == 1.0 - math.exp(-hand.intent)
        assert 0.0 <= hand.eta < 1.0
        assert len(memory.intents) <= 20  # one a tick within the frame
        assert np.isfinite(hand.states.poses).all()


# ------------------------------------------------------------------ the stick


def test_the_dead_zone_swallows_what_is_inside_and_starts_from_nothing_at_its_edge(ask):
    profile = RiderProfile(dead_zone=0.05)
    for stick, seen in [
        ((0.05, 0.0), (0.0, 0.0)),
        ((0.0, -0.049), (0.0, 0.0)),
        ((0.0501, 0.0), (0.0001 / 0.95, 0.0)),
        ((0.525, 0.0), (0.5, 0.0)),  # (0.525 − 0.05) / 0.95
        ((0.0, -1.0), (0.0, -1.0)),
        ((0.6, 0.8), (0.6, 0.8)),
    ]:
        hand = ask([stick], profile=profile)[0]
        np.testing.assert_allclose(hand.deflection, seen, atol=1e-12)
        assert hand.intent == (1.0 if any(seen) else 0.0)


def test_the_dead_zone_keeps_the_direction(ask):
    hand = ask([(0.3, 0.4)], profile=RiderProfile(dead_zone=0.2))[0]
    # size 0.5 → (0.5 − 0.2) / 0.8 = 0.375
    np.testing.assert_allclose(hand.deflection, [0.375 * 0.6, 0.375 * 0.8])


@pytest.mark.parametrize("tick", [0.01, 0.05, 0.2])
def test_the_tremor_filter_has_its_time_constant_whatever_the_tick(ask, tick):
    tau = 0.4
    profile = RiderProfile(dead_zone=0.0, tremor_filter=tau)
    hands = ask([CENTRE] + [(1.0, 0.0)] * round(2.0 / tick), profile=profile, tick=tick)
    times = tick * np.arange(len(hands))
    np.testing.assert_allclose([h.deflection[0] for h in hands], 1.0 - np.exp(-times / tau))


def test_the_first_message_passes_the_filter_whole(ask):
    hand = ask([(0.4, 0.2)], profile=RiderProfile(dead_zone=0.0, tremor_filter=1.0))[0]
    np.testing.assert_array_equal(hand.deflection, [0.4, 0.2])


def test_an_instant_told_twice_does_not_pass_the_filter(chair, ask):
    profile = RiderProfile(dead_zone=0.0, tremor_filter=0.5)
    arguments = {
        "horizon": InputHorizon(steps=N, step=STEP),
        "speed_limit": 1.0,
        "parameters": AuthorityParameters(),
    }
    _, memory = authority(observation(1.0, CENTRE), profile, chair, memory=None, **arguments)
    hand, _ = authority(observation(1.0, AHEAD), profile, chair, memory=memory, **arguments)
    assert not hand.deflection.any()


def test_a_trembling_hand_is_no_intent_when_filtered(ask):
    """5 Hz, ±0.3: a time constant of 0.5 s leaves 0.3 / √(1 + (2π·5·0.5)²) = 0.02, below 0.05."""
    shake = [(0.0, 0.3 * math.sin(2.0 * math.pi * 5.0 * k * 0.02)) for k in range(200)]
    raw = ask(shake, profile=RiderProfile(), tick=0.02)
    calm = ask(shake, profile=RiderProfile(tremor_filter=0.5), tick=0.02)
    assert max(h.eta for h in raw) > 0.9
    assert max(h.eta for h in calm) == 0.0


def test_a_full_deflection_means_the_limit(chair):
    for stick, speed_limit, twist in [
        ((1.0, 0.0), 10.0, (chair.max_speed, 0.0, 0.0)),
        ((1.0, 0.0), 0.5, (0.5, 0.0, 0.0)),
        ((0.5, 0.0), 0.5, (0.25, 0.0, 0.0)),
        ((-1.0, 0.0), 10.0, (-chair.max_reverse_speed, 0.0, 0.0)),
        ((-1.0, 0.0), 0.1, (-0.1, 0.0, 0.0)),
        ((0.0, 1.0), 0.5, (0.0, 0.0, chair.max_turn_rate)),
        ((0.0, -0.5), 0.5, (0.0, 0.0, -0.5 * chair.max_turn_rate)),
    ]:
        np.testing.assert_allclose(stick_twist(np.array(stick), chair, speed_limit), twist)


# ------------------------------------------------------------------ against the travel

BACK = (-0.6, 0.0)
ROLLING = (0.5, 0.0, 0.0)


@pytest.mark.parametrize("first", [0, 1, 3, 67, 12345])
def test_held_against_the_travel_it_asks_for_a_stop_after_a_while_and_until_let_go(ask, first):
    # stop_time 0.2 s: 4 ticks after the first; the chair stands from tick 8 on
    sticks = [CENTRE] * 2 + [BACK] * 12 + [CENTRE] * 3
    twists = [ROLLING] * 8 + [(0.0, 0.0, 0.0)] * 9
    hands = ask(sticks, twists=twists, first=first)
    assert [h.wants_stop for h in hands] == [False] * 6 + [True] * 8 + [False] * 3


@pytest.mark.parametrize(
    ("stick", "twist"),
    [
        ((-0.4, 0.0), ROLLING),  # not far enough
        ((0.0, 1.0), ROLLING),  # aside
        ((1.0, 0.0), ROLLING),  # with the travel
        (BACK, (0.0, 0.0, 0.0)),  # at rest it asks to go back
        (BACK, (0.02, 0.0, 0.1)),  # as odometry and a turn on the spot say it
        (BACK, (-0.2, 0.0, 0.0)),  # and rolling back it goes with the travel
    ],
)
def test_anything_else_is_no_stop(ask, stick, twist):
    assert not any(h.wants_stop for h in ask([stick] * 40, twists=[twist] * 40))


def test_a_short_pull_is_no_stop(ask):
    sticks = [BACK] * 4 + [CENTRE] + [BACK] * 4
    assert not any(h.wants_stop for h in ask(sticks, twists=[ROLLING] * 9))


# ------------------------------------------------------------------ where it leads


def test_the_riders_states_are_the_rollout_of_the_ramped_stick(chair):
    """From the present twist on, as fast as the chair's accelerations allow; eq. (10) by hand."""
    stick, twist, pose = (1.0, -0.5), (0.4, 0.0, 0.3), (1.0, 2.0, 0.7)
    hand, _ = authority(
        observation(0.0, stick, twist, pose),
        PLAIN,
        chair,
        horizon=InputHorizon(steps=N, step=STEP),
        speed_limit=1.0,
        memory=None,
        parameters=AuthorityParameters(),
    )
    # wanted v = 1.0, ω = −0.5 · 1.2; up by 0.8 m/s², turn by 2.5 rad/s²
    x, y, heading = pose
    v, turn = twist[0], twist[2]
    for k in range(N):
        np.testing.assert_allclose(hand.states.poses[k], [x, y, heading], atol=1e-12)
        v, turn = min(v + 0.8 * STEP, 1.0), max(turn - 2.5 * STEP, -0.6)
        assert hand.states.speeds[k] == pytest.approx(v)
        x, y = x + STEP * v * math.cos(heading), y + STEP * v * math.sin(heading)
        heading += STEP * turn
    np.testing.assert_allclose(hand.states.poses[N], [x, y, heading], atol=1e-12)
    assert hand.states.step == STEP


def test_a_stick_let_go_leads_to_a_stand(ask):
    hand = ask([CENTRE], twists=[(0.5, 0.0, 0.0)])[0]
    # braking with 1 m/s² in steps of 0.1 s: 0.1 · (0.4 + 0.3 + 0.2 + 0.1) = 0.1 m
    np.testing.assert_allclose(hand.states.poses[-1], [0.1, 0.0, 0.0], atol=1e-12)
    assert hand.states.speeds[-1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("left", "share"), [(4.0, 1.0), (1.5, 1.0), (0.75, 0.5), (0.0, 0.0)])
def test_the_end_of_the_way_is_the_chairs(ask, left, share):
    hand = ask([AHEAD])[0]
    led = limit_authority(hand, left, AuthorityParameters(docking_distance=1.5))
    assert led.eta == pytest.approx(share * hand.eta)
    assert led.states is hand.states
    for rounded in (left, left - 1e-12):
        assert (
            limit_authority(hand, rounded, AuthorityParameters(docking_distance=0.0)).eta
            == hand.eta
        )
