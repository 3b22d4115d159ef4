"""What of a wanted twist reaches the wheels: limits, separation, and reasons for a stop."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.arrays import identical
from cohelm.messages import Mode, Reason
from cohelm.robots.clearance import Clearance
from cohelm.safety import GateParameters, gate, stop
from cohelm.testing.scenes import walkers

from .scenes import request, sound, surroundings, wall_at

EXACT = GateParameters(wall_margin=0.02, wall_margin_time=0.0, reaction=0.15)
CLEARANCE = Clearance(now=0.05)
"""The figures that the distances below are derived for."""
GATED = [Mode.AUTONOMOUS, Mode.SHARED, Mode.ASSISTED, Mode.STOP_ONLY]


@pytest.fixture
def ask(chair):
    """The gate's decision on a wanted (v, ω) of a chair at the origin that drives ahead."""

    def call(wanted, *, speed=0.0, walls=None, people=None, asked=None, parameters=EXACT):
        return gate(
            np.array([wanted[0], 0.0, wanted[1]]) if len(wanted) == 2 else np.array(wanted),
            sound(speed=speed),
            asked or request(),
            chair,
            **surroundings(walls, people),
            clearance=CLEARANCE,
            parameters=parameters,
        )

    return call


# ------------------------------------------------------------------ limits


@pytest.mark.parametrize("mode", list(Mode))
def test_what_the_chair_can_do_on_a_free_floor_goes_through_unchanged(ask, mode):
    for wanted in [(0.8, 0.3), (1.2, 0.0), (-0.3, 0.0), (0.0, -1.2), (0.0, 0.0)]:
        decision = ask(wanted, speed=0.8, asked=request(mode))
        np.testing.assert_array_equal(decision.twist, [wanted[0], 0.0, wanted[1]])
        assert decision.reason is None
        assert not decision.emergency


@pytest.mark.parametrize("mode", list(Mode))
@pytest.mark.parametrize(
    ("wanted", "allowed"),
    [
        ((5.0, 0.0, 0.0), (1.2, 0.0, 0.0)),
        ((-1.0, 0.0, 0.0), (-0.3, 0.0, 0.0)),
        ((0.5, 0.0, 9.0), (0.5, 0.0, 1.2)),
        ((0.0, 0.0, -9.0), (0.0, 0.0, -1.2)),
        ((0.5, 0.4, 0.0), (0.5, 0.0, 0.0)),  # a unicycle does not go sideways
    ],
)
def test_more_than_the_chair_allows_is_bounded_and_said(ask, mode, wanted, allowed):
    decision = ask(wanted, asked=request(mode))
    np.testing.assert_allclose(decision.twist, allowed)
    assert decision.reason is Reason.OVER_LIMITS
    assert not decision.emergency


@pytest.mark.parametrize(
    ("limit", "wanted", "allowed"),
    [
        (0.4, (0.8, 0.4), (0.4, 0.2)),  # the same arc, at half the speed
        (0.4, (0.4, 0.4), (0.4, 0.4)),
        (0.1, (-0.2, 0.1), (-0.1, 0.05)),  # backward as well
        (0.0, (0.8, 0.4), (0.0, 0.0)),
        (0.0, (0.0, 0.4), (0.0, 0.4)),  # a limit of the speed lets it turn
        (-1.0, (0.8, 0.0), (0.0, 0.0)),
        (np.nan, (0.8, 0.0), (0.0, 0.0)),
    ],
)
def test_the_speed_limit_holds_both_ways_and_keeps_the_arc(ask, limit, wanted, allowed):
    decision = ask(wanted, asked=request(speed_limit=limit))
    np.testing.assert_allclose(decision.twist, [allowed[0], 0.0, allowed[1]])
    assert decision.reason is (None if wanted == allowed else Reason.OVER_LIMITS)


@pytest.mark.parametrize("mode", list(Mode))
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("at", range(3))
def test_a_wanted_twist_that_is_no_number_is_an_emergency(ask, mode, bad, at):
    wanted = np.array([0.5, 0.0, 0.1])
    wanted[at] = bad
    decision = ask(wanted, asked=request(mode))
    assert identical(decision, stop(Reason.NOT_FINITE))
    assert decision.emergency


# ------------------------------------------------------------------ separation: walls


def stopping(now, wanted):
    """Way made under a command for 0.15 s and braking from there; steps of 0.05 s, no turning.

    Braking by 1 m/s² within the 0.15 s, speeding up by 0.8; then v² / 2 m.
    """
    way, v = 0.0, now
    for _ in range(3):
        v = min(v + 0.04, wanted) if wanted > v else max(v - 0.05, wanted)
        way += 0.05 * v
    return way + v * v / 2.0


