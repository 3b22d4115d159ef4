"""When and where a motion touches something: each number is derived beside it."""

import dataclasses

import numpy as np
import pytest

from cohelm.maps import DistanceField
from cohelm.robots import load_robot, robot_names
from cohelm.robots.braking import STANDING, braking
from cohelm.robots.contact import first_contact
from cohelm.robots.contact_kernel import TOUCHING, ContactMargins
from cohelm.testing.scenes import BODY, open_floor, straight_on, walkers

STEP = 0.1
SUB = STEP / 4.0
MARGIN = 0.03
# 1.11 m of length in five pieces of 0.222 m: the foremost disc's centre and the radius of all
NOSE = 0.65 - 0.111
RADIUS = np.hypot(0.222, 0.61) / 2.0


def ahead(speed, seconds=4.0, turn=0.0):
    """Poses of a steady motion from the origin."""
    times = np.arange(round(seconds / STEP) + 1) * STEP
    if turn == 0.0:
        return np.column_stack([speed * times, 0.0 * times, 0.0 * times])
    angle = turn * times
    return np.column_stack(
        [speed / turn * np.sin(angle), speed / turn * (1.0 - np.cos(angle)), angle]
    )


def wall_at(x):
    """Everything beyond x is wall: the distance is x_wall − x, exactly."""
    centres = (np.arange(200) + 0.5) * 0.1 - 10.0
    distance = np.tile(x - centres, (200, 1)).astype(np.float32)
    return DistanceField(distance=distance, resolution=0.1, X_MG=np.array([-10.0, -10.0, 0.0]))


def contact(chair, poses, people=(), walls=None, steps=40, people_margin=MARGIN, **margins):
    who = walkers(np.reshape(people, (-1, 4)))
    return first_contact(
        chair,
        poses,
        STEP,
        people=who,
        predictions=straight_on(who, steps, STEP),
        walls=open_floor() if walls is None else walls,
        margins=ContactMargins(MARGIN, people_margin, **margins),
    )


def at_a_substep(time):
    """The first moment tested at or after ``time``."""
    return pytest.approx(np.ceil(time / SUB - 1e-6) * SUB)


@pytest.mark.parametrize("name", robot_names())
def test_a_circle_that_holds_the_discs_holds_the_capsule(name):
    """What is surely clear of the discs is of the capsule: the look from afar leaves nobody out."""
    robot = load_robot(name)
    x, y, radius = robot.discs.T
    ax, ay, bx, by, thick = robot.capsule
    held = max(np.hypot(ax, ay), np.hypot(bx, by)) + thick
    assert held == (np.hypot(x, y) + radius).max()


def test_nothing_there_is_never_touched(chair):
    assert contact(chair, ahead(0.5)) == np.inf


@pytest.mark.parametrize("speed", [0.25, 0.5, 1.0])
def test_a_wall_one_metre_ahead(chair, speed):
    # (1 m − 3 cm) / speed, at 0.5 m/s 1.94 s
    met = contact(chair, ahead(speed), walls=wall_at(NOSE + RADIUS + 1.0))
    assert met == at_a_substep((1.0 - MARGIN) / speed)


def test_a_wall_just_out_of_reach(chair):
    # 4 s at 0.2 m/s lead 0.8 m on
    assert contact(chair, ahead(0.2), walls=wall_at(NOSE + RADIUS + 0.84)) == np.inf
    assert contact(chair, ahead(0.2), walls=wall_at(NOSE + RADIUS + 0.82)) < np.inf


def test_a_wall_that_is_close_already_may_be_left_but_not_approached(chair):
    close = wall_at(NOSE + RADIUS + 0.01)
    assert contact(chair, ahead(-0.3), walls=close) == np.inf
    assert contact(chair, ahead(0.3), walls=close) == pytest.approx(SUB)


def test_someone_who_comes_head_on(chair):
    # 4 m away, the nose at 0.539 m: 1.5 m/s of closing speed
    met = contact(chair, ahead(0.5), [[4.0, 0.0, -1.0, 0.0]])
    assert met == at_a_substep((4.0 - NOSE - RADIUS - BODY - MARGIN) / 1.5)


def test_someone_who_crosses_in_front(chair):
    # the nose at (0.539 + 0.5 t, 0), the person at (1.6, −2 + t): the distance is reached where
    # 1.25 t² − (1.061 + 4) t + 1.061² + 4 − d² = 0
    d, apart = RADIUS + BODY + MARGIN, 1.6 - NOSE
    roots = np.roots([1.25, -(apart + 4.0), apart**2 + 4.0 - d**2])
    met = contact(chair, ahead(0.5), [[1.6, -2.0, 0.0, 1.0]])
    assert met == at_a_substep(roots.real.min())


def test_someone_who_walks_into_its_side(chair):
    # beside the spine only the distance across counts: 1.5 m at 0.6 m/s, while the chair rolls on
    met = contact(chair, ahead(0.1), [[0.3, 1.5, 0.0, -0.6]])
    assert met == at_a_substep((1.5 - RADIUS - BODY - MARGIN) / 0.6)


