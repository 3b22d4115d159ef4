"""Whatever fails, the wheels stand in time and the chair says why; else it does what is asked."""

import itertools
import pickle

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.live.control.driver_link import HEARTBEAT_TIMEOUT
from cohelm.live.control.step_timing import STEP
from cohelm.live.control.time_rate import ABSORBED_LATENESS
from cohelm.live.control.watchdog import CONFIRM_AFTER, MAX_ANSWER_AGE
from cohelm.live.messages import (
    ChangeStorey,
    Heartbeat,
    ReleaseControl,
    ResumeCommand,
    RouteWish,
    SetGoal,
    SetMode,
    SetPace,
    StopCommand,
    TakeControl,
)
from cohelm.messages import Mode
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario

from .rig import Rig

AHEAD = SetGoal(id=1, point=(11.0, 7.0))


@pytest.fixture(scope="module")
def hall():
    return build_scenario(load_scenario("empty"), 0)


@pytest.fixture
def rig(hall):
    rig = Rig(hall)
    rig.drive()
    return rig


def stands(state):
    return state.command == (0.0, 0.0)


def under_way(rig, mode):
    """Drive in a mode until the chair moves."""
    rig.say(SetMode(mode=mode))
    rig.say(AHEAD)
    forward = 0.0 if mode in {Mode.AUTONOMOUS, Mode.SHARED} else 0.8
    assert rig.steps(14, forward)[-1].speed > 0.1
    return forward


# ------------------------------------------------------------------ driving


def test_the_stick_drives_where_no_destination_is_given(rig):
    states = rig.steps(20, 0.8)
    assert states[-1].speed > 0.3
    assert states[-1].rider_authority == 1.0
    assert states[-1].heartbeat == rig.seq
    assert states[-1].reason is None
    assert stands(rig.steps(30, 0.0)[-1])
    assert rig.state.speed == pytest.approx(0.0, abs=0.01)


def test_the_newest_beat_is_at_the_wheels_in_the_same_step(rig):
    rig.steps(10, 0.5)
    rig.beat(0.0)
    state = rig.step()
    assert state.heartbeat == rig.seq
    assert stands(state)


def test_with_a_destination_the_chair_goes_on_by_itself_and_arrives(rig):
    rig.say(SetGoal(id=1, point=(4.0, 7.0)))
    rig.steps(200, 0.0)
    assert [m.code for m in rig.of("notice")] == ["arrived"]
    (ended,) = rig.of("ride_ended")
    assert ended.outcome == "arrived"
    assert ended.length == pytest.approx(2.0, abs=0.2)
    assert rig.state.arrived
    assert rig.state.goal is None
    assert rig.state.ride == ""


def test_a_page_is_told_of_the_route_and_of_what_a_wish_changes(rig):
    rig.say(AHEAD)
    rig.steps(3, 0.0)
    plain = rig.of("route")[-1]
    assert plain.length == pytest.approx(9.0, abs=0.1)
    wish = RouteWish(kind="attract", points=((6.0, 9.0),))
    rig.say(AHEAD.model_copy(update={"id": 2, "wishes": (wish,)}))
    rig.steps(3, 0.0)
    wished = rig.of("route")[-1]
    assert wished.version > plain.version
    assert wished.extra_length > 0.3
    assert wished.wishes[0].points == ((6.0, 9.0),)
    assert rig.state.route_version == wished.version
    assert [m.id for m in rig.of("accepted")] == [1, 2]


def test_speed_rises_no_faster_than_the_therapist_allows(hall):
    rig = Rig(hall, max_acceleration=0.3)
    rig.drive()
    speeds = [state.command[0] for state in rig.steps(30, 1.0)]
    rises = [b - a for a, b in itertools.pairwise([0.0, *speeds])]
    assert max(rises) <= 0.3 * STEP + 2e-4
    assert speeds[-1] > 0.3