def ahead(chair, gap):
    """A wall across with this much room before the chair's foremost disc."""
    x, _, radius = chair.discs[-1]
    return wall_at(x + radius + gap)


@pytest.mark.parametrize("mode", GATED)
def test_a_wall_inside_the_stopping_distance_slows_the_chair_down(ask, chair, mode):
    # from 0.7 m/s: 0.8 needs 0.116 + 0.32 m; a quarter less, 0.6, needs 0.0925 + 0.18 m
    full, three_quarters = stopping(0.7, 0.8), stopping(0.7, 0.6)
    assert (full, three_quarters) == pytest.approx((0.436, 0.2725))
    free = ask((0.8, 0.2), speed=0.7, walls=ahead(chair, 1.0), asked=request(mode))
    assert free.reason is None
    for gap in (full + 0.02 - 0.01, three_quarters + 0.02 + 0.01):
        slow = ask((0.8, 0.0), speed=0.7, walls=ahead(chair, gap), asked=request(mode))
        assert slow.reason is Reason.TOO_CLOSE
        np.testing.assert_allclose(slow.twist, [0.6, 0.0, 0.0])
        assert not slow.emergency
    whole = ask((0.8, 0.0), speed=0.7, walls=ahead(chair, full + 0.02 + 0.01), asked=request(mode))
    assert whole.reason is None


@pytest.mark.parametrize("mode", GATED)
def test_where_only_standing_still_is_left_it_brakes_and_says_blocked(ask, chair, mode):
    # from 0.3 m/s: a quarter of 0.8 needs 0.0725 − 0.02 m, braking at once 0.06125 − 0.02 m
    assert stopping(0.3, 0.2) == pytest.approx(0.0525)
    assert stopping(0.3, 0.0) == pytest.approx(0.04125)
    blocked = ask((0.8, 0.0), speed=0.3, walls=ahead(chair, 0.067), asked=request(mode))
    np.testing.assert_array_equal(blocked.twist, np.zeros(3))
    assert blocked.reason is Reason.BLOCKED
    assert not blocked.emergency


@pytest.mark.parametrize("mode", GATED)
def test_where_ordinary_braking_comes_too_late_it_brakes_as_hard_as_it_can(ask, chair, mode):
    gap = stopping(0.8, 0.0)  # and nothing for the margin
    blocked = ask((0.8, 0.0), speed=0.8, walls=ahead(chair, gap), asked=request(mode))
    assert identical(blocked, stop(Reason.BLOCKED))
    assert blocked.emergency


def test_where_no_planner_keeps_away_from_walls_a_faster_chair_keeps_wider(ask, chair):
    """At 0.8 m/s by 8 cm, at three quarters of it by 6; the pose is wrong by centimetres."""
    hasty = EXACT.model_copy(update={"wall_margin_time": 0.1})
    full, three_quarters = stopping(0.7, 0.8), stopping(0.7, 0.6)

    def driven(gap, mode):
        asked = {"asked": request(mode), "parameters": hasty}
        return ask((0.8, 0.0), speed=0.7, walls=ahead(chair, gap), **asked).twist[0]

    assert driven(full + 0.02 + 0.08 + 0.01, Mode.ASSISTED) == pytest.approx(0.8)
    assert driven(full + 0.02 + 0.08 - 0.01, Mode.ASSISTED) == pytest.approx(0.6)
    assert driven(three_quarters + 0.02 + 0.06 - 0.01, Mode.ASSISTED) < 0.6
    for mode in (Mode.SHARED, Mode.AUTONOMOUS):
        assert driven(full + 0.02 + 0.01, mode) == pytest.approx(0.8)


def test_a_stick_let_go_in_front_of_a_wall_brakes_as_hard_as_it_must(ask, chair):
    gentle = ask((0.0, 0.0), speed=0.8, walls=ahead(chair, stopping(0.8, 0.0) + 0.03))
    assert gentle.reason is None
    hard = ask((0.0, 0.0), speed=0.8, walls=ahead(chair, stopping(0.8, 0.0)))
    assert identical(hard, stop(Reason.BLOCKED))


def test_of_what_it_lets_through_the_next_larger_share_would_be_too_much(ask, chair):
    for speed in (0.2, 0.5, 0.8, 1.1):
        for gap in np.linspace(0.03, 1.0, 40):
            decision = ask((1.2, 0.0), speed=speed, walls=ahead(chair, gap))
            v = decision.twist[0]
            if not decision.emergency:
                assert stopping(speed, v) + 0.02 <= gap + 1e-4
            if v < 1.2:
                larger = v if decision.emergency else v + 0.3
                assert stopping(speed, larger) + 0.02 >= gap - 1e-4