def test_someone_who_has_crossed_before(chair):
    assert contact(chair, ahead(0.5), [[1.6, -0.9, 0.0, 1.4]]) == np.inf


def test_who_overtakes_at_a_distance(chair):
    assert contact(chair, ahead(0.5), [[-2.0, 1.2, 1.5, 0.0]]) == np.inf


def test_a_chair_that_stands_is_not_to_blame(chair):
    assert contact(chair, ahead(0.0), [[2.0, 0.0, -1.0, 0.0]]) == np.inf


@pytest.mark.parametrize("speed", [-0.3, 0.3])
@pytest.mark.parametrize(("depth", "walking"), [(0.01, -0.3), (0.07, 0.0)])
def test_who_touches_the_chair_and_walks_or_overlaps_it_is_waited_for(chair, speed, depth, walking):
    person = [[NOSE + RADIUS + BODY - depth, 0.0, walking, 0.0]]
    assert contact(chair, ahead(speed), person) == pytest.approx(SUB)


@pytest.mark.parametrize("gap", [-0.01, 0.05])
def test_whoever_stands_close_may_be_left_but_not_approached(chair, gap):
    person = [[NOSE + RADIUS + BODY + gap, 0.0, 0.0, 0.0]]
    assert contact(chair, ahead(-0.3), person, people_margin=0.15) == np.inf
    # 1 cm nearer than standing still is allowed: 0.3 m/s takes 0.75 cm in one substep
    assert contact(chair, ahead(0.3), person, people_margin=0.15) == pytest.approx(2.0 * SUB)


def test_whoever_comes_anyway_does_not_hold_the_chair_fast(chair):
    """From behind at 0.3 m/s she would reach a chair that stands; one that drives is free."""
    behind = [[-0.46 + 0.111 - RADIUS - BODY - 0.1, 0.0, 0.3, 0.0]]
    assert contact(chair, ahead(0.5, 2.0), behind, people_margin=0.15) == np.inf


def test_agile_people_need_more_room(chair):
    """The margin is 3 cm + ½ · 0.5 m/s² · t²."""
    person = [[1.0, RADIUS + BODY + 0.3, 0.5, 0.0]]
    assert contact(chair, ahead(0.5), person) == np.inf
    met = contact(chair, ahead(0.5), person, acceleration=0.5)
    # she walks beside the nose: 1 − 0.539 m ahead of it, so the gap is that to the nose's disc
    gap = np.hypot(1.0 - NOSE, RADIUS + BODY + 0.3) - RADIUS - BODY
    assert met == at_a_substep(np.sqrt((gap - MARGIN) / 0.25))


@pytest.mark.parametrize(("speed", "share"), [(0.0, 0.4), (0.25, 0.7), (0.5, 1.0)])
def test_who_stands_needs_less_room_than_who_walks(chair, speed, share):
    """He is passed at a right angle: of 0.25 m count 40 % where he stands, all from 0.5 m/s on."""
    # he walks towards the side of a chair that drives at 0.5 m/s, and is 1 m from the axle at 2 s
    for more, met in ((0.01, False), (-0.01, True)):
        across = RADIUS + BODY + share * 0.25 + more
        person = [[0.9, across + 2.0 * speed, 0.0, -speed]]
        reached = contact(chair, ahead(0.5, 2.0), person, people_margin=0.25, standing_share=0.4)
        assert (reached < np.inf) is met


@pytest.mark.parametrize(("speed", "walks"), [(0.0, 0.0), (0.25, 0.5), (0.5, 1.0), (1.0, 1.0)])
def test_the_gap_to_who_walks_grows_with_time_and_that_to_who_stands_does_not(chair, speed, walks):
    """0.1 m now and 0.1 m/s: he is beside the axle at 2 s, and walks towards the chair's side."""
    for more, met in ((0.01, False), (-0.01, True)):
        across = RADIUS + BODY + 0.1 + 0.1 * walks * 2.0 + more
        person = [[0.9, across + 2.0 * speed, 0.0, -speed]]
        reached = contact(chair, ahead(0.5, 2.0), person, people_margin=0.1, growth=0.1)
        assert (reached < np.inf) is met


@pytest.mark.parametrize(("pace", "met"), [(0.0, False), (0.4, True)])
def test_who_is_held_up_needs_the_room_of_who_walks(chair, pace, met):
    """He stands beside the axle of 2 s: 0.1 m from what he needs now, and less than he may then."""
    across = RADIUS + BODY + 0.1 + 0.05
    who = walkers([[0.9, across, 0.0, 0.0]])
    reached = first_contact(
        chair,
        ahead(0.5, 2.0),
        STEP,
        people=who,
        predictions=straight_on(who, 40, STEP),
        walls=open_floor(),
        margins=ContactMargins(MARGIN, 0.1, growth=0.1),
        paces=np.array([pace]),
    )
    assert (reached < np.inf) is met


def test_beyond_the_prediction_people_walk_on(chair):
    """Predicted for 0.5 s only: she is met where she was with the whole prediction."""
    person = [[4.0, 0.0, -1.0, 0.0]]
    whole = contact(chair, ahead(0.5), person)
    assert contact(chair, ahead(0.5), person, steps=5) == pytest.approx(whole)


