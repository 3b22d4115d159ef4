"""The chair moves only while the link is ready; here a trace tells once more when that is."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.live.control import driver_link
from cohelm.live.control.driver_link import (
    CONFIRM_AFTER_SILENCE,
    HEARTBEAT_TIMEOUT,
    MAX_CONSTANT_STICK,
    MAX_DELAY_MS,
    LinkState,
    RequiredAction,
)
from cohelm.live.messages import Heartbeat
from cohelm.reasons import Reason

DEAD = 0.1


def beat(seq, now, forward=0.0, left=0.0, visible=True, late=0.0):
    sent = 1000.0 * now + 5000.0 - late  # a page's clock begins anywhere
    return Heartbeat(seq=seq, sent=sent, forward=forward, left=left, visible=visible, device="keys")


def after(state, client, seq, now, **given):
    return driver_link.on_heartbeat(state, client, beat(seq, now, **given), now, dead_zone=DEAD)


def driving(now=10.0):
    """Somebody drives, and has let the stick go."""
    return after(driver_link.take_control(LinkState(), "a", under_way=False), "a", 1, now)


# ------------------------------------------------------------------ one after the other


def test_nobody_drives_at_first():
    assert driver_link.status(LinkState(), 0.0) == "no_driver"
    assert driver_link.hold_reason(LinkState(), 0.0) is Reason.NO_DRIVER


def test_who_takes_the_stick_is_silent_until_heard_then_lets_go():
    state = driver_link.take_control(LinkState(), "a", under_way=False)
    assert driver_link.status(state, 10.0) == "no_heartbeat"
    state = after(state, "a", 1, 10.0, forward=0.8)
    assert driver_link.status(state, 10.0) == "centre_stick"
    assert driver_link.deflection(state, 10.0) == (0.0, 0.0)
    state = after(state, "a", 2, 10.1, forward=0.05)
    assert driver_link.status(state, 10.1) == "ready"
    state = after(state, "a", 3, 10.2, forward=0.8, left=-0.2)
    assert driver_link.deflection(state, 10.2) == (0.8, -0.2)
    assert driver_link.current_heartbeat(state, 10.2) == (3, "keys")


def test_a_page_is_silent_after_three_tenths_of_a_second():
    state = driving(10.0)
    assert driver_link.status(state, 10.0 + HEARTBEAT_TIMEOUT - 1e-6) == "ready"
    assert driver_link.status(state, 10.0 + HEARTBEAT_TIMEOUT + 1e-6) == "no_heartbeat"
    assert driver_link.hold_reason(state, 10.4) is Reason.CONNECTION_LOST
    assert driver_link.current_heartbeat(state, 10.4) == (-1, "none")


def test_a_hidden_page_is_silent_at_once():
    state = after(driving(10.0), "a", 2, 10.1, forward=0.8, visible=False)
    assert driver_link.status(state, 10.1) == "no_heartbeat"
    back = after(state, "a", 3, 10.2)
    assert driver_link.status(back, 10.2) == "confirm"
    assert driver_link.hold_reason(back, 10.2) is Reason.CONNECTION_LOST


@pytest.mark.parametrize(
    ("silence", "then"),
    [
        (0.5, "ready"),
        (CONFIRM_AFTER_SILENCE - 0.01, "ready"),
        (CONFIRM_AFTER_SILENCE + 0.01, "confirm"),
        (60.0, "confirm"),
    ],
)
def test_after_a_short_silence_a_centred_stick_suffices(silence, then):
    state = after(driving(10.0), "a", 2, 10.0 + silence, forward=0.6)
    held = {"ready": "centre_stick", "confirm": "stick_held"}[then]
    assert driver_link.status(state, 10.0 + silence) == held
    state = after(state, "a", 3, 10.05 + silence)
    assert driver_link.status(state, 10.05 + silence) == then


def test_after_stop_the_stick_must_be_let_go_and_then_confirmed():
    state = driver_link.stop_until_confirmed(
        after(driving(10.0), "a", 2, 10.1, forward=0.8), Reason.RIDER_STOP
    )
    assert driver_link.status(state, 10.1) == "stick_held"
    assert driver_link.resume(state, "a", 10.1) is state
    state = after(state, "a", 3, 10.2)
    assert driver_link.status(state, 10.2) == "confirm"
    assert driver_link.resume(state, "b", 10.2) is state
    assert driver_link.status(driver_link.resume(state, "a", 10.2), 10.2) == "ready"


def test_a_stick_held_again_before_confirming_is_not_heeded():
    state = driver_link.stop_until_confirmed(driving(10.0), Reason.COLLISION)
    assert driver_link.hold_reason(state, 10.0) is Reason.COLLISION
    state = after(state, "a", 2, 10.1, forward=1.0)
    assert driver_link.status(state, 10.1) == "stick_held"
    assert driver_link.resume(state, "a", 10.1) is state


def test_stop_outlives_whoever_drives():
    state = driver_link.release_control(
        driver_link.stop_until_confirmed(driving(10.0), Reason.RIDER_STOP), "a"
    )
    state = after(driver_link.take_control(state, "b", under_way=False), "b", 1, 10.2)
    assert driver_link.status(state, 10.2) == "confirm"


def test_who_takes_over_a_chair_that_is_under_way_confirms():
    state = after(driver_link.take_control(driving(10.0), "b", under_way=True), "b", 1, 10.1)
    assert state.driver == "b"
    assert driver_link.status(state, 10.1) == "confirm"
    assert driver_link.status(driver_link.resume(state, "b", 10.1), 10.1) == "ready"


def test_the_press_that_sets_off_confirms_where_nobody_drives_and_a_later_stop_holds():
    stopped = driver_link.stop_until_confirmed(LinkState(), Reason.RIDER_STOP)
    taken = driver_link.take_control(stopped, "a", under_way=True, confirmed=True)
    assert driver_link.status(taken, 10.0) == "no_heartbeat"
    assert driver_link.status(after(taken, "a", 1, 10.0, forward=0.8), 10.0) == "centre_stick"
    state = after(taken, "a", 1, 10.0)
    assert driver_link.hold_reason(state, 10.0) is None
    again = after(driver_link.stop_until_confirmed(taken, Reason.RIDER_STOP), "a", 1, 10.0)
    assert driver_link.hold_reason(again, 10.0) is Reason.RIDER_STOP


def test_a_press_confirms_nothing_while_another_drives():
    stopped = driver_link.stop_until_confirmed(driving(10.0), Reason.RIDER_STOP)
    taken = driver_link.take_control(stopped, "b", under_way=False, confirmed=True)
    assert driver_link.status(after(taken, "b", 1, 10.1), 10.1) == "confirm"


def test_who_is_gone_drives_no_more():
    assert driver_link.status(driver_link.disconnect(driving(10.0), "a"), 10.0) == "no_driver"
    assert driver_link.disconnect(driving(10.0), "b").driver == "a"
    assert driver_link.release_control(driving(10.0), "b").driver == "a"


def test_taking_the_stick_again_changes_nothing():
    state = driving(10.0)
    assert driver_link.take_control(state, "a", under_way=True) is state


@pytest.mark.parametrize("seq", [1, 0])
def test_a_repeated_or_reordered_beat_is_dropped(seq):
    state = driving(10.0)
    assert after(state, "a", seq, 10.1, forward=1.0) is state


def test_a_beat_that_comes_late_is_dropped_and_does_not_keep_the_link_alive():
    state = after(driving(10.0), "a", 2, 10.2, forward=1.0, late=MAX_DELAY_MS + 1.0)
    assert driver_link.deflection(state, 10.2) == (0.0, 0.0)
    assert state.heartbeat_at == 10.0
    assert driver_link.status(state, 10.31) == "no_heartbeat"
    punctual = after(driving(10.0), "a", 2, 10.2, forward=1.0, late=MAX_DELAY_MS - 1.0)
    assert driver_link.deflection(punctual, 10.2) == (1.0, 0.0)


def test_clocks_may_drift_apart():
    """50 parts in a million for three hours: 540 ms, and no beat is late."""
    state, now = driving(0.0), 0.0
    for seq in range(2, 2000):
        now += 5.4
        state = after(state, "a", seq, now, late=now * 0.05)
    assert state.heartbeat_at == now


def test_beats_of_others_do_not_count():
    state = after(driving(10.0), "b", 7, 10.1, forward=1.0)
    assert driver_link.deflection(state, 10.1) == (0.0, 0.0)
    assert state.heartbeat_at == 10.0
    assert state.timings["b"].seq == 7


def test_what_a_page_sent_before_it_took_the_stick_cannot_be_sent_again():
    state = after(LinkState(), "a", 5, 10.0, forward=1.0)
    state = driver_link.take_control(state, "a", under_way=False)
    assert after(state, "a", 5, 10.1) is state


def test_after_a_pause_a_held_stick_does_not_count():
    held = after(driving(10.0), "a", 2, 10.1, forward=1.0)
    assert driver_link.status(driver_link.require_centring(held), 10.1) == "centre_stick"
    idle = driving(10.0)
    assert driver_link.require_centring(idle) is idle


# ------------------------------------------------------------------ a stick of the chair itself


def stick(state, at, forward=0.0):
    return driver_link.on_chair_stick(state, (forward, 0.0), at, dead_zone=DEAD)


def driving_with_stick(now=10.0):
    return after(stick(driving(now), now), "a", 2, now)


def test_the_chair_s_stick_drives_under_a_page_that_beats():
    state = stick(driving_with_stick(), 10.1, forward=0.6)
    assert driver_link.deflection(state, 10.1) == (0.6, 0.0)
    assert driver_link.current_heartbeat(state, 10.1) == (2, "joystick")
    assert driver_link.deflection(after(state, "a", 3, 10.2), 10.2) == (0.6, 0.0)


def test_a_stick_that_repeats_its_last_event_for_ever_stops_with_the_page():
    state = stick(driving_with_stick(), 10.1, forward=0.6)
    for k in range(40):
        state = stick(state, 10.1 + 0.05 * k, forward=0.6)
    assert driver_link.status(state, 12.05) == "no_heartbeat"
    assert driver_link.deflection(state, 12.05) == (0.0, 0.0)
    hidden = stick(driving_with_stick(), 10.1, forward=0.6)
    hidden = after(hidden, "a", 3, 10.15, visible=False)
    assert driver_link.status(hidden, 10.15) == "no_heartbeat"


def ridden(state, seconds, forward):
    """The state after a time in which page and stick beat; forward(k): deflection in step k."""
    start, seq = state.chair_stick.at, state.timings["a"].seq
    for k in range(1, round(seconds / 0.05) + 1):
        at = start + 0.05 * k
        state = after(stick(state, at, forward=forward(k)), "a", seq + k, at)
    return state, at


def test_a_stick_that_repeats_its_last_event_for_ever_stops_under_a_page_too():
    held = stick(driving_with_stick(), 10.05, forward=0.6)
    state, now = ridden(held, MAX_CONSTANT_STICK - 0.1, lambda k: 0.6)
    assert driver_link.deflection(state, now) == (0.6, 0.0)
    state, now = ridden(state, 0.3, lambda k: 0.6)
    assert driver_link.status(state, now) == "centre_stick"
    assert driver_link.hold_reason(state, now) is Reason.STICK_STUCK
    assert state.epoch == held.epoch + 1
    state, now = ridden(state, 20.0, lambda k: 0.5 + 0.001 * k)  # back, and not released
    assert driver_link.status(state, now) == "centre_stick"
    state, now = ridden(state, 0.1, lambda k: 0.0)
    assert driver_link.status(state, now) == "ready"


@pytest.mark.parametrize("forward", [lambda k: 0.6 + 0.01 * (k % 200 == 0), lambda k: 0.0])
def test_a_stick_that_moves_a_little_or_rests_is_heeded_for_ever(forward):
    state, now = ridden(driving_with_stick(), 60.0, forward)
    assert driver_link.status(state, now) == "ready"


def test_a_stick_without_a_page_moves_nothing():
    state = stick(LinkState(), 10.0, forward=0.6)
    assert driver_link.status(state, 10.0) == "no_driver"
    assert driver_link.deflection(state, 10.0) == (0.0, 0.0)


def test_a_stick_that_was_held_must_be_released_first():
    state = after(stick(driving(10.0), 10.0, forward=0.6), "a", 2, 10.05)
    assert driver_link.status(state, 10.05) == "centre_stick"
    state = after(stick(state, 10.1), "a", 3, 10.1)
    assert driver_link.status(state, 10.1) == "ready"
    stopped = driver_link.stop_until_confirmed(stick(state, 10.15, forward=0.6), Reason.COLLISION)
    assert driver_link.resume(stopped, "a", 10.15) is stopped
    released = stick(stopped, 10.2)
    assert driver_link.status(driver_link.resume(released, "a", 10.2), 10.2) == "ready"


def test_a_silent_stick_stops_the_chair_and_says_so():
    state = after(stick(driving_with_stick(), 10.1, forward=0.6), "a", 3, 10.2)
    assert driver_link.status(state, 10.1 + HEARTBEAT_TIMEOUT - 1e-6) == "ready"
    assert driver_link.status(state, 10.1 + HEARTBEAT_TIMEOUT + 1e-6) == "no_heartbeat"
    assert driver_link.hold_reason(state, 10.45) is Reason.STALE_RIDER_COMMAND
    back = stick(state, 10.45, forward=0.6)
    assert driver_link.status(back, 10.45) == "centre_stick"
    assert driver_link.status(after(stick(back, 10.5), "a", 4, 10.5), 10.5) == "ready"
    long_ago = after(state, "a", 4, 10.6)
    for k in range(30):
        long_ago = after(long_ago, "a", 5 + k, 10.6 + 0.1 * k)
    assert driver_link.status(stick(long_ago, 13.5), 13.5) == "confirm"


def test_the_page_s_own_stick_wins():
    state = stick(driving_with_stick(), 10.1, forward=0.6)
    assert driver_link.deflection(after(state, "a", 3, 10.1, forward=-0.5), 10.1) == (-0.5, 0.0)


# ------------------------------------------------------------------ whatever happens

CLIENTS = ("a", "b")
LATENESS = (0.0, 100.0, 250.0, 500.0, 1000.0)
"""No two differ by about 300 ms, so that the clocks' drift decides nothing."""
EVENTS = st.lists(
    st.one_of(
        st.tuples(
            st.just("beat"),
            st.sampled_from(CLIENTS),
            st.sampled_from((1, 1, 1, 1, 3, 0, -2)),
            st.sampled_from((0.0, 0.0, 0.05, 0.7, -1.0)),
            st.sampled_from((True, True, True, True, False)),
            st.sampled_from(LATENESS[:1] * 4 + LATENESS),
        ),
        st.tuples(st.just("take"), st.sampled_from(CLIENTS), st.booleans(), st.booleans()),
        st.tuples(st.sampled_from(("release", "left", "resume", "resume")),
                  st.sampled_from(CLIENTS)),
        st.tuples(st.sampled_from(("stop", "held", "recentred"))),
        st.tuples(st.just("wait"), st.sampled_from((0.05, 0.1, 0.1, 0.31, 1.0, 2.5))),
    ),
    max_size=60,
)  # fmt: skip