def test_the_therapist_bounds_the_speed(hall):
    rig = Rig(hall, max_speed=0.3)
    rig.drive()
    rig.say(SetPace(pace="brisk"))
    assert max(state.command[0] for state in rig.steps(40, 1.0)) == pytest.approx(0.3)


def test_equal_drives_are_equal(hall):
    """Everything but durations comes from the beats, the requests and the seed."""

    def driven():
        rig = Rig(hall)
        rig.drive()
        rig.steps(15, 0.7, 0.1)
        rig.say(AHEAD)
        return rig.steps(15, 0.3)

    assert [s.model_dump() for s in driven()] == [s.model_dump() for s in driven()]


def test_what_was_chosen_while_it_got_ready_is_kept_and_waits_for_a_word(hall):
    rig = Rig(hall)
    rig.cycle.world, rig.navigator.ready = None, False
    rig.say(TakeControl())
    rig.say(AHEAD)
    rig.say(ResumeCommand())
    assert rig.steps(4, 0.0)[-1].reason.code == "starting"
    rig.cycle.enter(rig.new_world())
    rig.beat()
    rig.say(ResumeCommand())  # before it is ready: that was not yet the word
    rig.steps(2, 0.0)
    rig.navigator.ready = True
    states = rig.steps(10, 0.0)
    assert states[-1].goal.x == AHEAD.point[0]
    assert all(stands(state) for state in states)
    assert (states[-1].link, states[-1].reason.code) == ("confirm", "confirm")
    rig.say(ResumeCommand())
    assert rig.steps(14, 0.0)[-1].speed > 0.1


# ------------------------------------------------------------------ nothing moves


@pytest.mark.parametrize("mode", list(Mode))
def test_nothing_moves_while_nobody_drives(hall, mode):
    rig = Rig(hall)
    rig.say(SetMode(mode=mode))
    rig.say(AHEAD)
    states = rig.steps(20, 1.0)
    assert all(stands(state) for state in states)
    assert {state.reason.code for state in states[1:]} == {"no_driver"}
    assert rig.world.truth.pose.tolist() == pytest.approx(hall.start.tolist())


@pytest.mark.parametrize("mode", list(Mode))
def test_nothing_moves_until_the_stick_was_let_go(hall, mode):
    rig = Rig(hall)
    rig.say(SetMode(mode=mode))
    rig.say(TakeControl())
    states = rig.steps(20, 0.9)
    assert all(stands(state) for state in states)
    assert states[-1].reason.code == "release_stick"


@pytest.mark.parametrize("mode", list(Mode))
def test_silence_stops_the_chair_in_every_mode(rig, mode):
    forward = under_way(rig, mode)
    rig.beat(forward)
    rig.step()
    spoken = rig.clock.now
    states = rig.steps(9)
    first = next(k for k, state in enumerate(states) if stands(state))
    assert rig.due - STEP * (9 - first) - spoken <= HEARTBEAT_TIMEOUT + STEP + 1e-6
    assert all(stands(state) for state in states[first:])
    assert states[first].reason.code == "connection_lost"
    assert states[first].link == "no_heartbeat"


@pytest.mark.parametrize("mode", list(Mode))
@pytest.mark.parametrize("what", ["stop", "hidden", "release", "left", "other"])
def test_the_wheels_stand_in_the_very_next_step(rig, mode, what):
    forward = under_way(rig, mode)
    if what == "stop":
        rig.say(StopCommand(), client="whoever")
    elif what == "hidden":
        rig.beat(forward, visible=False)
    elif what == "release":
        rig.say(ReleaseControl())
    elif what == "left":
        rig.commands.disconnect("a")
    else:
        rig.say(TakeControl(), client="b")
    assert stands(rig.step())
    assert all(stands(state) for state in rig.steps(14, forward if what != "left" else None))
    assert rig.world.truth.twist.tolist() == pytest.approx([0.0, 0.0, 0.0], abs=1e-3)


