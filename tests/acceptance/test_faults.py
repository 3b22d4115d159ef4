"""Each row of the gate, injected in a ride: the reaction, its reason, and wheels that stand."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cohelm.control import LocalProblem
from cohelm.messages import LocalPlan, Reason
from cohelm.safety import GateParameters

from .rides import follow, stage

LIMITS = GateParameters()
TICK = 0.05
AT, LASTING = 2.0, 2.0
SPEED = 0.5
"""Of the ride; from it the chair stands, but for the lag of its drive, 0.28 s after it begins to
brake with 1.8 m/s², or 0.5 s with 1.0 m/s²."""
HARD, GENTLE = 0.5, 0.75
"""Times to a stand with the lag (0.08 s) and a tick to get to the wheels, s."""

NOW = [
    ("scan_nan", Reason.NOT_FINITE),
    ("pose_nan", Reason.NOT_FINITE),
    ("twist_nan", Reason.NOT_FINITE),
    ("rider_nan", Reason.NOT_FINITE),
    ("pose_jump", Reason.POSE_JUMP),
    ("late", Reason.LATE),
    ("clock_backwards", Reason.CLOCK),
]
SILENT = [
    ("scan_silent", Reason.STALE_SCAN, LIMITS.scan_limit),
    ("pose_silent", Reason.STALE_POSE, LIMITS.pose_limit),
    ("twist_silent", Reason.STALE_TWIST, LIMITS.twist_limit),
    ("rider_silent", Reason.STALE_RIDER_COMMAND, LIMITS.rider_limit),
]


@cache
def with_fault(kind):
    fault = f"faults=[{{kind: {kind}, at: {AT}, duration: {LASTING}}}]"
    made = stage("empty", fault, "rider=idle", f"profile={{preferred_speed: {SPEED}}}")
    return follow(made, AT + LASTING + 2.0)


def heard(tick):
    """When each sender was last heard as of this tick's observation, s."""
    o = tick.observation
    return {"pose": o.pose_time, "twist": o.twist_time, "rider": o.rider.heartbeat}


def first(log, reason):
    return log.time[log.reasons.index(reason)]


def stands(log, time):
    """Whether the wheels stand still at ``time``."""
    v, _, turn = np.abs(log.twist[round(time / TICK)])
    return v < 0.02 and turn < 0.05


@pytest.mark.parametrize(("kind", "reason"), NOW)
def test_what_cannot_be_believed_stops_the_chair_in_the_same_tick(kind, reason):
    log = with_fault(kind)
    reasons = {reason, Reason.STALE_SCAN} if kind == "scan_nan" else {reason}  # between two scans
    before = log.time < AT - 1e-9
    assert set(np.array(log.reasons)[before]) == {None}
    assert log.twist[round(AT / TICK), 0] == pytest.approx(SPEED, abs=0.05)
    assert first(log, reason) == pytest.approx(AT)
    # nothing is sent to the wheels from then on: as long as it lasts, or as a jump is held
    lasts = LIMITS.jump_hold if kind == "pose_jump" else LASTING
    if kind == "clock_backwards":
        lasts = 0.95  # the clock went back by 1 s, and then catches up with the tick before
    during = (log.time > AT - 1e-9) & (log.time < AT + lasts - 1e-9)
    assert not log.command[during].any()
    assert {r for r, d in zip(log.reasons, during, strict=True) if d} == reasons
    assert stands(log, AT + HARD)
    assert log.ticks[round(AT / TICK)].decision.emergency


@pytest.mark.parametrize(("kind", "reason", "limit"), SILENT)
def test_who_falls_silent_stops_the_chair_within_a_tick_of_the_limit(kind, reason, limit):
    log = with_fault(kind)
    sender = kind.partition("_")[0]
    last = 1.9 if sender == "scan" else heard(log.ticks[round(AT / TICK)])[sender]
    assert last == pytest.approx(1.9 if sender == "scan" else AT - TICK)  # scans come at 10 Hz
    reaction = first(log, reason)
    assert last + limit < reaction <= last + limit + TICK + 1e-6
    assert set(np.array(log.reasons)[log.time < reaction - 1e-9]) == {None}
    during = (log.time > reaction - 1e-9) & (log.time < AT + LASTING - 1e-9)
    assert not log.command[during].any()
    assert {r for r, d in zip(log.reasons, during, strict=True) if d} == {reason}
    gentle = reason is Reason.STALE_RIDER_COMMAND
    assert stands(log, reaction + (GENTLE if gentle else HARD))
    assert log.ticks[round(reaction / TICK)].decision.emergency is not gentle


@pytest.mark.parametrize("kind", [kind for kind, *_ in NOW + SILENT])
def test_when_it_is_over_the_ride_goes_on(kind):
    log = with_fault(kind)
    assert log.twist[-1, 0] > 0.4
    assert log.reasons[-1] is None
    assert not any(truth.hit_wall for truth in log.truths)


