"""Contacts with people: forces follow from masses and stiffness, and people are no walls."""

import dataclasses
import math

import numpy as np
import pytest

from cohelm.maps import OccupancyGrid
from cohelm.platforms.twin import people as people_module
from cohelm.platforms.twin.body_regions import REGIONS
from cohelm.simulation import Crowd

OPEN = OccupancyGrid(data=np.zeros((10, 10), np.int8), resolution=0.05, X_MG=np.zeros(3))


def one_person(at, velocity):
    return Crowd(
        position=np.array([at], dtype=float),
        velocity=np.array([velocity], dtype=float),
        heading=np.array([math.pi]),
        radius=np.array([0.25]),
        preferred_speed=np.ones(1),
        waypoints=np.full((1, 1, 2), np.nan),
        target=np.zeros(1, dtype=np.int64),
        loop=np.zeros(1, dtype=bool),
        sees_robot=np.zeros(1, dtype=bool),
    )


def meeting(bench, crowd):
    return bench(
        grid=OPEN,
        heights=None,
        start=np.zeros(3),
        crowd=crowd,
        statures=np.array([1.7]),
        kinds=None,
    )


def worst(touches):
    return max(touches, key=lambda touch: touch.force)


def test_the_force_of_a_collision_is_that_of_two_masses_and_a_spring(
    bench, chair, mujoco, monkeypatch
):
    """v √(µ K) for both shanks side by side; the chair pitches, so its mass counts less."""
    monkeypatch.setattr(people_module, "_DAMPING", 0.0)
    rolling = meeting(bench, one_person([1.5, 0.0], [0.0, 0.0]))
    touches = []
    for _ in range(60):  # 0.6 m to go, and the impact
        touches += rolling.drive((0.4, 0.0, 0.0), 0.05).touches
    person = float(rolling.chair.twin.masses[0])
    mass = chair.chassis.total_mass * person / (chair.chassis.total_mass + person)
    expected = 0.4 * math.sqrt(mass * 2.0 * REGIONS["shank"].stiffness) / 2.0
    hardest = worst(touches)
    assert hardest.part == "shank"
    assert hardest.chair_part == "footrests"
    assert hardest.speed == pytest.approx(0.4, abs=0.03)
    assert expected * 0.8 <= hardest.force <= expected * 1.1
    assert hardest.energy == pytest.approx(hardest.force**2 / 2.0 / REGIONS["shank"].stiffness)


def test_a_person_who_walks_on_does_not_push_a_braked_chair_away(bench):
    """A push of 200 N is below the friction of the braked wheels, 0.8 times their load."""
    standing = meeting(bench, one_person([1.5, 0.0], [-1.0, 0.0]))
    hits = np.zeros(2, dtype=bool)
    for _ in range(60):
        contacts = standing.drive((0.0, 0.0, 0.0), 0.05)
        hits |= [contacts.hit_moving[0], contacts.hit_standing[0]]
        standing.crowd = dataclasses.replace(standing.crowd, velocity=np.array([[-1.0, 0.0]]))
    assert list(hits) == [False, True]  # the chair stood, whatever the impact did to it
    assert abs(standing.chair.pose[0]) < 0.05
    assert standing.crowd.position[0, 0] > 0.5
    moved = standing.chair.pose[0]
    standing.drive((0.0, 0.0, 0.0), 0.5)
    assert abs(standing.chair.pose[0] - moved) < 1e-3


def test_a_person_who_is_pushed_gives_way_and_is_free_again(bench):
    pushed = meeting(bench, one_person([1.2, 0.0], [0.0, 0.0]))
    pushed.drive((0.3, 0.0, 0.0), 3.0)
    assert pushed.crowd.position[0, 0] > 1.25
    pushed.drive((-0.3, 0.0, 0.0), 2.0)
    crowd = dataclasses.replace(pushed.crowd, velocity=np.array([[1.0, 0.0]]))
    pushed.crowd, start = crowd, crowd.position[0, 0]
    for _ in range(20):
        pushed.drive((0.0, 0.0, 0.0), 0.05)
        pushed.crowd = dataclasses.replace(pushed.crowd, velocity=np.array([[1.0, 0.0]]))
    assert pushed.crowd.position[0, 0] > start + 0.6


def test_untouched_people_are_exactly_where_the_crowd_has_them(bench):
    passing = meeting(bench, one_person([2.0, 1.5], [-1.0, 0.0]))
    passing.drive((0.0, 0.0, 0.0), 1.0)
    at = passing.chair.twin.people_state()[0][0, :2]
    assert at == pytest.approx([1.0, 1.5], abs=1e-9)
    assert not passing.chair.twin.people_state()[1][0, 2:].any()


def test_a_wall_is_a_contact_and_ends_the_way(bench, empty):
    against = bench(start=np.array([12.5, 7.0, 0.0]))
    contacts = against.drive((0.5, 0.0, 0.0), 4.0)
    assert contacts.hit_wall
    assert {touch.person for touch in contacts.touches} == {-1}
    assert not against.drive((-0.3, 0.0, 0.0), 2.0).hit_wall