def test_after_stop_a_held_stick_does_not_resume(rig):
    rig.steps(20, 0.8)
    rig.say(StopCommand())
    assert rig.steps(10, 0.8)[-1].link == "stick_held"
    rig.say(ResumeCommand())
    assert stands(rig.steps(4, 0.8)[-1])
    assert rig.of("rejected")[-1].code == "release_stick"
    assert rig.steps(4, 0.0)[-1].link == "confirm"
    rig.say(ResumeCommand())
    rig.steps(2, 0.0)
    assert rig.steps(10, 0.8)[-1].speed > 0.1


def test_one_stop_is_logged_once_however_often_a_page_repeats_it(rig):
    noted = []
    rig.commands._log_event = lambda who, what, **_: noted.append(what)
    for _ in range(3):
        rig.say(StopCommand())
        rig.steps(2, 0.0)
    rig.say(ResumeCommand())
    rig.steps(2, 0.0)
    rig.say(StopCommand())
    rig.steps(2, 0.0)
    assert noted == ["stop_pressed", "resumed", "stop_pressed"]


def test_who_takes_over_is_seen_by_both(rig):
    rig.say(TakeControl(), client="b")
    rig.step()
    assert [m.code for m in rig.of("notice")] == ["control_lost", "control_taken"]
    assert rig.state.driver == "b"


def test_who_takes_over_is_not_moved_by_what_was_decided_before(rig):
    """Between question and wheels another page takes the stick, and holds it in the middle."""
    assert rig.steps(14, 0.8)[-1].speed > 0.1
    answer = rig.navigator.answer

    def meanwhile(timeout, now):
        rig.navigator.answer = answer
        rig.say(TakeControl(), "b")
        rig.beat(0.0, client="b")
        return answer(timeout, now)

    rig.navigator.answer = meanwhile
    rig.beat(0.8)
    state = rig.step()
    assert (state.driver, state.link) == ("b", "ready")
    assert stands(state)


def test_only_who_drives_decides(rig):
    rig.say(SetGoal(id=7, point=(5.0, 7.0)), client="b")
    rig.step()
    assert rig.of("rejected")[-1].code == "not_driver"
    assert rig.state.goal is None


def test_a_place_that_is_not_there_is_refused_in_words(rig):
    rig.say(SetGoal(id=8, place="Nowhere"))
    rig.step()
    assert rig.of("rejected")[-1].id == 8
    assert "Nowhere" in rig.of("rejected")[-1].text


# ------------------------------------------------------------------ the navigator fails


@pytest.mark.parametrize("mode", list(Mode))
def test_a_navigator_that_stands_still_stops_the_chair(rig, mode):
    forward = under_way(rig, mode)
    rig.navigator.frozen, since = True, rig.clock.now
    states = rig.steps(8, forward)
    first = next(k for k, state in enumerate(states) if stands(state))
    assert rig.due - STEP * (8 - first) - since <= MAX_ANSWER_AGE + STEP + 1e-6
    assert states[first].reason.code == "navigator_timeout"
    assert rig.cycle.state.stops == 1


def test_a_navigator_that_was_late_once_goes_on(rig):
    rig.steps(10, 0.8)
    rig.navigator.frozen = True
    rig.steps(6, 0.8)
    rig.navigator.frozen = False
    assert stands(rig.state)
    assert rig.steps(6, 0.8)[-1].speed > 0.0
    assert rig.state.link == "ready"


def test_an_answer_to_what_is_long_past_moves_nothing(rig):
    rig.steps(10, 0.8)
    rig.navigator.frozen = True
    rig.steps(6, 0.8)
    rig.navigator.frozen, rig.navigator.takes = False, 0.1
    assert stands(rig.steps(1, 0.8)[-1])
    assert rig.navigator.answers[-1].decision.twist.any()


def test_who_goes_elsewhere_is_on_another_ride(rig):
    rig.steps(10, 0.8)
    first = rig.state.ride
    rig.say(AHEAD)
    assert rig.steps(6, 0.0)[-1].ride == first
    rig.say(SetGoal(id=2, point=(10.0, 5.0)))
    assert rig.steps(6, 0.0)[-1].ride not in {first, ""}
    assert [m.outcome for m in rig.of("ride_ended")] == ["cancelled"]


