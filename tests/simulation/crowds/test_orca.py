"""ORCA against the recorded RVO2 crowd, and laws."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cohelm.geometry import transform, wrap_angle
from cohelm.simulation import Orca

ORACLE = Orca.Parameters(walls=False, perturbation=0.0, max_speed_factor=1.0)
FREE = Orca.Parameters(walls=False)
BUILT_ONCE = settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@pytest.fixture(scope="module")
def recorded():
    folder = os.environ.get("COHELM_DATA")
    if not folder:
        pytest.skip("COHELM_DATA is not set: no recorded crowd to compare with")
    file = Path(folder) / "crowdnav" / "crowdnav_replay_circle_crossing_5.npz"
    if not file.exists():
        pytest.skip(f"{file} does not exist")
    with np.load(file) as data:
        return data["pos_vel"], data["goals"]


def crowdnav_step(make_crowd, make_scene, state, goal):
    """CrowdNav's people: straight to the goal at 1 m/s, slower within a metre of it."""
    crowd = make_crowd(
        state[:, :2], goal[:, None], velocity=state[:, 2:], radius=np.full(len(state), 0.3)
    )
    wanted = goal - state[:, :2]
    wanted = wanted / np.maximum(np.hypot(*wanted.T), 1.0)[:, None]
    velocity = Orca(ORACLE).velocities(crowd, make_scene(), wanted, np.ones(len(state)), 0.25)
    return np.hstack([state[:, :2] + 0.25 * velocity, velocity])


@pytest.mark.data
def test_one_step_from_recorded_states_is_rvo2s(recorded, make_crowd, make_scene):
    states, goals = recorded
    error = []
    for case in range(0, len(states), 25):
        for t in range(60):
            after = crowdnav_step(make_crowd, make_scene, states[case, t], goals[case])
            error.append(np.hypot(*(after - states[case, t + 1])[:, 2:].T))
    assert np.mean(np.array(error) < 1e-3) >= 0.99


@pytest.mark.data
def test_forty_free_running_steps_stay_with_the_recording(recorded, make_crowd, make_scene):
    states, goals = recorded
    error = []
    for case in range(0, len(states), 10):
        state = states[case, 0]
        for _ in range(40):
            state = crowdnav_step(make_crowd, make_scene, state, goals[case])
        error.append(np.hypot(*(state - states[case, 40])[:, :2].T))
    assert np.median(error) < 1e-5  # RVO2 computes in single precision
    assert np.max(error) < 0.02


def walk(model, crowd, scene, seconds, seed=0, dt=0.05):
    rng = np.random.default_rng(seed)
    crowds = [crowd]
    for _ in range(round(seconds / dt)):
        crowds.append(model.step(crowds[-1], scene, dt, rng))
    return crowds


def test_two_who_meet_head_on_pass_each_other(make_crowd, make_scene):
    crowd = make_crowd([[0.0, 0.02], [8.0, 0.0]], [[[8.0, 0.0]], [[0.0, 0.0]]])
    crowds = walk(Orca(FREE), crowd, make_scene(), 12.0)
    apart = [np.hypot(*(c.position[0] - c.position[1])) for c in crowds]
    assert min(apart) >= 0.5 - 1e-3  # two bodies of 0.25 m
    assert (crowds[-1].target == 1).all()


def test_alone_one_walks_straight_at_the_preferred_speed_and_stops(make_crowd, make_scene):
    crowd = make_crowd([[0.0, 0.0]], [[[3.0, 4.0]]], preferred_speed=np.array([1.25]))
    crowds = walk(Orca(FREE), crowd, make_scene(), 8.0)
    # 3 s at 1.25 m/s, less what starting at 6 m/s² costs: steps of 0.05 s at 0.3, 0.6, 0.9 and
    # 1.2 m/s, (4 × 1.25 − 3.0) × 0.05 = 0.1 m; from 1.25 m before the goal on v = distance / 1 s
    np.testing.assert_allclose(crowds[60].position[0], [0.6 * 3.65, 0.8 * 3.65], atol=1e-9)
    np.testing.assert_allclose(crowds[60].velocity[0], [0.75, 1.0], atol=1e-9)
    assert np.hypot(*(crowds[-1].position[0] - [3.0, 4.0])) <= 0.2
    np.testing.assert_array_equal(crowds[-1].velocity, 0.0)