def test_stop_pressed_stops_in_the_same_tick_and_till_it_is_released():
    made = stage("empty", f"profile={{preferred_speed: {SPEED}}}")

    def asked(time):
        return replace(made.request, stop=AT - 1e-9 < time < AT + 1.0 - 1e-9)

    log = follow(made, 5.0, asked)
    pressed = (log.time > AT - 1e-9) & (log.time < AT + 1.0 - 1e-9)
    assert [r is Reason.RIDER_STOP for r in log.reasons] == pressed.tolist()
    assert stands(log, AT + HARD)
    assert log.twist[-1, 0] > 0.4


def test_a_stick_held_against_the_travel_stops_the_chair():
    rider = f"rider={{use: nudge, at: {AT}, duration: 1.5, forward: -1.0, lateral: 0.0}}"
    log = follow(stage("empty", rider, f"profile={{preferred_speed: {SPEED}}}"), AT + 1.5)
    # held for 0.2 s
    assert first(log, Reason.STICK_BACK) == pytest.approx(AT + 0.2)
    assert stands(log, AT + 0.2 + HARD)


class Greedy:
    """Wants more than any chair can do."""

    steps, step = 10, 0.1

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        return LocalPlan(
            time=problem.time,
            step=self.step,
            command=np.array([9.0, 0.0, 0.0]),
            poses=np.zeros((self.steps + 1, 3)),
            inputs=np.zeros((self.steps, 2)),
            status="ok",
        )


def test_more_than_the_limits_is_bounded_and_driven(chair):
    made = stage("empty")
    greedy = replace(made, navigator=replace(made.navigator, local_planner=Greedy()))
    log = follow(greedy, 2.0)
    assert set(log.reasons) == {Reason.OVER_LIMITS}
    np.testing.assert_allclose(log.command, [[chair.max_speed, 0.0, 0.0]] * len(log.command))
    assert log.twist[:, 0].max() <= chair.max_speed + 1e-9


BOX = "obstacles=[{at: [7, 7], size: [0.6, 3.0]}]"


def test_the_rider_alone_behind_the_gate_is_slowed_and_stopped_before_a_box(chair):
    """The box's face is at 6.7 m; a stick held ahead drives at it with 0.8 m/s, and never hits.

    The discs that stand for the footprint reach beyond the footrests; 0.1 m for the localiser's
    error, the scan's noise and the cells of the obstacle layer.
    """
    made = stage(
        "empty",
        BOX,
        "mode=stop_only",
        "rider={use: nudge, at: 0, duration: 60, forward: 1.0, lateral: 0}",
    )
    log = follow(made, 12.0)
    assert not any(truth.hit_wall for truth in log.truths)
    assert first(log, Reason.TOO_CLOSE) < first(log, Reason.BLOCKED)
    assert log.reasons[-1] is Reason.BLOCKED
    assert stands(log, 12.0)
    x, _, radius = chair.discs[-1]
    beyond = x + radius - chair.outline[:, 0].max() + LIMITS.wall_margin
    assert 0.0 < log.truths[-1].gap_wall < beyond + 0.1
    # it began to slow at its stopping distance, 0.8 · 0.15 + 0.8² / 2 = 0.44 m, and its haste
    slowed = log.truths[log.reasons.index(Reason.TOO_CLOSE)]
    assert slowed.gap_wall == pytest.approx(0.44 + 0.8 * LIMITS.wall_margin_time + beyond, abs=0.1)


def test_the_rider_alone_without_the_gate_can_hit_it():
    made = stage(
        "empty",
        BOX,
        "mode=manual",
        "rider={use: nudge, at: 0, duration: 60, forward: 1.0, lateral: 0}",
    )
    log = follow(made, 12.0)
    assert any(truth.hit_wall for truth in log.truths)
    assert set(log.reasons) == {None}


def test_a_person_who_steps_before_the_rider_alone_is_not_driven_into():
    made = stage(
        "empty",
        "people={pedestrians: [{points: [[7, 7]]}], see_robot: false, jitter: 0}",
        "mode=stop_only",
        "rider={use: nudge, at: 0, duration: 60, forward: 1.0, lateral: 0}",
    )
    log = follow(made, 12.0)
    assert not any(truth.hit_moving.any() for truth in log.truths)
    assert log.reasons[-1] is Reason.BLOCKED


def test_a_rider_who_is_helped_is_led_round_a_person_and_never_into_them():
    made = stage(
        "empty",
        "people={pedestrians: [{points: [[7, 7]]}], see_robot: false, jitter: 0}",
        "mode=assisted",
        "rider={use: nudge, at: 0, duration: 60, forward: 1.0, lateral: 0}",
    )
    log = follow(made, 10.0)
    assert not any(truth.hit_moving.any() for truth in log.truths)
    assert log.truths[-1].pose[0] > 8.0
    assert abs(log.truths[-1].pose[2]) < 0.3  # back in the direction of the push