def test_after_a_long_silence_of_the_navigator_the_driver_confirms(rig):
    rig.steps(10, 0.8)
    rig.navigator.frozen = True
    rig.steps(round((CONFIRM_AFTER + 0.5) / STEP), 0.8)
    rig.navigator.frozen = False
    states = rig.steps(10, 0.8)
    assert all(stands(state) for state in states)
    assert rig.steps(4, 0.0)[-1].link == "confirm"
    rig.say(ResumeCommand())
    rig.steps(2, 0.0)
    assert rig.steps(10, 0.8)[-1].speed > 0.1


def test_answers_that_take_longer_than_a_step_still_drive(rig):
    """An answer every other step or so is newer than 150 ms, and no sweep is lost on the way."""
    rig.navigator.takes = 0.08
    states = rig.steps(40, 0.8)
    assert states[-1].speed > 0.3
    assert not any(state.reason for state in states[4:])
    asks = rig.navigator.requests[-10:]
    swept = [scan.time for ask in asks for scan in ask.observation.scans]
    assert np.diff(swept) == pytest.approx(0.1, abs=1e-6)  # ten sweeps a second


def test_a_chair_that_itself_was_late_says_so_to_the_navigator(rig):
    rig.steps(9, 0.5)
    rig.beat(0.5)
    rig.clock.now = rig.due + 0.22
    state = rig.step()
    late = 0.22 - ABSORBED_LATENESS
    assert rig.navigator.requests[-1].observation.late == pytest.approx(late, abs=0.01)
    assert state.lateness == pytest.approx(220.0, abs=10.0)
    assert stands(state)
    assert state.reason.code == "late"


@pytest.mark.parametrize("what", ["pose_nan", "scan_nan", "twist_nan"])
def test_what_is_not_a_number_stops_the_chair(what):
    faults = [{"kind": what, "at": 1.0, "duration": 0.5}]
    ride_setup = build_scenario(load_scenario("empty", changes={"faults": faults}), 0)
    rig = Rig(ride_setup)
    rig.drive()
    states = rig.steps(24, 0.8)
    bad = [state for state in states if 1.0 <= state.time < 1.45]
    assert len(bad) >= 8
    assert all(stands(state) for state in bad)
    assert {state.reason.code for state in bad} <= {"not_finite", "stale_scan"}


# ------------------------------------------------------------------ the world


def test_a_collision_is_said_and_the_chair_stands_until_that_is_confirmed(rig):
    rig.say(SetMode(mode=Mode.MANUAL))
    rig.say(SetPace(pace="brisk"))
    rig.steps(2, 0.0)
    rig.steps(60, -1.0)  # two metres of room behind, at 0.3 m/s: the wall after some five seconds
    rig.steps(80, -1.0)
    assert [m.code for m in rig.of("notice")] == ["collision"]
    assert [m.outcome for m in rig.of("ride_ended")] == ["collision"]
    assert stands(rig.state)
    assert rig.steps(2, 0.0)[-1].reason.code == "collision"
    rig.say(ResumeCommand())
    rig.steps(2, 0.0)
    away = rig.steps(20, 1.0)[-1]
    assert away.speed > 0.1
    assert len(rig.of("ride_ended")) == 1


def test_while_time_stands_nothing_moves_and_a_held_stick_does_not_count_after(rig):
    rig.steps(10, 0.8)
    rig.cycle.pause(on=True)
    time = rig.steps(1, 0.8)[-1].time
    states = rig.steps(20, 0.8)
    assert {state.time for state in states} == {time}
    assert {state.reason.code for state in states} == {"paused"}
    rig.cycle.pause(on=False)
    assert rig.steps(6, 0.8)[-1].reason.code == "release_stick"
    rig.steps(2, 0.0)
    assert rig.steps(10, 0.8)[-1].speed > 0.1