def test_way_points_are_walked_in_order_and_again_in_a_loop(make_crowd, make_scene):
    square = [[2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [np.nan, np.nan]]
    crowd = make_crowd(
        [[0.0, 0.0], [30.0, 0.0]],
        np.array([square, np.add(square, [30.0, 0.0])]),
        loop=np.array([True, False]),
    )
    targets = np.array([c.target for c in walk(Orca(FREE), crowd, make_scene(), 12.0)])
    changes = [targets[np.r_[True, np.diff(targets[:, i]) != 0], i].tolist() for i in range(2)]
    assert changes[0][:5] == [0, 1, 2, 0, 1]
    assert changes[1] == [0, 1, 2, 3]  # 3: done; the fourth is no way-point


def test_who_stands_keeps_facing_the_same_way(make_crowd, make_scene):
    crowd = make_crowd([[0.0, 0.0]], [[[0.1, 0.0]]], heading=np.array([2.0]))
    assert walk(Orca(FREE), crowd, make_scene(), 1.0)[-1].heading[0] == 2.0


def test_the_body_turns_smoothly_to_where_one_walks(make_crowd, make_scene):
    crowd = make_crowd([[0.0, 0.0]], [[[-9.0, 0.1]]], heading=np.array([0.0]))
    headings = np.array([c.heading[0] for c in walk(Orca(FREE), crowd, make_scene(), 3.0)])
    assert np.abs(wrap_angle(np.diff(headings))).max() < np.pi * (1 - np.exp(-0.05 / 0.3)) + 1e-9
    assert abs(headings[-1]) > 3.1


def random_crowd(make_crowd, seed, n=6):
    rng = np.random.default_rng(seed)
    position = rng.uniform(-3.0, 3.0, (n, 2))
    velocity = rng.uniform(-0.7, 0.7, (n, 2))
    goal = rng.uniform(-5.0, 5.0, (n, 1, 2))
    return make_crowd(position, goal, velocity=velocity, sees_robot=np.ones(n, dtype=bool))


@BUILT_ONCE
@given(seed=st.integers(0, 10**6), angle=st.floats(-3.1, 3.1))
def test_a_rotated_crowd_moves_the_same_way_rotated(make_crowd, make_scene, seed, angle):
    X = np.array([1.0, -2.0, angle])
    turn = np.array([0.0, 0.0, angle])
    crowd = random_crowd(make_crowd, seed)
    rotated = make_crowd(
        transform(X, crowd.position),
        transform(X, crowd.waypoints),
        velocity=transform(turn, crowd.velocity),
        sees_robot=crowd.sees_robot,
    )
    robot, drift = np.array([0.5, 0.5]), np.array([0.4, -0.2])
    scene = make_scene(robot_position=robot, robot_velocity=drift)
    turned = make_scene(robot_position=transform(X, robot), robot_velocity=transform(turn, drift))
    after = Orca(FREE).step(crowd, scene, 0.05, np.random.default_rng(0))
    other = Orca(FREE).step(rotated, turned, 0.05, np.random.default_rng(0))
    np.testing.assert_allclose(other.position, transform(X, after.position), atol=1e-6)


@BUILT_ONCE
@given(seed=st.integers(0, 10**6))
def test_who_is_far_away_changes_nothing(make_crowd, make_scene, seed):
    crowd = random_crowd(make_crowd, seed)
    more = make_crowd(
        np.vstack([crowd.position, [20.0, 0.0]]),
        np.concatenate([crowd.waypoints, [[[0.0, 0.0]]]]),
        velocity=np.vstack([crowd.velocity, [-1.0, 0.0]]),
        sees_robot=np.ones(7, dtype=bool),
    )
    alone = Orca(FREE).step(crowd, make_scene(), 0.05, np.random.default_rng(0))
    with_far = Orca(FREE).step(more, make_scene(), 0.05, np.random.default_rng(0))
    np.testing.assert_array_equal(with_far.position[:-1], alone.position)


def nearest_to_robot(make_crowd, make_scene, *, sees, share):
    robot = np.array([4.0, 0.05])
    crowd = make_crowd([[0.0, 0.0]], [[[8.0, 0.0]]], sees_robot=np.array([sees]))
    scene = make_scene(robot_position=robot, robot_radius=0.5)
    model = Orca(Orca.Parameters(walls=False, robot_responsibility=share))
    return min(np.hypot(*(c.position[0] - robot)) for c in walk(model, crowd, scene, 10.0))


def test_only_those_who_see_the_robot_avoid_it(make_crowd, make_scene):
    assert nearest_to_robot(make_crowd, make_scene, sees=False, share=0.5) < 0.1
    # body 0.25, robot 0.5 m: one who takes all on stays clear of a robot that stands
    assert nearest_to_robot(make_crowd, make_scene, sees=True, share=1.0) >= 0.75 - 1e-3
    assert nearest_to_robot(make_crowd, make_scene, sees=True, share=0.5) >= 0.70


def met_by_robot(make_crowd, make_scene, headway, *, speed, sees=True, y=0.0, **scene):
    """Positions (k, 2) of a person in front of a robot in its own frame, walking towards it."""
    crowd = make_crowd([[8.0, 0.1]], [[[-30.0, 0.1]]], sees_robot=np.array([sees]))
    model = Orca(Orca.Parameters(robot_headway=headway, walls="grid" in scene))
    rng, out = np.random.default_rng(0), []
    for k in range(200):
        robot = np.array([0.05 * k * speed, y])
        velocity = np.array([speed, 0.0])
        here = make_scene(robot_position=robot, robot_velocity=velocity, **scene)
        crowd = model.step(crowd, here, 0.05, rng)
        out.append(crowd.position[0] - robot)
    return np.array(out)


@pytest.mark.parametrize("speed", [0.5, 1.0, 3.0])
def test_people_leave_an_approaching_robot_more_room_the_faster_it_is(
    make_crowd, make_scene, speed
):
    gaps = [
        np.hypot(*met_by_robot(make_crowd, make_scene, h, speed=speed).T).min() for h in (0.0, 0.5)
    ]
    # Less than the whole distance covered in 0.5 s, since beside a person it approaches no more.
    assert 0.2 * speed <= gaps[1] - gaps[0] <= 0.5 * speed


@pytest.mark.parametrize(("sees", "speed"), [(True, 0.0), (False, 1.0)])
def test_a_robot_that_stands_or_is_not_seen_changes_not_a_bit(make_crowd, make_scene, sees, speed):
    walks = [met_by_robot(make_crowd, make_scene, h, speed=speed, sees=sees) for h in (0.0, 5.0)]
    np.testing.assert_array_equal(*walks)


def test_people_pass_an_oncoming_chair_in_a_corridor_of_two_metres(
    make_crowd, make_scene, make_grid
):
    walls = ((0.0, 0.0, 60.0, 0.5), (0.0, 2.5, 60.0, 3.0))
    grid = make_grid(60.0, 3.0, walls, X_MG=(-40.0, -1.5, 0.0))
    found = met_by_robot(
        make_crowd, make_scene, 0.5, speed=0.9, y=-0.4, grid=grid, robot_radius=0.63
    )
    assert (np.diff(found[:, 0]) < -0.9 * 0.05).all()  # never backwards, seen from the floor
    assert found[-1, 0] < -1.0


def test_nobody_there_is_ordinary(make_crowd, make_scene):
    crowd = make_crowd([], [])
    after = Orca().step(crowd, make_scene(), 0.05, np.random.default_rng(0))
    assert after.position.shape == (0, 2)


def test_the_defaults_are_these():
    assert Orca.Parameters().model_dump() == {
        "neighbor_dist": 10.0,
        "max_neighbors": 10,
        "time_horizon": 5.0,
        "time_horizon_obstacles": 0.5,
        "max_speed_factor": 1.3,
        "extra_radius": 0.01,
        "walls": True,
        "robot_responsibility": 0.5,
        "robot_clearance": 0.15,
        "robot_headway": 0.5,
        "robot_outline": False,
        "perturbation": 1.0,
        "agility": 6.0,
        "turn_time": 0.3,
    }