class Trace:
    """What was heard, put down; when the chair may move follows from the sentences of the rule."""

    def __init__(self):
        self.driver, self.last, self.centred_since, self.confirmed_since = None, None, 0, 0
        self.seqs, self.min_delay = {}, {}
        self.needs_centre, self.needs_confirm = True, False

    def beat(self, client, seq, forward, visible, late, now):
        if seq <= self.seqs.get(client, -math.inf):
            return
        self.seqs[client] = seq
        self.min_delay[client] = min(late, self.min_delay.get(client, math.inf))
        if client != self.driver or late - self.min_delay[client] > 300.0:
            return
        gap = 0.0 if self.last is None else now - self.last[0]
        self.needs_centre |= gap > 0.3
        self.needs_confirm |= gap > 2.0 or not visible
        self.last = (now, forward, visible)
        if abs(forward) <= DEAD and visible:
            self.needs_centre = False

    def resume(self, client, now):
        if client == self.driver and self.alive(now) and abs(self.last[1]) <= DEAD:
            self.needs_confirm = self.needs_centre = False

    def alive(self, now):
        return self.driver is not None and self.last is not None and self.last[2] and (
            now - self.last[0] <= 0.3
        )  # fmt: skip

    def ready(self, now):
        return self.alive(now) and not self.needs_centre and not self.needs_confirm

    def drives(self, client):
        if client != self.driver:
            self.driver, self.last, self.needs_centre = client, None, True


