"""Laws of social forces."""

import numpy as np
import pytest

from cohelm.simulation import SocialForce
from cohelm.simulation.crowds.social_force import group_forces, pair_forces

OPEN = {"walls": False}
MIRROR = np.array([1.0, -1.0])


def walk(model, crowd, scene, seconds, dt=0.05):
    rng = np.random.default_rng(0)
    crowds = [crowd]
    for _ in range(round(seconds / dt)):
        crowds.append(model.step(crowds[-1], scene, dt, rng))
    return crowds


def social(**changes):
    return SocialForce(SocialForce.Parameters(**{**OPEN, **changes}))


def between(position, velocity, *, bias=0.0, group=None, **changes):
    """The pair forces among n people of 0.25 m; the robot is far away."""
    n = len(position)
    given = {"reach": 8.0, "strength": 4.5, "gamma": 0.35, "narrow": 3.0, "wide": 2.0}
    return pair_forces(
        np.vstack([position, [1e4, 0.0]]), np.vstack([velocity, [0.0, 0.0]]), np.full(n + 1, 0.25),
        np.full(n, -1) if group is None else np.array(group), np.zeros(n, dtype=bool),
        *{**given, **changes}.values(), 2.0, bias,
    )  # fmt: skip


@pytest.fixture
def people():
    rng = np.random.default_rng(4)
    return rng.uniform(0.0, 6.0, (30, 2)), rng.normal(0.0, 1.0, (30, 2))


def test_two_exactly_head_on_pass_each_other_without_contact(make_crowd, make_scene):
    crowd = make_crowd([[0.0, 0.0], [10.0, 0.0]], [[[10.0, 0.0]], [[0.0, 0.0]]])
    crowds = walk(social(), crowd, make_scene(), 14.0)
    apart = [np.hypot(*(c.position[0] - c.position[1])) for c in crowds]
    assert min(apart) > 0.5  # bodies of 0.25 m
    assert (crowds[-1].target == 1).all()
    aside = crowds[len(crowds) // 3].position
    assert aside[0, 1] < 0.0 < aside[1, 1]  # each to the right
    np.testing.assert_allclose(aside[0] + aside[1], [10.0, 0.0], atol=1e-9)  # point symmetry


@pytest.mark.parametrize("bias", [0.0, 0.005])
def test_what_two_do_to_each_other_sums_to_nothing(people, bias):
    position, velocity = people
    force = between(position, velocity, bias=bias)
    assert np.abs(force).max() > 0.5
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-9)


def test_a_mirrored_crowd_has_mirrored_forces_without_the_bias(people):
    position, velocity = people
    mirrored = between(MIRROR * position, MIRROR * velocity)
    np.testing.assert_allclose(mirrored, MIRROR * between(position, velocity), atol=1e-9)


def test_a_turned_crowd_has_turned_forces(people):
    position, velocity = people
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    there = between(position @ turn.T, velocity @ turn.T, bias=0.005)
    np.testing.assert_allclose(there, between(position, velocity, bias=0.005) @ turn.T, atol=1e-9)


def test_the_force_is_the_papers_where_both_stand_and_meet_head_on():
    # at rest D = e, B = γ = 0.35, θ = 0: −A e^(−d/B) along e
    force = between(np.array([[0.0, 0.0], [0.7, 0.0]]), np.zeros((2, 2)))
    np.testing.assert_allclose(force[0], [-4.5 * np.exp(-2.0), 0.0])
    # towards each other with 1 m/s: D = (2 · 2 + 1, 0), B = 1.75
    force = between(np.array([[0.0, 0.0], [3.5, 0.0]]), np.array([[1.0, 0.0], [-1.0, 0.0]]))
    np.testing.assert_allclose(force[0], [-4.5 * np.exp(-2.0), 0.0])


def test_nothing_is_felt_beyond_reach_nor_within_a_group(people):
    position, velocity = people
    assert not between(np.array([[0.0, 0.0], [8.1, 0.0]]), velocity[:2]).any()
    assert not between(position, velocity, group=np.zeros(30, dtype=int)).any()


def test_the_order_of_people_does_not_matter(people):
    position, velocity = people
    order = np.random.default_rng(1).permutation(30)
    force = between(position, velocity)
    np.testing.assert_allclose(between(position[order], velocity[order]), force[order], atol=1e-9)


