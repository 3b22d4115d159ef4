import dataclasses
import math

import numpy as np
import pytest

from cohelm.control.baselines import Dwa, dwa
from cohelm.control.baselines.dwa import (
    DwaWeights,
    DynamicWindow,
    drive,
    ramp,
    velocity_costs,
)
from cohelm.control.baselines.polyline import nearest_on_polyline
from cohelm.maps import distance_field
from cohelm.messages import Reason, Status
from cohelm.robots import load_robot
from cohelm.robots.wall_contact import wall_grid
from cohelm.testing.scenes import local_problem, room, walkers

PLANNER = Dwa()
STEPS, STEP = PLANNER.steps, PLANNER.step


def problem(**scene):
    return local_problem(steps=STEPS, step=STEP, **scene)


def test_a_velocity_is_admissible_where_braking_ends_before_the_wall():
    # Fox et al., eq. (14): v ≤ √(2 · dist · b); the wall is x = 6, the chair's nose 0.65 m ahead
    robot = load_robot("quantum_q6_edge")
    walls = distance_field(room(boxes=[(6.0, 0.0, 6.4, 8.0)]))
    gap, margin, reaction, brake = 0.45, 0.04, 0.2, robot.max_deceleration
    nose = robot.discs[-1, 0] + robot.discs[-1, 2]
    start = np.array([6.0 - gap - nose, 4.0, 0.0])

    def admissible(v):
        window = DynamicWindow(
            current_input=np.array([v, 0.0]),
            rise=np.ones(2),
            fall=np.ones(2),
            twists=robot.motion_model.twist(np.eye(2)),
            start=start,
            steps=40,
            step=0.05,
            path=np.array([[0.0, 4.0], [12.0, 4.0]]),
            capsule=robot.capsule,
            discs=robot.discs,
            people=np.empty((0, 41, 2)),
            radius=np.empty(0),
            walls=wall_grid(walls),
        )
        weights = DwaWeights(margin, 0.2, 0.5, reaction, brake, 2.5, *np.ones(7).tolist())
        cost = velocity_costs(np.array([[v, 0.0]]), window, weights, np.zeros(2))
        return bool(np.isfinite(cost[0]))

    # v·reaction + v²/2b = gap − margin, and up to two simulated steps beyond it
    for v in np.arange(0.3, 1.2, 0.03):
        spare = gap - margin - v * reaction - 0.5 * v * v / brake
        if spare > 0.02:
            assert admissible(v), v
        if spare < -2.0 * v * 0.05 - 0.02:
            assert not admissible(v), v


def test_the_path_is_as_far_as_its_nearest_segment_and_the_rest_is_what_is_left():
    path = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 3.0]])
    distance, left, x, y = nearest_on_polyline(path, 0.5, 0.4)
    assert (distance, left, x, y) == pytest.approx((0.4, 1.5 + 3.0, 0.5, 0.0))


def test_a_simulated_arc_is_a_circle():
    inputs, poses = np.tile([0.5, 0.5], (60, 1)), np.empty((61, 3))
    drive(np.zeros(3), inputs, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), 0.05, poses)
    # radius v/ω = 1 m about (0, 1), for 3 s
    assert np.hypot(poses[:, 0], poses[:, 1] - 1.0) == pytest.approx(1.0, abs=1e-3)
    assert poses[-1, 2] == pytest.approx(1.5)


def test_a_ramp_rises_by_half_a_step_first():
    inputs = np.empty((4, 1))
    ramp(np.array([0.3]), np.zeros(1), np.array([0.1]), np.array([0.2]), inputs)
    assert inputs.ravel() == pytest.approx([0.05, 0.15, 0.25, 0.3])


def test_who_walks_away_is_followed_only_where_that_is_foreseen():
    people = walkers([[1.9, 0.0, 0.8, 0.0]])
    foreseen = PLANNER.plan(problem(people=people, speed=0.8), None)
    still = Dwa(Dwa.Parameters(predict=False)).plan(problem(people=people, speed=0.8), None)
    assert foreseen.poses[-1, 0] > still.poses[-1, 0] + 0.2