def test_while_time_stands_a_wish_has_its_price_and_the_navigator_does_no_step(rig):
    told = []
    rig.cycle._route_preview.set_planning_context = told.append
    rig.steps(4, 0.0)
    rig.cycle.pause(on=True)
    rig.steps(2, 0.0)
    last = rig.navigator.mind._last
    rig.say(AHEAD)
    rig.cycle._route_preview.needs_context = True
    rig.steps(1, 0.0)
    rig.cycle._route_preview.needs_context = False
    assert all(stands(state) for state in rig.steps(4, 0.0))
    (about,) = map(pickle.loads, told)
    assert about.pose.tolist() == pytest.approx(rig.state.pose, abs=0.02)  # as it was measured then
    assert rig.navigator.mind._last is last
    rig.cycle.pause(on=False)
    rig.say(ResumeCommand())
    assert rig.steps(14, 0.0)[-1].speed > 0.1


def test_a_world_that_begins_anew_is_the_same_again(hall, rig):
    rig.say(AHEAD)
    rig.steps(20, 0.0)
    rig.cycle.enter(rig.new_world())
    state = rig.step()
    assert state.time == 0.0
    assert state.goal is None
    assert stands(state)
    assert [m.outcome for m in rig.of("ride_ended")] == ["cancelled"]
    fresh = Rig(hall)
    assert identical(fresh.world.truth, rig.world.truth) or state.time == 0.0


def test_a_ride_is_kept_with_what_was_in_force(rig):
    rig.say(SetGoal(id=1, point=(4.0, 7.0)))
    rig.steps(200, 0.0)
    rig.cycle._rides.navigator_lost()
    ((record, log),) = rig.sessions.kept
    assert record.outcome == "arrived"
    assert record.destination
    assert log is None
    assert record.modes[Mode.SHARED] == pytest.approx(record.duration, abs=0.1)
    assert record.limits[0].limits.max_speed == 1.0


def test_beats_that_lie_about_their_time_do_not_move_the_chair(rig):
    rig.steps(4, 0.0)
    for k in range(20):
        rig.say(Heartbeat(seq=1000 + k, sent=0.0, forward=1.0))
        assert stands(rig.step())


def test_another_storey_is_taken_only_where_the_chair_stands_on_free_floor(hall):
    rig = Rig(hall)
    rig.drive()
    rig.say(SetPace(id=9, pace="slow"))
    rig.steps(20, 0.8)
    rig.say(ChangeStorey(id=2, storey="Level 2"))
    rig.step()
    assert rig.of("rejected")[-1].id == 2
    rig.steps(40, 0.0)
    rig.say(ChangeStorey(id=1, storey="Level 2"), client="b")
    rig.step()
    assert rig.of("rejected")[-1].code == "not_driver"
    for name in ("Level 1", "Level 3", "Roof"):
        rig.say(ChangeStorey(id=3, storey=name))
        rig.step()
        assert rig.of("rejected")[-1].code == "no_storey"
    assert rig.commands.next_storey is None
    rig.say(ChangeStorey(id=4, storey="Level 2"))
    rig.step()
    assert rig.commands.next_storey.name == "Level 2"
    assert (rig.commands.next_storey.mode, rig.commands.next_storey.pace) == (Mode.SHARED, "slow")
    assert rig.commands.next_storey.pose == pytest.approx(rig.state.pose, abs=0.02)  # measured
    assert rig.of("notice")[-1].text == "The map changes to Level 2."


@pytest.mark.parametrize("ends", ["stop", "another driver", "restart"])
def test_edges_are_allowed_until_stop_another_driver_or_a_restart(rig, ends):
    settings = rig.commands._settings
    settings.over_edges_until = rig.clock.now + 20.0
    rig.steps(2, 0.0)
    assert rig.navigator.requests[-1].request.over_edges
    if ends == "stop":
        rig.say(StopCommand(), client="b")
    elif ends == "another driver":
        rig.say(TakeControl(), client="b")
    else:
        rig.cycle.enter(rig.new_world())
    rig.steps(2)
    assert not rig.navigator.requests[-1].request.over_edges