def test_nobody_slips_through_between_steps(chair):
    """2 m/s across a chair that creeps: 0.2 m a step, tested every 5 cm."""
    met = contact(chair, ahead(0.05, 3.0), [[0.1, 2.0, 0.0, -2.0]])
    assert met == at_a_substep((2.0 - RADIUS - BODY - MARGIN) / 2.0)


def test_touching_is_a_gap_below_what_is_seen():
    assert 0.0 < TOUCHING <= 0.05


@pytest.mark.parametrize(("speed", "hold", "deceleration"), [(0.8, 0.15, 1.0), (0.5, 0.1, 1.8)])
def test_braking_takes_the_distance_of_the_textbook(chair, speed, hold, deceleration):
    # v t + v² / 2a: 0.8 · 0.15 + 0.64 / 2 = 0.44 m
    now = np.array([speed, 0.0])
    poses = braking(chair, np.zeros(3), now, now, hold=hold, deceleration=deceleration, step=0.05)
    assert poses[-1, 0] == pytest.approx(speed * hold + speed**2 / (2.0 * deceleration), abs=2e-3)
    assert np.abs(poses[:, 1:]).max() == 0.0
    assert (np.diff(poses[:, 0]) >= 0.0).all()


def test_a_command_is_taken_up_no_faster_than_the_limits_allow(chair):
    # from rest, 0.8 m/s² for 0.15 s: 0.12 m/s, and not the 1 m/s that is asked for
    poses = braking(
        chair,
        np.zeros(3),
        np.zeros(2),
        np.array([1.0, 0.0]),
        hold=0.15,
        deceleration=1.0,
        step=0.05,
    )
    # three steps of 0.05 s at 0.04, 0.08 and 0.12 m/s; braking begins to show in the last
    assert poses[2, 0] == pytest.approx(0.05 * (0.04 + 0.08), abs=1e-4)
    assert 0.9 < poses[3, 0] / (0.05 * (0.04 + 0.08 + 0.12)) <= 1.0
    assert poses[-1, 0] < 0.03


@pytest.mark.parametrize("turn", [0.4, 0.8, -1.2])
def test_who_turns_on_the_spot_needs_time_to_stop(chair, turn):
    # |ω| / 2.5 rad/s² after a hold of 0.15 s; then the lag of 0.08 s dies away below STANDING
    now = np.array([0.0, turn])
    poses = braking(chair, np.zeros(3), now, now, hold=0.15, deceleration=1.8, step=0.01)
    fading = abs(turn) / 2.5
    assert poses[-1, 2] == pytest.approx(turn * 0.15 + 0.5 * turn * fading, abs=2e-3)
    moving = np.flatnonzero(np.abs(np.diff(poses[:, 2])) > STANDING * 0.01)[-1] * 0.01
    assert moving == pytest.approx(
        0.15 - 0.08 + fading + 0.08 * np.log(2.5 * 0.08 / STANDING), abs=0.03
    )


def test_an_unlikely_future_counts_only_if_it_is_asked_for(chair):
    """She walks past, or with a chance of one in five into the chair's way."""
    who = walkers([[2.0, -1.2, 0.3, 0.0]])
    plain = straight_on(who, 40, STEP)
    times = np.arange(41) * STEP
    into = plain.mean + np.stack([0.0 * times, 0.4 * times], axis=-1)
    two = dataclasses.replace(
        plain,
        names=("on", "aside"),
        weight=np.array([[0.8, 0.2]]),
        mean=np.concatenate([plain.mean, into], axis=1),
        velocity=np.repeat(plain.velocity, 2, axis=1),
        deviation=np.repeat(plain.deviation, 2, axis=1),
    )
    met = [
        first_contact(
            chair,
            ahead(0.8),
            STEP,
            people=who,
            predictions=two,
            walls=open_floor(),
            margins=ContactMargins(MARGIN, MARGIN, min_probability=probability),
        )
        for probability in (0.0, 0.2, 0.21, 1.0)
    ]
    assert met[0] == met[1] < np.inf
    assert met[2] == met[3] == np.inf


def test_braking_keeps_to_its_arc(chair):
    """0.6 m/s at 0.3 rad/s is a circle of 2 m; every pose of the braking lies on it."""
    now = np.array([0.6, 0.3])
    poses = braking(chair, np.zeros(3), now, now, hold=0.15, deceleration=1.0, step=0.01)
    away = np.hypot(poses[:, 0], poses[:, 1] - 2.0)
    # steps of 6 mm, each along the heading at its start: 1e-5 m outwards a step, 75 steps
    assert np.abs(away - 2.0).max() < 1e-3
    assert poses[-1, 2] == pytest.approx(0.3 * (0.15 + 0.3), abs=2e-3)


def test_a_chair_that_stands_stays_while_it_brakes(chair):
    poses = braking(
        chair, np.zeros(3), np.zeros(2), np.zeros(2), hold=0.15, deceleration=1.0, step=0.05
    )
    assert np.abs(poses).max() == 0.0
