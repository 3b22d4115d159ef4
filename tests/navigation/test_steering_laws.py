"""Laws of steering help: coarse hands get through doors, and nobody is steered against."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cohelm.geometry import wrap_angle
from cohelm.maps import distance_field
from cohelm.navigation.steering_help import slowly
from cohelm.robots import load_robot
from cohelm.robots.contact import first_contact
from cohelm.robots.contact_kernel import ContactMargins
from cohelm.testing.scenes import room

DOOR = [(6.0, 0.0, 6.1, 4.0), (6.0, 4.75, 6.1, 8.0)]
"""A wall with a door of 0.75 m, whose middle is (6.05, 4.375); the chair is 0.61 m wide."""
WALLS = distance_field(room(boxes=DOOR))
BESIDE = (3.5, 3.95, 0.0)
"""0.43 m beside the axis of the door: straight on is the wall."""
FORWARD = (0.58, 0.0)
few = settings(max_examples=4, suppress_health_check=[HealthCheck.function_scoped_fixture])


def held(stick):
    return lambda t: stick


def test_a_switch_that_is_held_leads_through_the_door(drive):
    ticks, truths = drive(12.0, held(FORWARD), boxes=DOOR, start=BESIDE)
    assert truths[-1].pose[0] > 7.0
    assert not any(t.hit_wall for t in truths)
    assert ticks[-1].memory.steering.hand.kind == "one_switch"
    turned = [abs(wrap_angle(t.pose[2])) for t in truths]
    assert max(turned) < ticks[0].memory.steering.hand.width + math.pi / 4


def test_a_door_that_no_map_has_is_found_by_the_scan(drive):
    # 0.95 m from y = 3.9 to 4.85: cells of 5 cm that a noisy scan meets count as occupied.
    sides = "[{at: [6.05, 1.95], size: [0.1, 3.9]}, {at: [6.05, 6.425], size: [0.1, 3.15]}]"
    _, truths = drive(14.0, held(FORWARD), start=BESIDE, obstacles=sides)
    assert truths[-1].pose[0] > 7.0
    assert not any(t.hit_wall for t in truths)


def test_without_attraction_the_switch_ends_at_the_wall(drive):
    ticks, truths = drive(
        6.0, held(FORWARD), boxes=DOOR, start=(3.5, 3.3, 0.0), steering="{attraction: 0}"
    )
    assert truths[-1].pose[0] < 6.0
    assert all(
        math.isnan(t.memory.steering.aim) or t.memory.steering.aim == t.memory.steering.heading
        for t in ticks
    )


@pytest.mark.parametrize("stick", [(0.0, 0.4), (0.0, -0.4), (-0.4, 0.0), (0.35, 0.35), FORWARD])
@pytest.mark.parametrize("hand", ["one_switch", "eight_directions"])
def test_in_open_space_a_coarse_hand_gets_what_it_pushes(drive, stick, hand):
    ticks, _ = drive(1.2, held(stick), start=(6.0, 4.0, 0.5), steering=f"{{hand: {hand}}}")
    for tick in ticks:
        difference = tick.decision.twist - tick.authority.twist
        assert np.abs(difference).max() <= 0.02 * np.abs(tick.authority.twist).max()


@few
@given(
    ahead=st.floats(-1.0, 1.0),
    left=st.floats(-1.0, 1.0),
    until=st.floats(0.6, 1.6),
    hand=st.sampled_from(["auto", "one_switch", "eight_directions"]),
)
def test_a_released_stick_means_zero_at_once_and_rest_after_braking(
    drive, ahead, left, until, hand
):
    ticks, truths = drive(
        until + 1.6,
        lambda t: (ahead, left) if t < until else (0.0, 0.0),
        boxes=DOOR,
        start=BESIDE,
        steering=f"{{hand: {hand}}}",
    )
    after = [k for k in ticks if k.observation.time >= until]
    assert not any(k.decision.twist.any() for k in after)
    # 1.0 m/s or 1.2 rad/s at most, at 1.0 m/s² and 2.5 rad/s², and the lag and jerk of the drive
    rest = [t for t in truths if t.time >= until + 1.5]
    assert all(np.abs(t.twist).max() < 0.02 for t in rest)


@few
@given(left=st.floats(0.1, 1.0), side=st.sampled_from([-1, 1]), y=st.floats(3.0, 5.5))
def test_the_chair_turns_against_the_stick_only_before_what_it_detects(drive, left, side, y):
    ticks, _ = drive(4.0, held((0.6, side * left)), boxes=DOOR, start=(3.8, y, -side * 0.5))
    late = 0.8
    for tick in ticks:
        if side * tick.decision.twist[2] < -0.02:
            assert contact_straight_on(tick) <= late + 0.2, tick.observation.time


def contact_straight_on(tick):
    """Time until the chair meets something if it does not turn, s."""
    robot, pose = load_robot("quantum_q6_edge"), tick.observation.pose
    speed = max(float(tick.decision.twist[0]), 0.05)
    along = np.arange(0.0, 3.0, 0.05)[:, None] * [math.cos(pose[2]), math.sin(pose[2]), 0.0]
    return first_contact(
        robot,
        pose + speed * along,
        0.05,
        people=tick.people,
        predictions=tick.predictions,
        walls=WALLS,
        margins=ContactMargins(wall=0.08, people=0.15),
    )


def test_a_stick_that_leans_is_not_turned_back_to_where_it_was(drive):
    # Straight on, a turn, then a little to the left: less than ``straight``, so that the
    # direction is kept; the chair must not turn right to come back to it.
    def stick(t):
        return (
            (0.6, 0.0005 * math.sin(9 * t)) if t < 1.0 else (0.6, 0.5) if t < 1.6 else (0.6, 0.09)
        )

    ticks, _ = drive(5.0, stick, start=(1.5, 3.0, 0.0))
    later = [k for k in ticks if k.observation.time > 1.6]
    assert min(k.decision.twist[2] for k in later) >= 0.0


def test_a_mirrored_door_is_passed_by_the_mirrored_ride(drive):
    mirrored = [(6.0, 4.0, 6.1, 8.0), (6.0, 0.0, 6.1, 3.25)]
    _, one = drive(9.0, held(FORWARD), boxes=DOOR, start=BESIDE)
    _, other = drive(9.0, held(FORWARD), boxes=mirrored, start=(3.5, 4.05, 0.0))
    ys = np.array([[a.pose[1], 8.0 - b.pose[1]] for a, b in zip(one, other, strict=True)])
    assert np.abs(ys[:, 0] - ys[:, 1]).max() < 0.15


@given(
    speed=st.floats(-1.0, 1.0),
    turn=st.floats(-1.5, 1.5),
    bound=st.floats(0.05, 0.5),
    degrees=st.floats(0.0, 360.0),
)
def test_a_slowed_turn_sweeps_no_point_of_the_chair_faster_than_the_bound(
    speed, turn, bound, degrees
):
    outline = load_robot("quantum_q6_edge").outline
    wanted = np.array([speed, 0.0, turn])
    slow = slowly(wanted, outline, bound)
    point = outline[0] + degrees / 360.0 * (outline[1] - outline[0])
    velocity = np.array([slow[0] - slow[2] * point[1], slow[2] * point[0]])
    assert np.hypot(*velocity) <= bound + 1e-9
    # the way stays the same: a share of the twist, and all of it where that is slow enough
    np.testing.assert_allclose(np.cross(slow, wanted), 0.0, atol=1e-12)
    assert np.dot(slow, wanted) >= 0.0
    if abs(speed) + abs(turn) * np.hypot(*outline.T).max() <= bound:
        np.testing.assert_array_equal(slow, wanted)
