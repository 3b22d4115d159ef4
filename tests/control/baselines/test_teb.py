import dataclasses

import numpy as np
import pytest

from cohelm.control.baselines import Teb
from cohelm.control.baselines import teb as module
from cohelm.control.baselines.teb import _BAND, _assembled, _solved
from cohelm.control.baselines.teb_band import _FEWEST, band_along_reference, resized, shifted_band
from cohelm.maps import distance_field
from cohelm.messages import Reason, Status
from cohelm.robots import load_robot
from cohelm.testing.scenes import local_problem, room, walkers

PLANNER = Teb()
STEPS, STEP = PLANNER.steps, PLANNER.step


def problem(**scene):
    return local_problem(steps=STEPS, step=STEP, **scene)


@pytest.fixture
def asked(monkeypatch):
    """What the optimisation is given in a room with people, and a band beside its optimum."""
    seen = {}
    optimise = module.optimise

    def spy(*arguments):
        seen["arguments"] = arguments
        return optimise(*arguments)

    monkeypatch.setattr(module, "optimise", spy)
    walls = distance_field(room(boxes=[(4.6, 3.2, 5.0, 3.6)]))
    people = walkers([[5.5, 4.4, 0.0, 0.0], [4.0, 5.0, 0.0, 0.0]])  # gaps do not hang on times
    here = problem(walls=walls, people=people, pose=(3.0, 4.0, 0.1), speed=0.4)
    PLANNER.plan(here, None)
    band = band_along_reference(here, 0.2)
    band[:, :3] += np.random.default_rng(0).normal(0.0, 0.02, (len(band), 3))
    weights, task = seen["arguments"][1:]
    return band, (weights, weights.obstacles, task)


def test_the_slope_is_that_of_the_cost(asked):
    band, rest = asked
    size = 4 * len(band)

    def cost(rows):
        matrix, right = np.zeros((size, _BAND)), np.zeros(size)
        return _assembled(rows, matrix, right, *rest), right

    value, right = cost(band)
    assert value > 0.0
    for i in range(size):
        higher, lower = band.copy(), band.copy()
        higher[i // 4, i % 4] += 1e-6
        lower[i // 4, i % 4] -= 1e-6
        slope = (cost(higher)[0] - cost(lower)[0]) / 2e-6
        # forward differences inside: wrong by about ½ · 1e-6 · curvature
        assert right[i] == pytest.approx(slope, rel=1e-3, abs=2e-2)


def test_the_banded_solution_is_the_dense_one(asked):
    band, rest = asked
    size = 4 * len(band)
    matrix, right = np.zeros((size, _BAND)), np.zeros(size)
    _assembled(band, matrix, right, *rest)
    dense = np.zeros((size, size))
    for i in range(size):
        for d in range(min(_BAND, i + 1)):
            dense[i, i - d] = dense[i - d, i] = matrix[i, d]
    dense += 0.1 * np.eye(size)
    free = np.s_[3:]
    expected = np.linalg.solve(dense[free, free], right[free])
    step = _solved(matrix, right, 0.1)
    assert step[:3] == pytest.approx(0.0)  # the first pose is where the robot is
    assert step[free] == pytest.approx(expected, rel=1e-8, abs=1e-10)


def test_a_band_gets_poses_where_its_intervals_are_long_and_keeps_its_time():
    rows = np.array([[0.0, 0, 0, 1.0], [1.0, 0, 0, 0.05], [1.1, 0, 0, 0.05], [1.2, 0, 0, 0.05],
                     [1.3, 0, 0, 0.2]])  # fmt: skip
    out = resized(rows, 0.2, 0.06)
    assert out[:-1, 3].sum() == pytest.approx(rows[:-1, 3].sum())
    assert len(resized(out, 0.2, 0.06)) > 3
    assert out[0, 3] == pytest.approx(0.5)
    assert out[-1, :3] == pytest.approx(rows[-1, :3])


def test_alone_the_way_is_driven_about_as_fast_as_the_limits_allow():
    # from rest to 2.4 m − 0.8 m/s · ramp: v²/2a up to the speed limit of 1 m/s, less the margin
    plan = PLANNER.plan(problem(), None)
    rows = plan.memory.rows
    length = float(np.hypot(*np.diff(rows[:, :2], axis=0).T).sum())
    fastest, rise = 0.95, load_robot("quantum_q6_edge").max_acceleration
    least = fastest / rise + (length - 0.5 * fastest**2 / rise) / fastest
    assert least * 0.95 < rows[:-1, 3].sum() < least * 1.35


def test_who_stands_a_little_to_one_side_is_passed_on_the_other_and_mirrored():
    states = np.array([[2.0, 0.12, 0.0, 0.0]])
    right = PLANNER.plan(problem(people=walkers(states), speed=0.5), None)
    left = PLANNER.plan(problem(people=walkers(states * [1, -1, 1, 1]), speed=0.5), None)
    assert right.poses[:, 1].min() < -0.05
    assert left.command == pytest.approx(right.command * [1.0, 1.0, -1.0], abs=1e-6)


def test_it_stays_on_the_side_that_it_has_begun_to_pass_on():
    sides, plan = [], None
    for k, y in enumerate([0.1, 0.02, -0.02, -0.05]):
        here = problem(people=walkers([[2.0, y, 0.0, 0.0]]), speed=0.5)
        plan = PLANNER.plan(dataclasses.replace(here, time=0.05 * k), plan)
        sides.append(np.sign(plan.memory.rows[:, 1].sum()))
    assert len(set(sides)) == 1


def test_far_people_change_nothing():
    alone = PLANNER.plan(problem(speed=0.5), None)
    with_one = PLANNER.plan(problem(people=walkers([[30.0, 5.0, 0.0, 0.0]]), speed=0.5), None)
    assert np.array_equal(alone.command, with_one.command)


def test_it_brakes_and_says_so_where_the_band_touches():
    walls = distance_field(room(boxes=[(6.0, 0.0, 6.4, 8.0)]))
    plan = PLANNER.plan(problem(walls=walls, pose=(5.0, 4.0, 0.0), speed=1.0), None)
    assert plan.status is Status.STOP
    assert plan.reason is Reason.NO_SAFE_PLAN
    assert plan.command[0] < 1.0


def test_a_robot_that_moves_any_way_may_step_aside():
    robot = load_robot("quantum_q6_edge").model_copy(update={"kinematics": "holonomic"})
    plan = PLANNER.plan(problem(robot=robot, people=walkers([[2.0, 0.1, 0.0, 0.0]])), None)
    assert plan.inputs.shape[1] == 3
    assert np.abs(plan.inputs[:, 1]).max() > 0.02
    assert np.hypot(*plan.inputs[:, :2].T).max() <= 1.0 + 1e-6


def test_a_band_of_two_poses_is_begun_anew():
    """Near the goal, late in a ride, a band may have shrunk to that."""
    here = problem(pose=(3.0, 4.0, 0.1), speed=0.4)
    rows = band_along_reference(here, 0.2)
    for count in range(1, _FEWEST):
        old = module.Band(time=here.time, rows=rows[-count:], side=0.0, other=np.empty((0, 4)))
        assert shifted_band(here, old, old.rows) is None
