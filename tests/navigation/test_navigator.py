"""The pipeline: memory is a value, errors become reasons, program errors propagate."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm import errors
from cohelm.arrays import identical
from cohelm.messages import Mode, Reason, Status, Wish
from cohelm.navigation import Navigator
from cohelm.navigation.recovery.stages import RecoveryStage
from cohelm.testing.conformance import steady

from .scenes import (
    GOAL,
    START,
    TICK,
    UNTIMED,
    Fixed,
    Straight,
    navigator,
    observation,
    request,
    ride,
)

WALKERS = [(5.0, 4.3, 0.25), (7.0, 2.0, 0.25)]


def push(k):
    """Left, from 1 s to 1.5 s."""
    return (0.6, 0.6) if 20 <= k < 30 else (0.0, 0.0)


def walk(k):
    """One who stands near the way, one who crosses it."""
    (x0, y0, r0), (x1, y1, r1) = WALKERS
    return [(x0, y0, r0), (x1, y1 + 0.8 * k * TICK, r1)]


@pytest.fixture(scope="module")
def steered():
    return navigator()


@pytest.fixture(scope="module")
def recorded(steered):
    """2.5 s among people, with a push, a new wish and a spell of bad input."""
    wish = Wish(points=np.array([[6.0, 5.0]]))

    def asked(k):
        return request(wishes=() if k < 35 else (wish,))

    return ride(steered, 50, stick=push, discs=walk, asked=asked)


# ------------------------------------------------------------------ memory is a value


def test_the_recording_is_one_in_which_things_happen(recorded):
    assert recorded[-1].observation.pose[0] > START[0] + 0.5
    assert max(t.authority.eta for t in recorded) > 0.8
    assert max(len(t.people) for t in recorded) >= 1
    assert len({id(t.path) for t in recorded}) > 2


@pytest.mark.parametrize("k", [0, 1, 24, 36])
def test_the_same_in_gives_the_same_out_and_leaves_it_as_it_was(steered, recorded, k):
    last = recorded[k - 1] if k else None
    seen, asked = recorded[k].observation, recorded[k].request

    def step():
        return replace(steered.step(seen, asked, last), durations={})

    again = steady(step, inputs=(seen, asked, last), what="step", within=5.0)
    assert identical(again, recorded[k], ignore=UNTIMED)


def test_a_recorded_ride_replays_tick_by_tick(recorded):
    fresh, last = navigator(), None
    for tick in recorded:
        last = fresh.step(tick.observation, tick.request, last)
        assert identical(last, tick, ignore=UNTIMED)


def test_everything_it_remembers_is_in_the_tick(steered, recorded):
    """Any tick follows from the one before, whatever the navigator was asked in between."""
    for k in np.random.default_rng(0).permutation(np.arange(1, len(recorded)))[:12]:
        tick = steered.step(recorded[k].observation, recorded[k].request, recorded[k - 1])
        assert identical(tick, recorded[k], ignore=UNTIMED)


def test_the_time_of_each_stage_is_booked(recorded):
    stages = {"health", "perception", "social", "ground", "walls"}
    stages |= {"sharing", "planning", "control", "safety"}
    assert all(set(tick.durations) == stages for tick in recorded)
    assert all(spent >= 0.0 for tick in recorded for spent in tick.durations.values())


# ------------------------------------------------------------------ who steers


def test_a_hand_at_rest_in_shared_mode_is_autonomous_bit_for_bit(steered):
    shared = ride(steered, 40, discs=walk)
    alone = ride(
        steered, 40, discs=walk, stick=lambda k: None, asked=lambda k: request(Mode.AUTONOMOUS)
    )
    for one, two in zip(shared, alone, strict=True):
        assert identical(one.decision, two.decision)
        assert identical(one.plan, two.plan)
        assert one.shared is one.reference


def test_in_autonomous_mode_the_stick_moves_nothing_but_a_pull_stops():
    steered = navigator(local_planner=Fixed(), global_planner=Straight())
    autonomous = request(Mode.AUTONOMOUS)
    pushed = ride(steered, 20, stick=lambda k: (0.0, 1.0), asked=lambda k: autonomous)
    assert all(t.shared is t.reference for t in pushed)
    np.testing.assert_array_equal(pushed[-1].decision.twist, [0.5, 0.0, 0.0])
    pulled = ride(steered, 20, stick=lambda k: (-1.0, 0.0), asked=lambda k: autonomous)
    assert pulled[-1].decision.reason is Reason.STICK_BACK


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.ASSISTED])
def test_where_the_rider_alone_drives_the_stick_is_the_twist(mode):
    planner = Fixed()
    steered = navigator(local_planner=planner, global_planner=Straight())
    tick = steered.step(observation(stick=(0.5, 0.0)), request(mode), None)
    # dead zone 0.05: (0.5 − 0.05) / 0.95 of the preferred 0.8 m/s
    np.testing.assert_allclose(tick.decision.twist, [0.8 * 0.45 / 0.95, 0.0, 0.0])
    assert tick.plan is None
    assert not planner.asked
    centred = steered.step(observation(1), request(mode), tick)
    assert not centred.decision.twist.any()
    assert centred.decision.reason is None


def test_the_rider_alone_needs_no_path():
    steered = navigator(
        local_planner=Fixed(),
        global_planner=Straight(errors.NoPath(start=(0, 0), goal=(1, 1), needed=0.3)),
    )
    tick = steered.step(observation(stick=(0.5, 0.0)), request(Mode.ASSISTED), None)
    assert tick.decision.twist[0] > 0.0
    assert tick.decision.reason is None


def test_a_stick_held_against_the_travel_stops_the_chair_until_it_is_let_go():
    steered = navigator(local_planner=Fixed(), global_planner=Straight())

    def pull(k):
        return (-1.0, 0.0) if 10 <= k < 20 else (0.0, 0.0)

    ticks = ride(steered, 25, stick=pull)
    stopped = [t.decision.reason is Reason.STICK_BACK for t in ticks]
    assert stopped == [10 + 4 <= k < 20 for k in range(25)]  # stop_time 0.2 s: 4 ticks
    assert ticks[15].decision.emergency


# ------------------------------------------------------------------ routes


def test_a_new_goal_is_planned_for_at_once_and_the_old_path_kept_till_then():
    planner = Straight()
    steered = navigator(local_planner=Fixed(), global_planner=planner)
    other = np.array([8.0, 6.0])

    def asked(k):
        return request(goal=GOAL if k < 10 else other)

    ticks = ride(steered, 15, asked=asked)
    assert len(planner.asked) == 2
    assert len({id(t.path) for t in ticks[:10]}) == 1
    np.testing.assert_array_equal(ticks[9].path.points[-1], GOAL)
    np.testing.assert_array_equal(ticks[10].path.points[-1], other)


def test_the_same_request_said_again_changes_nothing():
    planner = Straight()
    steered = navigator(local_planner=Fixed(), global_planner=planner)
    ride(steered, 15, asked=lambda k: request(speed_limit=1.0 - 0.01 * k))
    assert len(planner.asked) == 1


def test_what_is_not_in_the_map_reaches_planner_and_gate():
    """A fence of posts across the way, 1.75 m before the feet: too long for a person."""
    fence = [(4.5, 4.0 + 0.15 * k, 0.1) for k in range(-8, 9)]
    local = Fixed(twist=(0.8, 0.0, 0.0))
    planner = Straight()
    steered = navigator(local_planner=local, global_planner=planner)
    ticks = ride(steered, 60, discs=lambda k: fence)
    assert ticks[-1].decision.reason is Reason.BLOCKED
    assert not ticks[-1].decision.twist.any()
    assert 4.0 < ticks[-1].observation.pose[0] + 0.65 < 4.4
    assert local.asked[-1].walls.at(np.array([4.4, 4.0])) < 0.1
    # seen from the second scan on, at 0.1 s; the way is sought anew when it was blocked for 0.7 s
    assert [len(t.path.points) and t.memory.route.planned_at for t in ticks[15:18]] == [
        0.0,
        0.8,
        0.8,
    ]
    assert not planner.asked[0].live.occupied.any()
    assert planner.asked[1].live.occupied.any()


# ------------------------------------------------------------------ trouble is a reason

HERE = {"point": (1.0, 2.0), "clearance": 0.1, "needed": 0.3}
NOT_TO_PLAN = [
    (errors.StartBlocked(**HERE), Reason.START_BLOCKED),
    (errors.GoalBlocked(**HERE), Reason.GOAL_BLOCKED),
    (
        errors.OutsideMap(what="goal", point=(99.0, 0.0), bounds=(0.0, 0.0, 12.0, 8.0)),
        Reason.OUTSIDE_MAP,
    ),
    (errors.NoPath(start=(0.0, 0.0), goal=(1.0, 1.0), needed=0.3), Reason.NO_PATH),
    (errors.NoRoute(start="Foyer", goal="Ward 3", needed=0.7), Reason.PLANNING),
    (errors.GoalBlocked(**HERE, because="a keepout zone"), Reason.KEEPOUT),
    (errors.TooManyWishes(layers=64, most=32), Reason.TOO_MANY_WISHES),
    (errors.InvalidProblem("the clearance is nan"), Reason.INVALID_PROBLEM),
    (errors.PlanningTimeout("too long"), Reason.PLANNING_TIMEOUT),
    (errors.PlanningError("anything"), Reason.PLANNING),
]


@pytest.mark.parametrize(("error", "reason"), NOT_TO_PLAN, ids=lambda x: getattr(x, "code", ""))
def test_without_a_path_the_chair_stands_and_says_why(error, reason):
    steered = navigator(local_planner=Fixed(), global_planner=Straight(error))
    tick = steered.step(observation(), request(), None)
    assert tick.decision.reason is reason
    assert not tick.decision.twist.any()
    assert not tick.decision.emergency
    assert (tick.path, tick.reference, tick.shared, tick.plan) == (None,) * 4


def test_every_planning_error_is_listed_here():
    kinds = [errors.PlanningError]
    for kind in kinds:
        kinds += kind.__subclasses__()
    public = {kind for kind in kinds if not kind.__name__.startswith("_")}
    assert {type(error) for error, _ in NOT_TO_PLAN} == {
        kind for kind in public if kind.__module__ == "cohelm.errors"
    }


@pytest.mark.parametrize("goal", [(100.0, 4.0), (0.02, 4.0)])
def test_a_goal_where_the_chair_cannot_be_is_said_by_the_real_planner(steered, goal):
    tick = steered.step(observation(), request(goal=goal), None)
    expected = Reason.OUTSIDE_MAP if goal[0] > 12 else Reason.GOAL_BLOCKED
    assert tick.decision.reason is expected


def test_when_a_path_is_found_again_it_goes_on():
    planner = Straight(errors.NoPath(start=(0, 0), goal=(1, 1), needed=0.3))
    steered = navigator(local_planner=Fixed(), global_planner=planner)
    tick = steered.step(observation(), request(), None)
    assert tick.decision.reason is Reason.NO_PATH
    planner.error = None
    tick = steered.step(observation(10), request(), tick)  # 0.5 s later
    np.testing.assert_array_equal(tick.decision.twist, [0.5, 0.0, 0.0])


@pytest.mark.parametrize(
    "error", [errors.SolverFailed("no"), errors.Infeasible("no"), errors.ControlError("no")]
)
def test_a_planner_that_finds_no_command_makes_the_chair_brake(error):
    steered = navigator(local_planner=Fixed(error=error), global_planner=Straight())
    tick = steered.step(observation(), request(), None)
    assert tick.decision.reason is Reason.SOLVER_FAILED
    assert not tick.decision.twist.any()
    assert tick.path is not None


def test_a_plan_that_is_a_stop_brings_its_own_command_and_reason():
    braking = Fixed((0.2, 0.0, 0.0), status=Status.STOP, reason=Reason.NO_SAFE_PLAN)
    steered = navigator(local_planner=braking, global_planner=Straight())
    tick = steered.step(observation(twist=(0.25, 0.0, 0.0)), request(), None)
    np.testing.assert_array_equal(tick.decision.twist, [0.2, 0.0, 0.0])
    assert tick.decision.reason is Reason.NO_SAFE_PLAN


@pytest.mark.parametrize("bad", [(np.nan, 0.0, 0.0), (0.0, 0.0, np.inf)])
def test_a_plan_of_no_numbers_does_not_reach_the_wheels(bad):
    steered = navigator(local_planner=Fixed(bad), global_planner=Straight())
    tick = steered.step(observation(), request(), None)
    assert tick.decision.reason is Reason.NOT_FINITE
    assert not tick.decision.twist.any()
    assert tick.decision.emergency


@pytest.mark.parametrize("error", [ZeroDivisionError, ValueError, KeyError, AssertionError])
@pytest.mark.parametrize("part", ["global_planner", "local_planner", "detector"])
def test_a_fault_of_the_program_passes_through(error, part):
    class Broken(Fixed):
        def detect(self, *_):
            raise self.error

    parts = {"global_planner": Straight(), "local_planner": Fixed()}
    parts[part] = Straight(error()) if part == "global_planner" else Broken(error=error())
    steered = navigator(**parts)
    with pytest.raises(error):
        steered.step(observation(), request(), None)


def test_where_the_hand_leads_nowhere_the_chair_finds_its_way_itself():
    """Though the path follows the hand twice a second: a new path is not getting on."""
    planner = Straight()
    stuck = navigator(global_planner=planner, local_planner=Fixed((0.0, 0.0, 0.0)))
    ticks = ride(stuck, 60, stick=lambda k: (0.7, 0.3))
    led = [t for t in ticks if t.recovery.stage is None]
    assert len(planner.asked) == 2  # at first, and 0.5 s on for the hand
    assert led[-1].authority.eta > 0.5
    assert led[-1].observation.time == pytest.approx(stuck.setup.recovery.input_delay, abs=0.2)
    assert all(t.authority.eta == 0.0 for t in ticks if t.recovery.stage is RecoveryStage.CREEP)
    assert ticks[-1].recovery.stage is RecoveryStage.CREEP


def test_a_chair_that_finds_its_way_itself_does_not_set_off_against_a_pull():
    held = navigator(global_planner=Straight(), local_planner=Fixed((0.0, 0.0, 0.0)))
    ticks = ride(held, 40)
    freed = navigator(global_planner=Straight())
    for k in range(40, 50):  # nothing is in the way any more
        seen = observation(k, stick=(-1.0, 0.0))
        ticks.append(freed.step(seen, request(), ticks[-1]))
        assert ticks[-1].recovery.stage is RecoveryStage.CREEP
        # m/s; a limit of jerk lets a speed that has begun fade, and no more
        assert ticks[-1].decision.twist[0] < 0.1
    pushed = freed.step(observation(50, stick=(1.0, 0.0)), request(), ticks[-1])
    assert pushed.authority.eta == 0.0  # a push forwards is no pull


def test_bad_input_stops_before_anything_is_computed_and_nothing_is_forgotten(steered, recorded):
    last = recorded[-1]
    k = len(recorded)
    blind = steered.step(observation(k, last.observation.pose, pose_time=0.0), last.request, last)
    assert blind.decision.reason is Reason.STALE_POSE
    assert not blind.durations
    assert blind.plan is None
    for part in ("perception", "obstacles", "route", "progress", "authority"):
        assert getattr(blind.memory, part) is getattr(last.memory, part)
    assert blind.path is last.path
    assert blind.people is last.people
    again = steered.step(observation(k + 1, last.observation.pose), last.request, blind)
    assert again.path is last.path
    assert again.decision.reason is None


def test_bad_input_from_the_first_tick_on(steered):
    tick = None
    for k in range(3):
        tick = steered.step(observation(k, np.full(3, np.nan)), request(), tick)
        assert tick.decision.reason is Reason.NOT_FINITE
    tick = steered.step(observation(4), request(), tick)
    assert tick.decision.reason is None


def test_stop_pressed_stops_at_once_and_until_it_is_released():
    steered = navigator(local_planner=Fixed(), global_planner=Straight())
    ticks = ride(steered, 20, asked=lambda k: request(stop=5 <= k < 10))
    for k, tick in enumerate(ticks):
        assert (tick.decision.reason is Reason.RIDER_STOP) is (5 <= k < 10)
        assert tick.decision.emergency is (5 <= k < 10)


# ------------------------------------------------------------------ arrival


def test_it_has_arrived_within_the_tolerance_and_stays_a_little_beyond_it():
    steered = navigator(local_planner=Fixed(), global_planner=Straight(), goal_tolerance=0.12)
    last = None
    # away from the goal, whether it has arrived: within 0.12 m, and till 0.24 m once there
    for k, (away, arrived) in enumerate(
        [(0.13, False), (0.11, True), (0.23, True), (0.25, False), (0.13, False)]
    ):
        pose = (GOAL[0] - away, GOAL[1], 0.0)
        last = steered.step(observation(k, pose, (0.11, 0.0, 0.0)), request(), last)
        assert last.arrived is arrived
        assert (last.decision.reason is Reason.ARRIVED) is arrived
        assert (last.decision.twist[0] < 0.5) == arrived  # the planner's command, and less from it
        assert not last.decision.emergency


def test_a_chair_that_comes_hardly_any_nearer_has_arrived_a_little_before():
    steered = navigator(local_planner=Fixed(), global_planner=Straight())
    for away, speed, arrived in [(0.15, 0.09, True), (0.15, 0.11, False), (0.17, 0.0, False)]:
        pose, twist = (GOAL[0] - away, GOAL[1], 0.0), (speed, 0.0, 0.0)
        first = steered.step(observation(0, pose, twist), request(), None)
        assert not first.arrived  # at the start of a ride it has not come from anywhere
        assert steered.step(observation(1, pose, twist), request(), first).arrived is arrived


def test_a_slow_chair_beside_its_goal_has_arrived_where_it_would_have_to_turn_for_it():
    steered = navigator(local_planner=Fixed(), global_planner=Straight())
    for heading, away, arrived in [(1.2, 0.18, True), (0.9, 0.18, False), (3.0, 0.2, False)]:
        pose = (GOAL[0] - away, GOAL[1], heading)
        first = steered.step(observation(0, pose), request(), None)
        assert steered.step(observation(1, pose), request(), first).arrived is arrived


def test_a_new_goal_is_not_arrived_at_for_having_been_at_the_old_one():
    steered = navigator(local_planner=Fixed(), global_planner=Straight(), goal_tolerance=0.12)
    here = (GOAL[0], GOAL[1], 0.0)
    first = steered.step(observation(0, here), request(), None)
    assert first.arrived
    other = request(goal=(GOAL[0] - 0.2, GOAL[1]))  # within twice the tolerance
    assert not steered.step(observation(1, here), other, first).arrived


def test_the_real_parts_arrive(steered):
    near = request(goal=(3.0, 4.2))
    ticks = ride(steered, 120, asked=lambda k: near)
    assert ticks[-1].arrived
    assert not ticks[-1].decision.twist.any()
    away = np.hypot(*(ticks[-1].observation.pose[:2] - near.goal))
    assert away <= steered.setup.goal_tolerance


def test_a_navigator_holds_nothing_that_changes(recorded):
    steered = navigator()
    before = dict(vars(steered))
    ride(steered, 3)
    assert vars(steered) == before
    assert isinstance(steered, Navigator)


def test_a_request_that_there_is_no_path_for_is_asked_again_now_and_then():
    """Twice a second, so that ticks stay cheap; at once where something else is wanted."""
    error = errors.NoPath(start=(0.0, 0.0), goal=(1.0, 1.0), needed=0.3)
    planner = Straight(error)
    steered = navigator(local_planner=Fixed(), global_planner=planner)
    ticks = ride(steered, 25)
    assert len(planner.asked) == 3
    assert all(tick.decision.reason is Reason.NO_PATH for tick in ticks)
    assert all(tick.planning_error == str(error) for tick in ticks)
    other = request(goal=(8.0, 6.0))
    steered.step(observation(25), other, ticks[-1])
    assert len(planner.asked) == 4
    planner.error = None
    found = steered.step(observation(40), request(), ticks[-1])
    assert found.planning_error == ""
    assert found.path is not None
