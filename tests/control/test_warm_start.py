import dataclasses

import numpy as np
import pytest

from cohelm.control.trajectories import limited_trajectory
from cohelm.control.warm_start import estimate_current_input, shifted_plan
from cohelm.messages import LocalPlan, Status
from cohelm.testing.scenes import local_problem


def plan_of(problem, inputs, *, time=0.0):
    return LocalPlan(
        time=time,
        step=problem.reference.step,
        command=problem.robot.motion_model.twist(inputs[0]),
        poses=problem.robot.motion_model.rollout(problem.pose, inputs, problem.reference.step),
        inputs=inputs,
        status=Status.OK,
    )


def test_a_plan_is_shifted_by_interpolation():
    """0.5, 0.6, 0.7 … m/s every 0.2 s; 0.05 s later that is 0.525, 0.625 …, the last one held."""
    problem = local_problem(steps=5, step=0.2, speed=0.5)
    inputs = np.column_stack([0.5 + 0.1 * np.arange(5), np.zeros(5)])
    later = dataclasses.replace(problem, time=0.05)
    trajectory = shifted_plan(later, plan_of(problem, inputs), np.array([0.5, 0.0]))
    assert trajectory.inputs[:, 0] == pytest.approx([0.525, 0.625, 0.725, 0.825, 0.9])
    assert np.array_equal(trajectory.poses[0], problem.pose)


@pytest.mark.parametrize("elapsed", [-0.1, 0.6])
def test_a_plan_of_another_time_is_no_seed(elapsed):
    problem = local_problem(steps=5, step=0.2)
    plan = plan_of(problem, np.zeros((5, 2)))
    assert shifted_plan(dataclasses.replace(problem, time=elapsed), plan, np.zeros(2)) is None


def test_no_plan_or_one_of_another_length_is_no_seed():
    problem = local_problem(steps=5, step=0.2)
    assert shifted_plan(problem, None, np.zeros(2)) is None
    assert shifted_plan(problem, plan_of(problem, np.zeros((7, 2))), np.zeros(2)) is None


def test_without_a_plan_the_wheels_do_what_odometry_says():
    problem = local_problem(steps=5, step=0.2, speed=0.37)
    assert estimate_current_input(problem, None).tolist() == [0.37, 0.0]


def test_a_command_that_odometry_bears_out_is_believed():
    """Measured 0.37, commanded 0.40: within what lag and noise can do."""
    problem = local_problem(steps=5, step=0.2, speed=0.37)
    plan = plan_of(problem, np.tile([0.4, 0.0], (5, 1)))
    assert estimate_current_input(dataclasses.replace(problem, time=0.05), plan).tolist() == [
        0.4,
        0.0,
    ]


def test_a_command_that_was_overruled_is_not():
    """Commanded 1 m/s, but the chair stands: what 0.1 s and the lag can do, and 2 cm/s of noise."""
    problem = local_problem(steps=5, step=0.2, speed=0.0)
    robot = problem.robot
    plan = plan_of(problem, np.tile([1.0, 0.0], (5, 1)))
    most = max(robot.max_acceleration, robot.max_deceleration) * (0.1 + robot.actuation_lag) + 0.02
    now = estimate_current_input(dataclasses.replace(problem, time=0.05), plan)
    assert now[0] == pytest.approx(most)


def test_wild_inputs_are_tamed():
    problem = local_problem(steps=4, step=0.5)
    trajectory = limited_trajectory(problem, np.tile([9.0, -9.0], (4, 1)), np.zeros(2))
    # 0.8 m/s² and 2.5 rad/s², 0.05 s for the first; up to the problem's 1 m/s and 1.2 rad/s
    assert trajectory.inputs[:, 0] == pytest.approx([0.04, 0.44, 0.84, 1.0])
    assert trajectory.inputs[:, 1] == pytest.approx([-0.125, -1.2, -1.2, -1.2])


def test_a_command_that_the_gate_replaced_is_no_start():
    """Planned 0.6, sent 0: the wheels brake, so measured 0.47 is 0.47 − (1.0 × 0.18 + 0.02) m/s at
    least, and no plan begins at 0.6."""
    problem = local_problem(steps=5, step=0.2, speed=0.47)
    plan = plan_of(problem, np.tile([0.6, 0.0], (5, 1)))
    now = dataclasses.replace(problem, time=0.05, commanded=np.zeros(3))
    delay = 0.1 + problem.robot.actuation_lag
    lowest = 0.47 - problem.robot.max_deceleration * delay - 0.02
    assert estimate_current_input(now, plan) == pytest.approx([lowest, 0.0])
    assert estimate_current_input(dataclasses.replace(now, commanded=None), plan)[0] == 0.6