def test_a_chair_that_stands_at_a_wall_may_leave_it_and_not_push_on(ask, chair):
    at_wall = ahead(chair, 0.005)  # nearer than the margin
    assert ask((-0.3, 0.0), walls=at_wall).reason is None
    on = ask((0.8, 0.0), walls=at_wall)
    assert on.reason is Reason.BLOCKED
    assert not on.twist.any()


def test_the_tail_is_watched_where_the_chair_turns_on_the_spot(ask, chair):
    """A wall beside the chair: its corners would swing out farther than its side is away."""
    side = float(np.abs(chair.outline[:, 1]).max())
    # a wall in y: the field of a wall in x, turned by 90°
    field = wall_at(side + 0.08)
    turned = type(field)(
        distance=field.distance,
        resolution=field.resolution,
        X_MG=np.array([20.0, -20.0, np.pi / 2]),
    )
    assert turned.at(np.zeros(2)) == pytest.approx(side + 0.08, abs=1e-5)
    assert ask((0.5, 0.0), speed=0.5, walls=turned).reason is None
    swung = gate(
        np.array([0.0, 0.0, 1.2]),
        sound(twist=np.array([0.0, 0.0, 1.2])),
        request(),
        chair,
        **surroundings(turned),
        clearance=CLEARANCE,
        parameters=EXACT,
    )
    # how far it swings before it stands: 0.15 s at 1.2 rad/s and more; the side's discs reach out
    assert swung.reason in {Reason.TOO_CLOSE, Reason.BLOCKED}


# ------------------------------------------------------------------ separation: people


def somebody(chair, gap, speed=0.0):
    """A person with this much room before the chair's foremost disc, who walks at ``speed``."""
    x, _, radius = chair.discs[-1]
    return walkers([[x + radius + gap + 0.25, 0.0, speed, 0.0]])


@pytest.mark.parametrize("mode", GATED)
def test_a_person_inside_the_stopping_distance_stops_the_chair(ask, chair, mode):
    asked = request(mode)
    assert ask((0.8, 0.0), speed=0.8, people=somebody(chair, 2.0), asked=asked).reason is None
    near = ask((0.8, 0.0), speed=0.8, people=somebody(chair, 0.4), asked=asked)
    assert near.reason is Reason.TOO_CLOSE
    hit = ask((0.8, 0.0), speed=0.8, people=somebody(chair, 0.2), asked=asked)
    assert hit.reason is Reason.BLOCKED


def test_people_are_met_where_they_will_be(ask, chair):
    """At 0.8 m/s the chair needs 0.44 m and 0.95 s; at −1.2 m/s a person comes 1.14 m meanwhile."""
    assert ask((0.8, 0.0), speed=0.8, people=somebody(chair, 1.2)).reason is None
    coming = ask((0.8, 0.0), speed=0.8, people=somebody(chair, 1.2, speed=-1.2))
    assert coming.reason in {Reason.TOO_CLOSE, Reason.BLOCKED}
    assert ask((0.8, 0.0), speed=0.8, people=somebody(chair, 0.4, speed=1.2)).reason is None


@pytest.mark.parametrize("state", [(-1.2, 0.0, 1.1, 0.0), (-0.35, 1.15, 0.1, -0.6)])
def test_who_follows_or_passes_behind_does_not_stop_a_chair_that_drives_on(ask, state):
    """Braking would bring them closer; ahead of a chair that backs up somebody there counts."""
    assert ask((0.8, 0.0), speed=0.8, people=walkers([state])).reason is None
    assert ask((-0.3, 0.0), speed=-0.3, people=walkers([(-0.9, 0.0, 0.5, 0.0)])).reason is not None


def test_nobody_who_walks_into_a_standing_chair_is_the_chairs_doing(ask, chair):
    still = ask((0.0, 0.0), people=somebody(chair, 0.2, speed=-1.2))
    assert still.reason is None
    assert not still.twist.any()


@pytest.mark.parametrize("way", [(0.8, 0.0), (-0.3, 0.0), (0.0, 1.0)])
def test_whoever_walks_against_the_chair_or_overlaps_it_is_waited_for(ask, chair, way):
    for person in (somebody(chair, 0.0, speed=-0.8), somebody(chair, -0.15)):
        waits = ask(way, people=person)
        assert waits.reason is Reason.BLOCKED
        assert not waits.twist.any()


def test_whoever_stands_at_the_chair_is_not_pushed(ask, chair):
    waits = ask((0.8, 0.0), people=somebody(chair, 0.0))
    assert waits.reason is Reason.BLOCKED
    assert not waits.twist.any()


# ------------------------------------------------------------------ manual


