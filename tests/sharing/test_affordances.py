"""What lies ahead attracts, within the interval of the rider's direction."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.maps import distance_field
from cohelm.robots import load_robot
from cohelm.robots.wall_contact import wall_grid
from cohelm.sharing.affordances import aim, faces_passage, find_passage, free_lengths, is_open
from cohelm.testing.scenes import open_floor, room

CHAIR = load_robot("quantum_q6_edge")
NOBODY = np.empty((0, 3))
DOOR = [(6.0, 0.0, 6.1, 4.0), (6.0, 4.75, 6.1, 8.0)]
"""A wall with a door of 0.75 m, whose middle is (6.05, 4.375)."""
WALLS = distance_field(room(boxes=DOOR))


def led(pose, *, walls=WALLS, width=math.pi / 4, centre=None, standing=NOBODY, reach=4.0):
    pose = np.asarray(pose, dtype=float)
    middle = float(pose[2]) if centre is None else centre
    return aim(
        pose,
        walls,
        CHAIR,
        centre=middle,
        width=width,
        reach=reach,
        last=math.nan,
        standing=np.asarray(standing, dtype=float).reshape(-1, 3),
    ).heading


@pytest.mark.parametrize("y", [3.7, 4.0, 4.3, 4.6, 5.0])
def test_a_door_within_the_interval_attracts(y):
    at_door = math.atan2(4.375 - y, 6.05 - 3.5)
    # To the door, or somewhat beyond it and onto its axis.
    assert -0.03 <= np.sign(at_door) * (led((3.5, y, 0.0)) - at_door) <= 0.2


def test_a_door_outside_the_interval_does_not():
    assert led((3.5, 3.2, 0.0), width=math.radians(8)) <= math.radians(8)
    assert led((3.5, 3.7, -1.2)) == pytest.approx(-1.2)


def test_before_a_door_the_chair_is_led_onto_its_axis():
    # Beside the axis it is led across it; on the axis, through the middle.
    assert led((5.0, 4.2, 0.0)) == pytest.approx(math.atan2(0.175, 0.65 * 1.05), abs=0.06)
    assert led((5.0, 4.375, 0.0)) == pytest.approx(0.0, abs=0.03)


def test_a_passage_is_laid_out_from_wall_to_wall():
    found = find_passage(wall_grid(WALLS), np.array([4.0, 4.3]), 0.03, 3.0)
    assert (found.x, found.y) == pytest.approx((6.05, 4.375), abs=0.06)
    assert found.width == pytest.approx(0.75, abs=0.06)
    assert found.axis == pytest.approx(0.0, abs=0.1)


def test_nothing_attracts_on_open_floor_or_a_hand_without_width():
    assert led((0.0, 0.0, 0.7), walls=open_floor()) == 0.7
    assert led((3.5, 3.7, 0.0), width=0.0) == 0.0
    assert is_open(np.zeros(3), open_floor(), CHAIR)
    assert not is_open(np.array([5.0, 4.0, 0.0]), WALLS, CHAIR)


def test_people_who_stand_are_passed():
    assert led((3.0, 2.0, 0.0), standing=[(5.0, 1.9, 0.25)]) > 0.2
    assert led((3.0, 2.0, 0.0), standing=[(3.0, 6.0, 0.25)]) == led((3.0, 2.0, 0.0))


def test_a_chair_faces_a_passage_near_its_direction_alone():
    assert faces_passage(np.array([4.5, 4.3, 0.1]), WALLS, CHAIR, 4.0)
    assert not faces_passage(np.array([4.5, 4.3, 0.8]), WALLS, CHAIR, 4.0)
    assert not faces_passage(np.zeros(3), open_floor(), CHAIR, 4.0)


def test_a_lane_ends_one_radius_before_a_wall():
    lengths = free_lengths(wall_grid(WALLS), NOBODY, np.array([4.0, 2.0]), np.zeros(1), 0.3, 5.0)
    assert lengths[0] == pytest.approx(2.0 - 0.3, abs=0.04)


place = st.tuples(st.floats(1.0, 11.0), st.floats(1.0, 7.0), st.floats(-3.1, 3.1))


@settings(max_examples=60)
@given(pose=place, width=st.floats(0.0, 1.0), off=st.floats(-0.5, 0.5))
def test_the_chair_is_led_nowhere_outside_the_interval(pose, width, off):
    centre = pose[2] + off
    assert abs(led(pose, width=width, centre=centre) - centre) <= width + 1e-9


@settings(max_examples=40)
@given(pose=place, x=st.integers(40, 200), y=st.integers(20, 120), size=st.integers(4, 30))
def test_a_mirrored_world_has_mirrored_lanes(pose, x, y, size):
    box = np.array([(x, y, x + size, y + size)]) / 20.0
    mirrored = box[:, [0, 3, 2, 1]] * [1, -1, 1, -1] + [0, 8, 0, 8]
    turns = np.radians(np.arange(-40.0, 41.0, 4.0))
    one, other = (
        free_lengths(
            wall_grid(distance_field(room(boxes=boxes))),
            NOBODY,
            np.array([pose[0], at]),
            headings,
            0.3,
            4.0,
        )
        for boxes, at, headings in (
            (box, pose[1], pose[2] + turns),
            (mirrored, 8.0 - pose[1], -pose[2] - turns),
        )
    )
    # A lane that just grazes a corner may end there or not, by rounding.
    assert np.median(np.abs(one - other)) < 1e-3


@pytest.mark.parametrize("y", [3.7, 4.0, 4.2, 4.5, 4.7, 5.1])
@pytest.mark.parametrize("x", [3.0, 4.5, 5.2])
def test_a_mirrored_door_attracts_to_the_mirrored_side(x, y):
    flipped = distance_field(room(boxes=[(6.0, 4.0, 6.1, 8.0), (6.0, 0.0, 6.1, 3.25)]))
    assert led((x, y, 0.1)) == pytest.approx(-led((x, 8.0 - y, -0.1), walls=flipped), abs=0.09)