def test_a_mirrored_world_mirrors_the_command():
    states = np.array([[2.2, 0.25, 0.0, 0.0], [3.5, -1.5, 0.0, 0.5]])
    plain = PLANNER.plan(problem(people=walkers(states), speed=0.5), None).command
    other = PLANNER.plan(problem(people=walkers(states * [1, -1, 1, -1]), speed=0.5), None).command
    assert abs(plain[2]) > 0.01
    assert other == pytest.approx(plain * [1.0, 1.0, -1.0], abs=1e-9)


def test_far_people_change_nothing():
    alone = PLANNER.plan(problem(speed=0.5), None)
    with_one = PLANNER.plan(problem(people=walkers([[30.0, 5.0, 0.0, 0.0]]), speed=0.5), None)
    assert np.array_equal(alone.command, with_one.command)


def test_it_brakes_and_says_so_where_nothing_is_admissible():
    walls = distance_field(room(boxes=[(6.0, 0.0, 6.4, 8.0)]))
    plan = PLANNER.plan(problem(walls=walls, pose=(5.0, 4.0, 0.0), speed=1.0), None)
    assert plan.status is Status.STOP
    assert plan.reason is Reason.NO_SAFE_PLAN
    assert plan.command[0] < 1.0


def test_it_backs_up_only_with_permission():
    walls = distance_field(room(boxes=[(6.0, 0.0, 6.4, 8.0)]))
    stuck = problem(walls=walls, pose=(5.28, 4.0, 0.0))
    assert PLANNER.plan(stuck, None).command[0] >= 0.0
    allowed = dataclasses.replace(stuck, reverses=True)
    low, _, _, _ = allowed.input_bounds()
    assert low[0] < 0.0
    assert PLANNER.plan(allowed, None).inputs[:, 0].min() >= low[0]


def test_a_robot_that_moves_any_way_keeps_the_norm_of_its_speed():
    robot = load_robot("quantum_q6_edge").model_copy(update={"kinematics": "holonomic"})
    plan = PLANNER.plan(problem(robot=robot, people=walkers([[2.0, 0.1, 0.0, 0.0]])), None)
    assert plan.inputs.shape[1] == 3
    assert np.hypot(*plan.inputs[:, :2].T).max() <= 1.0 + 1e-9
    assert math.isfinite(plan.costs["critics"])


def test_it_comes_to_the_goal_and_not_only_near_it():
    # the reference ends 0.3 m ahead; the footprint's nose is far beyond it already
    here = problem()
    along = np.minimum(0.8 * STEP * np.arange(STEPS + 1), 0.3)
    poses = np.column_stack([along, np.zeros((STEPS + 1, 2))])
    speeds = np.where(along < 0.3, 0.3, 0.0)
    near = dataclasses.replace(here.reference, poses=poses, speeds=speeds)
    plan = PLANNER.plan(dataclasses.replace(here, reference=near), None)
    assert plan.poses[-1, 0] == pytest.approx(0.3, abs=0.08)


def test_a_velocity_that_is_given_up_would_be_dearer_than_the_one_driven(monkeypatch):
    asked = []
    monkeypatch.setattr(
        dwa, "velocity_costs", lambda *args: asked.append(args) or velocity_costs(*args)
    )
    people = walkers([[3.0, 0.3, -0.8, 0.1], [2.0, -1.5, 0.3, 0.6]])
    PLANNER.plan(problem(people=people, speed=0.5), None)
    (args,) = asked
    together = velocity_costs(*args)
    alone = np.array([velocity_costs(each[None], *args[1:])[0] for each in args[0]])
    kept = np.isfinite(together)
    assert (together[kept] == alone[kept]).all()
    assert 0 < kept.sum() < np.isfinite(alone).sum()
    assert alone[~kept].min() > alone.min() == together.min()