@settings(max_examples=400)
@given(EVENTS)
def test_the_link_is_ready_where_the_rule_says_so_and_nowhere_else(events):
    state, trace, now = LinkState(), Trace(), 100.0
    seqs = dict.fromkeys(CLIENTS, 0)
    for kind, *rest in events:
        if kind == "beat":
            client, step, forward, visible, late = rest
            seqs[client] += step
            state = after(
                state, client, max(seqs[client], 0), now, forward=forward, visible=visible,
                late=late,
            )  # fmt: skip
            trace.beat(client, max(seqs[client], 0), forward, visible, late, now)
        elif kind == "take":
            client, under_way, confirmed = rest
            state = driver_link.take_control(
                state, client, under_way=under_way, confirmed=confirmed
            )
            if confirmed and trace.driver is None:
                trace.needs_confirm = False
            else:
                trace.needs_confirm |= under_way and client != trace.driver
            trace.drives(client)
        elif kind in {"release", "left"}:
            state = (driver_link.release_control if kind == "release" else driver_link.disconnect)(
                state, rest[0]
            )
            if rest[0] == trace.driver:
                trace.drives(None)
            if kind == "left":
                trace.seqs.pop(rest[0], None)
                trace.min_delay.pop(rest[0], None)
                seqs[rest[0]] = 0
        elif kind == "resume":
            state = driver_link.resume(state, rest[0], now)
            trace.resume(rest[0], now)
        elif kind in {"stop", "held"}:
            state = driver_link.stop_until_confirmed(
                state, Reason.RIDER_STOP if kind == "stop" else Reason.COLLISION
            )
            trace.needs_confirm = True
        elif kind == "recentred":
            state = driver_link.require_centring(state)
            centred = trace.last is not None and abs(trace.last[1]) <= DEAD
            trace.needs_centre |= not centred
        else:
            now += rest[0]
        ready = driver_link.status(state, now) == "ready"
        assert ready == trace.ready(now)
        assert (driver_link.hold_reason(state, now) is None) == ready
        if not ready:
            assert driver_link.deflection(state, now) == (0.0, 0.0)


@given(st.sampled_from(list(RequiredAction)), st.booleans(), st.floats(0.0, 3.0))
def test_time_alone_never_makes_a_link_ready(need, centred, wait):
    state = replace(driving(10.0), required=need, centred=centred)
    if driver_link.status(state, 10.0) != "ready":
        assert driver_link.status(state, 10.0 + wait) != "ready"
