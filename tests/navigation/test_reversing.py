"""Reversing: the driven track, legs of a path, the room to turn, beginning and end."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.geometry import arc_length
from cohelm.messages import Mode, Path, Reason
from cohelm.navigation.recovery.driven_track import (
    TRACK_LENGTH,
    extend_track,
    poses_along,
    poses_backward,
    way_back,
)
from cohelm.navigation.recovery.reversing import (
    ReversingCause,
    ReversingContext,
    update_reversing,
)
from cohelm.navigation.recovery.stages import RecoveryAction, RecoveryStage
from cohelm.navigation.replanning.remaining_path import leg_of, next_leg, turn_to_path
from cohelm.robots import load_robot
from cohelm.robots.turning_room import can_turn, must_turn_elsewhere
from cohelm.testing.scenes import room, walls_of

from .scenes import TICK, Fixed, Straight, navigator, observation, request

CHAIR = load_robot("quantum_q6_edge")
GOAL = np.array([4.0, 0.0])


def driven(poses):
    track = None
    for pose in poses:
        track = extend_track(track, np.array(pose, dtype=float))
    return track


def straight(end, step=0.04):
    return [(x, 0.0, 0.0) for x in np.arange(0.0, end + 1e-9, step)]


def context(**changes):
    """A chair whose path leads 5 m backwards."""
    plain = ReversingContext(time=10.0, goal=GOAL, backward=True, way_back=5.0)
    return replace(plain, **changes)


# ------------------------------------------------------------------ the driven track


def test_the_track_is_evenly_spaced_and_bounded():
    track = driven(straight(15.0))
    gaps = np.diff(track[:, 0])
    assert gaps.min() >= 0.1 - 1e-9
    assert gaps.max() < 0.15
    assert np.ptp(track[:, 0]) <= 1.5 * TRACK_LENGTH
    assert len(track) == round(TRACK_LENGTH / 0.1)


def test_backing_over_the_track_removes_it():
    poses = straight(3.0)
    track = driven([*poses, *reversed(poses[25:])])
    assert track[-1, 0] == pytest.approx(1.0, abs=0.15)


def test_a_chair_that_stands_keeps_the_same_track():
    track = driven(straight(1.0))
    assert extend_track(track, track[-1] + np.array([0.01, 0.01, 0.02])) is track


def test_after_a_jump_of_the_pose_the_track_begins_again():
    assert len(extend_track(driven(straight(1.0)), np.array([5.0, 0.0, 0.0]))) == 1


def test_the_way_back_begins_at_the_chair_and_joins_the_track():
    pose = np.array([3.05, 0.1, 0.1])
    back = way_back(driven(straight(3.0)), pose, 2.0)
    assert back[0] == pytest.approx(pose)
    assert np.diff(back[:, 0]).max() < 0.0
    assert back[2:, 1] == pytest.approx(0.0)
    assert poses_along(back, np.array([0.0, 1.0]))[1, 0] == pytest.approx(2.05, abs=0.02)


def test_the_way_back_follows_a_bend_in_which_the_chair_still_stands():
    """On an arc of 0.5 m radius the heading turns by 0.8 rad in 0.4 m, which is no pivot."""
    angle = np.arange(0.0, 1.2, 0.05)
    bend = zip(2.0 + 0.5 * np.sin(angle), 0.5 * (1.0 - np.cos(angle)), angle, strict=True)
    poses = [*straight(2.0), *bend]
    back = way_back(driven(poses), np.array(poses[-1]), 10.0)
    assert arc_length(back[:, :2])[-1] == pytest.approx(2.0 + 0.5 * 1.2, abs=0.15)


def test_the_way_back_ends_where_the_chair_turned_on_the_spot():
    first = [(0.0, y, math.pi / 2) for y in np.arange(-2.0, 0.0, 0.05)]
    back = way_back(driven([*first, *straight(2.0)]), np.array([2.0, 0.0, 0.0]), 10.0)
    assert back[:, 0].min() == pytest.approx(0.0, abs=0.15)
    assert np.abs(back[:, 1]).max() < 0.15


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_way_back_is_continuous_wherever_the_chair_drove(seed):
    rng = np.random.default_rng(seed)
    pose, poses = np.zeros(3), []
    for _ in range(200):
        speed, turn = rng.uniform(-0.2, 0.8), rng.uniform(-1.2, 1.2)
        pose = pose + 0.05 * np.array([speed * np.cos(pose[2]), speed * np.sin(pose[2]), turn])
        poses.append(pose)
    back = way_back(driven(poses), pose, 3.0)
    assert back[0] == pytest.approx(pose)
    assert np.abs(np.diff(back[:, 2])).max(initial=0.0) <= 0.6
    assert np.hypot(*np.diff(back[:, :2], axis=0).T).max(initial=0.0) <= 0.61


# ------------------------------------------------------------------ room to turn


@pytest.mark.parametrize(("width", "fits"), [(1.2, False), (1.5, False), (1.75, True), (3.0, True)])
def test_a_half_turn_needs_the_length_of_the_chair(width, fits):
    """The discs of the footprint reach 0.79 m from the axle, its corners 0.72 m."""
    half = 0.5 * width
    walls = walls_of(room(boxes=[(0.0, 0.0, 12.0, 4.0 - half), (0.0, 4.0 + half, 12.0, 8.0)]))
    pose = np.array([6.0, 4.0, 0.0])
    assert can_turn(CHAIR, pose, math.pi, walls, margin=0.02) is fits
    assert can_turn(CHAIR, pose, 0.02, walls, margin=0.02)


def test_the_other_direction_of_turn_counts_as_well():
    walls = walls_of(room(boxes=[(0.0, 0.0, 12.0, 3.5)]))
    pose = np.array([6.0, 4.0, 0.0])  # 0.5 m to the wall on its right
    assert not can_turn(CHAIR, pose, -math.pi, walls, margin=0.02)  # the rear swings as well
    assert can_turn(CHAIR, pose + np.array([0.0, 0.3, 0.0]), -math.pi, walls, margin=0.02)


def test_the_longer_way_round_counts_for_about_half_a_turn_alone():
    """A pillar is to the right of the front: only a turn that is as far avoids it."""
    pose = np.array([6.0, 4.0, 0.0])

    def fits(degrees):
        walls = walls_of(room(boxes=[(6.55, 3.3, 6.75, 3.5)]))
        return can_turn(CHAIR, pose, math.radians(degrees), walls, margin=0.02)

    assert [fits(each) for each in (-100.0, 100.0, -170.0, 180.0)] == [False, True, True, True]


@pytest.mark.parametrize(
    ("half", "turn", "elsewhere"),
    [(0.6, math.pi, True), (0.6, 1.0, False), (2.0, math.pi, False), (2.0, 1.5, False)],
)
def test_a_path_behind_is_turned_to_elsewhere_only_in_a_corridor(half, turn, elsewhere):
    walls = walls_of(room(boxes=[(0.0, 0.0, 12.0, 4.0 - half), (0.0, 4.0 + half, 12.0, 8.0)]))
    assert must_turn_elsewhere(CHAIR, np.array([6.0, 4.0, 0.0]), turn, walls) is elsewhere


def test_the_turn_to_a_path_is_that_to_half_a_metre_ahead_or_to_the_goal():
    line = np.array([[2.0, 4.0], [9.0, 4.0]])
    path = Path(
        points=line, length=7.0, cost=7.0, without_wishes=line, method="straight", wishes=()
    )
    goal = line[-1]
    behind = np.array([6.0, 4.0, math.pi])
    assert abs(turn_to_path(behind, path, 4.0, goal)) == pytest.approx(math.pi)
    aside = np.array([6.0, 3.5, 0.0])
    assert turn_to_path(aside, path, 4.0, goal) == pytest.approx(math.pi / 4.0)
    assert turn_to_path(aside, path, 6.9, np.array([6.0, 4.0])) == pytest.approx(math.pi / 2.0)


# ------------------------------------------------------------------ beginning and end


JAM = {"backward": False, "jammed": True, "has_room": False}


def test_a_leg_backwards_is_driven_until_it_ends():
    state = update_reversing(context(), None, patience=8.0)
    assert state.cause is ReversingCause.LEG
    assert update_reversing(context(way_back=0.05), state, patience=8.0).active
    assert not update_reversing(context(backward=False), state, patience=8.0).active
    assert not update_reversing(context(allowed=False), None, patience=8.0).active


def test_a_chair_that_stands_on_a_leg_plans_anew_from_there_and_at_last_asks():
    state, given_up = None, []
    for k in range(400):
        now = context(time=0.05 * k, stands=True, clearance=0.4)
        state = update_reversing(now, state, patience=8.0)
        given_up += [state.ended_at] if state.ended_at == now.time else []
    # 1.5 s each, and a tick to begin again
    assert given_up == pytest.approx([1.55, 3.15, 4.75, 6.35], abs=0.11)
    assert not state.active
    drives = context(time=30.0, stands=False, clearance=0.4)
    begun = update_reversing(drives, None, patience=8.0)
    assert update_reversing(drives, begun, patience=8.0).active


def test_a_jam_is_left_backwards_to_a_place_where_the_chair_can_turn_about():
    jam = context(**JAM)
    state = update_reversing(jam, None, patience=8.0)
    assert state.cause is ReversingCause.JAM
    assert update_reversing(replace(jam, jammed=False), state, patience=8.0).active
    ended = update_reversing(replace(jam, has_room=True, time=12.0), state, patience=8.0)
    assert (ended.active, ended.ended_at) == (False, 12.0)
    for changes in ({"has_room": True}, {"way_back": 0.2}, {"clearance": 0.05}):
        assert not update_reversing(replace(jam, **changes), None, patience=8.0).active


def test_a_blocked_way_back_is_waited_for_and_then_left_to_the_recovery():
    state, active = None, []
    for k in range(400):
        now = context(time=0.05 * k, clearance=0.0)
        state = update_reversing(now, state, patience=8.0)
        active.append(state.active)
    changes = np.flatnonzero(np.diff(active)) * 0.05
    assert active[0]
    assert changes[:2] == pytest.approx([8.0, 13.0], abs=0.11)


class Behind(Straight):
    """A straight line that is driven backwards, if the robot has a reverse gear."""

    def plan(self, problem):
        return replace(super().plan(problem), backs_out=problem.robot.max_reverse_speed > 0.0)


def stages_of_standing_chair(seconds, robot, **seen):
    """Recovery stages, and reasons from 1 s on, of a chair before a dead end that never drives."""
    grid = room(boxes=[(0.0, 0.0, 12.0, 3.4), (0.0, 4.6, 12.0, 8.0), (0.0, 0.0, 1.3, 8.0)])
    stands = navigator(
        grid=grid, robot=robot, global_planner=Behind(), local_planner=Fixed((0.0, 0.0, 0.0))
    )
    last, stages, reasons = None, set(), set()
    for k in range(round(seconds / TICK)):
        now = observation(k, (2.0, 4.0, math.pi), **seen)
        last = stands.step(now, request(Mode.AUTONOMOUS), last)
        stages.add(last.recovery.stage if last.recovery else None)
        reasons |= {last.decision.reason} if k * TICK >= 1.0 else set()
    return stages, reasons


def test_a_chair_without_a_way_to_turn_does_not_stand_for_ever():
    """Every two seconds there is a new path, but none helps a chair that cannot drive backwards."""
    robot = CHAIR.model_copy(update={"max_reverse_speed": 0.0})
    stages, _ = stages_of_standing_chair(5.0, robot)
    assert RecoveryStage.WAIT in stages


def test_a_leg_backwards_on_which_the_chair_stands_does_not_last_for_ever():
    stages, reasons = stages_of_standing_chair(13.0, CHAIR)
    assert RecoveryStage.WAIT in stages
    assert None not in reasons


def test_a_chair_that_waits_for_a_person_behind_says_so_all_the_time():
    """Of the eight seconds of patience and the pause until the recovery begins, none is silent."""
    _, reasons = stages_of_standing_chair(11.0, CHAIR, discs=[(2.75, 4.0, 0.2)])
    assert reasons == {Reason.WAITING}


def test_the_attempts_to_leave_jams_are_limited():
    state, begun = None, 0
    for k in range(40):
        was = state is not None and state.active
        now = context(time=float(k), **{**JAM, "has_room": k % 2 == 1})
        state = update_reversing(now, state, patience=8.0)
        begun += state.active and not was
    assert begun == 4
    other = context(time=50.0, goal=np.array([9.0, 0.0]), **JAM)
    assert update_reversing(other, state, patience=8.0).active


def test_the_reason_tells_why_the_chair_backs_up_or_waits():
    action = RecoveryAction(stage=RecoveryStage.REVERSE, reverses=True, turns=True)
    assert action.reason(stands=False) is Reason.REVERSING
    assert replace(action, turns=False).reason(stands=False) is Reason.BACKING_UP
    assert replace(action, reverses=False).reason(stands=True) is Reason.WAITING


# ------------------------------------------------------------------ legs of a path


def in_three_moves():
    """1 m forward, 2 m back, 3 m forward along x."""
    x = np.concatenate(
        [np.arange(0.0, 1.0, 0.1), np.arange(1.0, -1.0, -0.1), np.arange(-1, 2.05, 0.1)]
    )
    line = np.column_stack([x, np.zeros_like(x)])
    return Path(
        points=line,
        length=float(arc_length(line)[-1]),
        cost=6.0,
        method="straight",
        wishes=(),
        without_wishes=line,
        cusps=np.array([10, 30]),
        pivots=np.array([30]),
    )


def test_legs_share_their_ends_and_alternate_in_gear():
    path = in_three_moves()
    legs = [leg_of(path, i) for i in range(3)]
    assert [leg.backward for leg in legs] == [False, True, False]
    assert [leg.is_last for leg in legs] == [False, False, True]
    assert [leg.begin for leg in legs] == pytest.approx([0.0, 1.0, 3.0])
    assert sum(leg.path.length for leg in legs) == pytest.approx(path.length)
    assert [leg.path.pivots.tolist() for leg in legs] == [[], [20], [0]]
    assert leg_of(replace(path, backs_out=True), 0).backward
    plain = replace(path, cusps=np.empty(0, dtype=np.int64))
    assert leg_of(plain, 0).path is plain


def test_the_gear_changes_where_the_chair_stands_at_the_end_of_a_leg():
    path, still, drives = in_three_moves(), np.zeros(3), np.array([0.2, 0.0, 0.0])
    assert next_leg(path, 0, 0.8, still) == 0
    assert next_leg(path, 0, 0.95, drives) == 0
    assert next_leg(path, 0, 0.95, still) == 1
    assert next_leg(path, 2, path.length, still) == 2


def test_poses_on_a_leg_backwards_look_against_it():
    back = poses_backward(leg_of(in_three_moves(), 1).path, np.array([1.0, 0.02, 0.03]), 0.0)
    assert back[0] == pytest.approx([1.0, 0.02, 0.03])
    assert back[-1] == pytest.approx([-1.0, 0.0, 0.0])
    assert np.abs(back[:, 2]).max() < 0.2
