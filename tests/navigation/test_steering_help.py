"""Steering help: the rider gets what they push, unless something is in the way."""

import numpy as np
import pytest

from cohelm.geometry import wrap_angle
from cohelm.messages import Reason

WAYS = ((0.8, 0.0), (0.5, 0.3), (0.9, -0.6), (0.3, 0.9), (0.0, 0.7), (-0.5, 0.0), (-0.4, 0.3))


@pytest.mark.parametrize("stick", WAYS)
def test_in_open_space_the_rider_gets_what_they_push(drive, stick):
    ticks, _ = drive(2.0, lambda t: stick, start=(6.0, 4.0, 0.5))
    for tick in ticks:
        assert tick.plan is None
        assert tick.decision.twist == pytest.approx(tick.authority.twist, abs=1e-9)


def test_a_released_stick_stops_the_chair_gently(drive):
    ticks, truths = drive(4.0, lambda t: (1.0, 0.0) if t < 2.0 else (0.0, 0.0), start=(2.0, 4.0, 0))
    after = [k for k in ticks if k.observation.time >= 2.0]
    assert not any(k.decision.twist.any() or k.decision.emergency for k in after)
    speed = max(t.twist[0] for t in truths)
    assert speed > 0.7
    still = [t.time for t in truths if t.time > 2.0 and abs(t.twist[0]) < 1e-3]
    assert still[0] - 2.0 < speed / 1.0 + 0.6  # at the comfort deceleration, and the jerk


def test_a_box_is_rounded_and_the_direction_of_the_push_kept(drive):
    box = [(6.0, 3.7, 6.6, 4.5)]
    ticks, truths = drive(11.0, lambda t: (0.8, 0.0), boxes=box)
    assert not any(t.hit_wall for t in truths)
    assert truths[-1].pose[0] > 8.0
    assert abs(wrap_angle(truths[-1].pose[2])) < 0.35
    assert any(k.plan is not None for k in ticks)
    assert max(t.twist[0] for t in truths) <= 0.8 * 0.8 + 0.05  # no faster than the stick


def test_the_chair_turns_no_farther_from_the_push_than_allowed(drive):
    boxes = [(5.5, 3.2, 6.0, 5.2), (7.5, 2.0, 8.0, 4.4)]
    ticks, truths = drive(14.0, lambda t: (0.7, 0.25 * np.sin(t)), boxes=boxes)
    planned = [k for k in ticks if k.plan is not None and k.plan.reason is None]
    assert planned
    for tick in planned:
        count = round(2.5 / tick.plan.step) + 1
        off = np.abs(wrap_angle(tick.plan.poses[:count, 2] - tick.shared.poses[:count, 2]))
        assert off.max() <= max(1.05, off[0] + 0.02) + 1e-9
    assert not any(t.hit_wall for t in truths)


def test_a_mirrored_room_is_passed_on_the_mirrored_side(drive):
    boxes = [(6.0, 3.8, 6.6, 5.0)]
    mirrored = [(6.0, 3.0, 6.6, 4.2)]
    one, other = (drive(9.0, lambda t: (0.8, 0.0), boxes=each)[1] for each in (boxes, mirrored))
    ys = [np.array([t.pose[1] for t in truths]) - 4.0 for truths in (one, other)]
    assert np.sign(ys[0][np.abs(ys[0]).argmax()]) == -np.sign(ys[1][np.abs(ys[1]).argmax()])
    assert np.abs(ys[0]).max() == pytest.approx(np.abs(ys[1]).max(), abs=0.15)


@pytest.mark.parametrize(
    ("start", "stick"),
    [
        ((6.0, 0.44, 0.0), (0.6, 0.6)),  # along a wall on the right, driving away
        ((11.18, 4.0, 0.0), (-0.6, 0.0)),  # before a wall, pulling back
    ],
)
def test_a_push_away_from_a_wall_is_obeyed_at_once(drive, start, stick):
    ticks, truths = drive(1.2, lambda t: stick if t >= 0.5 else (0.0, 0.0), start=start)
    pushed = [k for k in ticks if 0.5 <= k.observation.time <= 0.7]
    assert any(k.decision.twist.any() for k in pushed)
    assert not any(t.hit_wall for t in truths)


def test_somebody_who_crosses_is_waited_for_and_not_steered_round(drive):
    def people(t):
        return [(6.5, 0.7 + 0.7 * t, 0.0, 0.7)]

    ticks, truths = drive(9.0, lambda t: (0.8, 0.0), people=people)
    assert {k.decision.reason for k in ticks} & {Reason.TOO_CLOSE, Reason.BLOCKED}
    assert max(abs(t.pose[1] - 4.0) for t in truths) < 0.15
    assert truths[-1].pose[0] > 6.5
    assert not any(t.hit_moving.any() for t in truths)


def test_the_chair_never_reverses_unasked(drive):
    boxes = [(6.0, 0.0, 6.6, 8.0)]
    ticks, truths = drive(8.0, lambda t: (0.8, 0.2), boxes=boxes, goal=[4.5, 4.0])
    assert min(k.decision.twist[0] for k in ticks) >= 0.0
    assert not any(t.hit_wall for t in truths)


def test_shared_control_without_a_destination_is_help_with_steering(drive):
    box = [(6.0, 3.7, 6.6, 4.5)]
    one, other = (
        drive(5.0, lambda t: (0.8, 0.1), boxes=box, mode=mode)[0] for mode in ("assisted", "shared")
    )
    assert all(
        np.array_equal(a.decision.twist, b.decision.twist) for a, b in zip(one, other, strict=True)
    )
