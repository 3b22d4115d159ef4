import dataclasses

import numpy as np
import pytest

from cohelm.control.validation import check_problem
from cohelm.control.warm_start import estimate_current_input
from cohelm.errors import Infeasible
from cohelm.maps import DistanceField
from cohelm.messages import GroupSpaces
from cohelm.plugins import build, names
from cohelm.robots import load_robot
from cohelm.testing.scenes import local_problem, walkers

PLANNERS = [build("local_planners", name) for name in names("local_planners")]
BY_NAME = pytest.mark.parametrize("planner", PLANNERS, ids=names("local_planners"))


def among_two(planner, **given):
    people = walkers([[3.0, 0.5, -0.8, 0.0], [4.0, -1.0, 0.0, 0.5]])
    return local_problem(steps=planner.steps, step=planner.step, people=people, **given)


def spoiled(value, array):
    """A copy with ``array``'s last number replaced by NaN."""
    out = getattr(value, array).astype(float).copy()
    out[(-1,) * out.ndim] = np.nan
    return dataclasses.replace(value, **{array: out})


FIELDS = {
    "reference": ("poses", "speeds"),
    "people": ("mean", "radius"),
    "predictions": ("mean", "velocity", "deviation", "weight"),
    "spaces": ("axis", "front", "side", "rear", "robot"),
    "walls": ("distance", "X_MG"),
}


@pytest.mark.parametrize("no_number", [np.nan, np.inf, -np.inf, 1e300])
@pytest.mark.parametrize("array", ["pose", "twist"])
def test_a_pose_or_a_twist_that_is_no_number_is_refused(array, no_number):
    problem = among_two(PLANNERS[0])
    broken = dataclasses.replace(problem, **{array: np.array([0.0, 0.0, no_number])})
    with pytest.raises(Infeasible, match=array):
        check_problem(broken)


@pytest.mark.parametrize(("part", "array"), [(p, a) for p, each in FIELDS.items() for a in each])
def test_one_number_that_is_none_anywhere_is_refused(part, array):
    problem = among_two(PLANNERS[0])
    broken = dataclasses.replace(problem, **{part: spoiled(getattr(problem, part), array)})
    with pytest.raises(Infeasible):
        check_problem(broken)


@pytest.mark.parametrize("name", ["time", "late", "speed_limit"])
def test_a_scalar_that_is_none_is_refused(name):
    with pytest.raises(Infeasible):
        check_problem(dataclasses.replace(among_two(PLANNERS[0]), **{name: np.nan}))


def test_group_spaces_count_too():
    problem = among_two(PLANNERS[0])
    states = len(problem.reference.poses)
    support = np.full((1, states, 8), np.nan)
    groups = GroupSpaces(id=np.array([1]), direction=np.arange(8) * np.pi / 4, support=support)
    spaces = dataclasses.replace(problem.spaces, groups=groups)
    with pytest.raises(Infeasible, match="groups"):
        check_problem(dataclasses.replace(problem, spaces=spaces))


def test_lengths_that_do_not_agree_are_refused():
    problem = among_two(PLANNERS[0])
    shorter, fewer = problem.truncated(3), local_problem(steps=PLANNERS[0].steps, step=0.2)
    nowhere = DistanceField(distance=np.empty((0, 0)), resolution=0.1, X_MG=np.zeros(3))
    for other in (
        dataclasses.replace(problem, predictions=shorter.predictions),
        dataclasses.replace(problem, predictions=fewer.predictions, spaces=fewer.spaces),
        dataclasses.replace(problem, walls=nowhere),
    ):
        with pytest.raises(Infeasible):
            check_problem(other)
    with pytest.raises(Infeasible, match="3 steps"):
        check_problem(shorter, 4)


def test_what_can_be_planned_is_passed_on_cut_to_the_steps():
    problem = among_two(PLANNERS[0])
    check_problem(problem)
    check_problem(problem, 4)
    assert len(problem.truncated(4).reference.poses) == 5
    far = dataclasses.replace(problem, pose=np.array([1e6, -1e6, 0.0]), speed_limit=np.inf)
    check_problem(far)


@BY_NAME
def test_every_planner_refuses_and_never_answers_with_no_number(planner):
    """Compiled loops do not check their indices: NaN must not get there."""
    problem = among_two(planner)
    walls = spoiled(problem.walls, "distance")
    for broken in (
        dataclasses.replace(problem, walls=walls),
        dataclasses.replace(problem, pose=np.array([np.nan, 0.0, 0.0])),
    ):
        with pytest.raises(Infeasible):
            planner.plan(broken, None)


@BY_NAME
@pytest.mark.parametrize("twist", [(5.0, 0.0, 3.0), (-3.0, 0.0, -9.0), (1e6, 0.0, -1e6)])
def test_commands_keep_the_limits_whatever_odometry_says(planner, twist):
    problem = dataclasses.replace(among_two(planner), twist=np.array(twist))
    robot = problem.robot
    low, high, _, _ = robot.motion_model.bounds(robot.limits)
    command = robot.motion_model.input(planner.plan(problem, None).command)
    assert (command >= low - 1e-9).all()
    assert (command <= high + 1e-9).all()


def test_a_robot_that_moves_any_way_is_no_faster_than_it_can_be_in_any_direction():
    robot = load_robot("quantum_q6_edge").model_copy(update={"kinematics": "holonomic"})
    problem = dataclasses.replace(
        local_problem(steps=5, step=0.2, robot=robot), twist=np.array([3.0, -4.0, 0.0])
    )
    vx, vy, _ = estimate_current_input(problem, None)
    assert np.hypot(vx, vy) <= robot.max_speed + 1e-12
    assert vy / vx == pytest.approx(-4.0 / 3.0)