def test_the_forces_of_a_group_are_the_papers():
    position = np.array([[0.0, 0.0], [3.0, 0.0], [50.0, 0.0]])
    ahead = np.tile([1.0, 0.0], (3, 1))
    group = np.array([0, 0, -1])
    force = group_forces(position, ahead, ahead, group, 4.0, 3.0, 1.0, 1.57, 0.8)
    # the centre is 1.5 m away, beyond (2 − 1)/2: both are drawn; who is in front has it at π behind
    np.testing.assert_allclose(force, [[3.0, 0.0], [-3.0 - 4.0 * (np.pi - 1.57), 0.0], [0.0, 0.0]])
    near = group_forces(
        position * [0.2, 0.0], ahead * 0.0, ahead * 0.0, group, 4.0, 3.0, 1.0, 1.57, 0.8
    )
    np.testing.assert_allclose(near, [[-1.0, 0.0], [1.0, 0.0], [0.0, 0.0]])  # 0.6 m apart


def test_a_group_stays_together_through_a_counterflow(make_crowd, make_scene):
    start = np.array([[0, -0.85], [0, 0], [0, 0.85], [14, -0.4], [14, 0.5], [16, 0]])
    way = np.array([16.0, 0.0])
    goal = np.vstack([start[:3] + way, start[3:] - way])
    group = np.array([0, 0, 0, -1, -1, -1])
    spread = {}
    for together in (True, False):
        crowd = make_crowd(start, goal[:, None], group=group if together else None)
        crowds = walk(social(), crowd, make_scene(), 22.0)
        centre = [c.position[:3] - c.position[:3].mean(axis=0) for c in crowds]
        spread[together] = max(np.hypot(*each.T).max() for each in centre)
        gaps = [np.hypot(*(c.position[:, None] - c.position[None]).T) for c in crowds]
        assert min(gap[~np.eye(6, dtype=bool)].min() for gap in gaps) > 0.5 - 1e-9
    assert spread[True] < 1.6
    assert spread[True] < spread[False]


def test_who_sees_the_robot_goes_round_it_and_who_does_not_goes_through(make_crowd, make_scene):
    scene = make_scene(robot_position=np.array([4.0, 0.05]))
    for sees in (True, False):
        crowd = make_crowd([[0.0, 0.0]], [[[8.0, 0.0]]], sees_robot=np.array([sees]))
        crowds = walk(social(), crowd, scene, 12.0)
        gap = min(np.hypot(*(c.position[0] - scene.robot_position)) for c in crowds) - 0.75
        assert gap > 0.15 - 1e-9 if sees else gap < -0.6  # the clearance
        assert crowds[-1].target[0] == 1


@pytest.mark.parametrize("seconds", [5, pytest.param(60, marks=pytest.mark.slow)])
def test_three_hundred_people_stay_finite_and_do_not_overlap(
    make_crowd, make_scene, make_grid, seconds
):
    walls = ((0, 0, 20, 0.2), (0, 19.8, 20, 20), (0, 0, 0.2, 20), (19.8, 0, 20, 20), (9, 9, 11, 11))
    scene = make_scene(make_grid(20.0, 20.0, walls))
    rng = np.random.default_rng(0)
    places = np.argwhere(np.ones((18, 18))) + 1.5
    places = places[np.hypot(*(places - 10.0).T) > 2.2][:300]
    n = len(places)
    goals = rng.permutation(places)
    crowd = make_crowd(
        places, np.stack([goals, places], axis=1), loop=np.ones(n, dtype=bool),
        group=np.arange(n) // 3, preferred_speed=rng.uniform(0.8, 1.4, n),
    )  # fmt: skip
    for k in range(20 * seconds):
        crowd = SocialForce().step(crowd, scene, 0.05, rng)
        assert np.isfinite(crowd.position).all()
        if k % 100 == 99:
            apart = np.hypot(*(crowd.position[:, None] - crowd.position[None]).transpose(2, 0, 1))
            assert apart[~np.eye(n, dtype=bool)].min() > 0.4  # the press may squeeze them a little
            inside = (crowd.position > 0.2 + 0.24) & (crowd.position < 19.8 - 0.24)
            assert inside.all()


def test_twin_walks_are_equal_to_the_bit(make_crowd, make_scene, people):
    position, _ = people
    crowd = make_crowd(3.0 * position, np.roll(position, 1, axis=0)[:, None])
    one, other = (walk(social(), crowd, make_scene(), 3.0)[-1] for _ in range(2))
    assert one.position.tobytes() == other.position.tobytes()


def test_who_is_pushed_from_where_they_stand_goes_back(make_crowd, make_scene):
    crowd = make_crowd([[0.4, 0.0]], [[[0.0, 0.0]]], target=np.array([1]))
    assert np.hypot(*walk(social(), crowd, make_scene(), 5.0)[-1].position[0]) < 0.05