def test_in_manual_mode_the_rider_alone_answers_for_distance(ask, chair):
    asked = request(Mode.MANUAL)
    surrounded = {"walls": ahead(chair, 0.01), "people": somebody(chair, 0.01)}
    decision = ask((0.8, 0.1), speed=0.8, asked=asked, **surrounded)
    np.testing.assert_array_equal(decision.twist, [0.8, 0.0, 0.1])
    assert decision.reason is None
    assert ask((5.0, 0.0), speed=0.8, asked=asked, **surrounded).reason is Reason.OVER_LIMITS
    assert ask((np.nan, 0.0), asked=asked, **surrounded).reason is Reason.NOT_FINITE


def test_separation_may_be_off_for_blind_baselines(ask, chair):
    parameters = GateParameters(separation=False)
    decision = ask((0.8, 0.0), speed=0.8, walls=ahead(chair, 0.01), parameters=parameters)
    assert decision.reason is None
    assert ask((5.0, 0.0), parameters=parameters).reason is Reason.OVER_LIMITS


# ------------------------------------------------------------------ stops

HARD = {
    Reason.NOT_FINITE,
    Reason.CLOCK,
    Reason.STALE_SCAN,
    Reason.STALE_POSE,
    Reason.STALE_TWIST,
    Reason.POSE_JUMP,
    Reason.RIDER_STOP,
    Reason.THERAPIST_STOP,
    Reason.STOP_PRESSED,
    Reason.STICK_BACK,
    Reason.LATE,
    Reason.OVER_LIMITS,
    Reason.TOO_CLOSE,
    Reason.BLOCKED,
    Reason.EDGE_AHEAD,
    Reason.FLOOR_UNSEEN,
    Reason.EDGES_ALLOWED,
    Reason.FELL,
    Reason.NO_DRIVER,
    Reason.CONNECTION_LOST,
    Reason.RELEASE_STICK,
    Reason.CONFIRM,
    Reason.NAVIGATOR_TIMEOUT,
    Reason.NAVIGATOR_RESTARTS,
    Reason.NAVIGATOR_FAILED,
    Reason.PROGRAM_FAILED,
    Reason.COLLISION,
    Reason.PAUSED,
    Reason.STARTING,
    Reason.SCAN_FROZEN,
    Reason.SCAN_IMPLAUSIBLE,
    Reason.SCAN_BLIND,
    Reason.SCAN_PARTLY_BLIND,
    Reason.SCAN_MOTION,
    Reason.ODOMETRY_FAULT,
    Reason.POSE_FAULT,
    Reason.POSE_DOUBTFUL,
    Reason.SENSORS_DISAGREE,
    Reason.LOST,
    Reason.DRIVE_FAULT,
    Reason.DRIVE_WEAK,
}


@pytest.mark.parametrize("reason", list(Reason))
def test_it_brakes_hard_where_the_senses_fail_or_stop_is_pressed_else_gently(reason):
    decision = stop(reason)
    assert not decision.twist.any()
    assert decision.reason is reason
    assert decision.emergency is (reason in HARD)


# ------------------------------------------------------------------ in general

anything = st.floats(allow_nan=True, allow_infinity=True) | st.floats(-2.0, 2.0)


@settings(max_examples=150)
@given(
    wanted=st.tuples(anything, anything, anything),
    twist=st.tuples(st.floats(-0.3, 1.2), st.just(0.0), st.floats(-1.2, 1.2)),
    gap=st.floats(-0.2, 3.0),
    person=st.tuples(st.floats(-2, 3), st.floats(-2, 2), st.floats(-2, 2), st.floats(-2, 2)),
    mode=st.sampled_from(list(Mode)),
    limit=anything,
)
def test_whatever_comes_in_what_goes_out_is_a_number_within_the_limits(
    chair, wanted, twist, gap, person, mode, limit
):
    decision = gate(
        np.array(wanted),
        sound(twist=np.array(twist)),
        request(mode, speed_limit=limit),
        chair,
        **surroundings(ahead(chair, gap), walkers([person])),
        clearance=Clearance(),
        parameters=GateParameters(),
    )
    v, aside, turn = decision.twist
    assert np.isfinite(decision.twist).all()
    assert -chair.max_reverse_speed <= v <= chair.max_speed
    assert aside == 0.0
    assert abs(turn) <= chair.max_turn_rate
    assert abs(v) <= max(0.0, limit) + 1e-12
    changed = not np.allclose(decision.twist, wanted, rtol=0.0, atol=1e-6)
    if decision.reason is None:
        assert not changed
    else:
        assert changed or decision.emergency  # a wanted stop that must be harder
    assert not (decision.emergency and decision.twist.any())
