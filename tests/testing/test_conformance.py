"""Every installed part keeps its contract, and the checks find those that do not."""

import dataclasses

import numpy as np
import pytest

from cohelm import plugins
from cohelm.errors import GoalBlocked
from cohelm.messages import Groups, Status
from cohelm.testing import CHECKS, ConformanceError, check_global_planner, check_local_planner
from cohelm.testing.conformance import require_raises, steady

INSTALLED = [(group, name) for group in plugins.GROUPS for name in plugins.names(group)]


@pytest.mark.parametrize(("group", "name"), INSTALLED)
def test_every_installed_part_keeps_its_contract(group, name):
    CHECKS[group](plugins.build(group, name))


def test_there_is_a_check_for_every_kind_of_part():
    assert set(CHECKS) == set(plugins.GROUPS)


@pytest.mark.parametrize("group", plugins.GROUPS)
def test_something_of_every_kind_is_installed(group):
    assert plugins.names(group)


def each_a_group(_, people, *__):
    return Groups(id=np.arange(len(people)), member=np.arange(len(people)))


class Altered:
    """A part whose one method has its result changed."""

    def __init__(self, part, method, change):
        self.part = part
        setattr(self, method, lambda *args: change(getattr(part, method)(*args), *args))

    def __getattr__(self, name):
        return getattr(self.part, name)


def replace(**fields):
    """The result with fields that depend on it and on the arguments of the call."""
    return lambda result, *args: dataclasses.replace(
        result, **{name: field(result, *args) for name, field in fields.items()}
    )


def sent(**fields):
    """The same for what a rider sends."""
    return lambda act, *args: dataclasses.replace(
        act, command=replace(**fields)(act.command, *args)
    )


def first(change):
    """The same for a part that returns (output, memory)."""
    return lambda result, *args: (change(result[0], *args), result[1])


SOUND = {
    "plan a route": ("global_planners", "astar", "plan"),
    "plan a move": ("local_planners", "path_follower", "plan"),
    "detect": ("detectors", "scan_clusters", "detect"),
    "track": ("trackers", "given", "track"),
    "detect in clouds": ("cloud_detectors", "cloud_clusters", "detect"),
    "group": ("group_detectors", "no_groups", "group"),
    "predict": ("predictors", "constant_velocity", "predict"),
    "shape": ("social_models", "personal_space", "spaces"),
    "walk": ("pedestrian_models", "orca", "step"),
    "steer": ("riders", "ideal", "act"),
    "derive": ("kinematics", "unicycle", "sensitivity"),
    "roll out": ("kinematics", "unicycle", "rollout"),
}

PUSH = np.array([0.5, 0.0, 0.0])
TURN = np.array([0.0, 0.0, 1e-3])
TO_NOWHERE = replace(points=lambda path, _: path.points[:-5])
THROUGH_THE_PILLAR = replace(
    points=lambda _, problem: np.linspace(problem.start, problem.goal, 50),
    length=lambda _, problem: np.hypot(*(problem.goal - problem.start)),
)
NORTH = replace(command=lambda plan, problem, _: plan.command + TURN * np.cos(problem.pose[2]))
GROWING_IDS = replace(id=lambda people, seen, *_: people.id + int(10 * seen.time))
DROPS_A_RETURN = replace(
    points=lambda d, *_: d.points[1:],
    detection_of_return=lambda d, *_: d.detection_of_return[1:],
    mapped=lambda d, *_: d.mapped[1:],
    cluster_of_return=lambda d, *_: d.cluster_of_return[1:],
)
SEES = replace(velocity=lambda crowd, _, scene, *args: crowd.velocity + scene.robot_position)

FAULTS = [
    ("plan a route", TO_NOWHERE, "from start to goal"),
    ("plan a route", replace(length=lambda path, _: path.length + 0.1), "length"),
    ("plan a route", THROUGH_THE_PILLAR, "of a wall"),
    ("plan a move", replace(command=lambda plan, *_: plan.command * np.nan), "finite"),
    ("plan a move", replace(command=lambda plan, *_: plan.command + PUSH), "limit|jump"),
    ("plan a move", replace(command=lambda _, problem, __: problem.twist), "must make progress"),
    ("plan a move", replace(status=lambda *_: Status.STOP), "must have a reason"),
    ("plan a move", NORTH, "90°"),
    ("detect", DROPS_A_RETURN, "returns"),
    ("detect", replace(position=lambda d, *_: d.position + 0.5), "find the person"),
    ("track", first(replace(id=lambda people, *_: 0 * people.id)), "share an id"),
    ("track", first(GROWING_IDS), "id from call to call"),
    ("track", first(replace(covariance=lambda people, *_: -people.covariance)), "negative"),
    ("predict", first(replace(weight=lambda p, *_: 0.5 * p.weight)), "sum to 1"),
    ("predict", first(replace(mean=lambda p, *_: p.mean + 0.1)), "present position of people"),
    ("predict", first(replace(deviation=lambda p, *_: p.deviation[..., ::-1])), "not decrease"),
    ("detect in clouds", replace(time=lambda d, *_: d.time + 1.0), "first cloud's time"),
    ("group", first(lambda groups, people, *_: Groups.alone(len(people) + 1)), "a group or none"),
    ("group", first(each_a_group), "two members"),
    ("shape", replace(side=lambda spaces, *_: 0.0 * spaces.side), "positive"),
    ("shape", replace(floor=lambda *_: 0.1), "social distance"),
    ("shape", replace(rear=lambda spaces, *_: 0.5 * spaces.rear), "circle"),
    ("walk", replace(position=lambda crowd, *_: crowd.position + 1.0), "as fast as preferred"),
    ("walk", replace(target=lambda crowd, *_: 0 * crowd.target), "reach the way-point"),
    ("walk", SEES, "does not see the robot"),
    ("steer", sent(deflection=lambda command, *_: 2.0 + command.deflection), "deflection"),
    ("steer", sent(heartbeat=lambda _, view, *__: view.time + 1.0), "later than now"),
    ("derive", lambda sensitivity, *_: 1.001 * sensitivity, "finite differences"),
    ("roll out", lambda poses, *_: poses + 0.01, "begin at"),
]


@pytest.mark.parametrize(
    ("what", "change", "says"), FAULTS, ids=[f"{w}: {s}" for w, _, s in FAULTS]
)
def test_a_fault_is_found_and_named(what, change, says):
    group, name, method = SOUND[what]
    with pytest.raises(ConformanceError, match=says):
        CHECKS[group](Altered(plugins.build(group, name), method, change))


class Forgetful:
    """Gives every time something else."""

    steps, step = 10, 0.1

    def __init__(self, part):
        self.part, self.calls = part, 0

    def plan(self, *args):
        self.calls += 1
        plan = self.part.plan(*args)
        return dataclasses.replace(plan, cost=plan.cost + self.calls)


def test_hidden_state_is_found():
    with pytest.raises(ConformanceError, match="equal results for equal arguments"):
        check_global_planner(Forgetful(plugins.build("global_planners", "astar")))


class WrongError:
    def plan(self, problem):
        raise ValueError("no")


def test_an_untyped_error_is_found_with_its_cause():
    with pytest.raises(ConformanceError, match="must raise GoalBlocked, raised ValueError: no"):
        require_raises(GoalBlocked, lambda: WrongError().plan(None), "a goal in a wall")


def test_no_error_at_all_is_found():
    with pytest.raises(ConformanceError, match="returned int"):
        require_raises(GoalBlocked, lambda: 3, "a goal in a wall")


def test_a_changed_argument_is_found():
    argument = np.zeros(3)

    def fill():
        argument[:] = 1.0

    with pytest.raises(ConformanceError, match="must not change its arguments"):
        steady(fill, inputs=argument, what="fill", within=1.0)


def test_a_part_that_hangs_is_found():
    with pytest.raises(ConformanceError, match="of CPU time"):
        steady(lambda: sum(range(100_000)), inputs=(), what="sum", within=0.0)


class NoSteps:
    steps, step = 0, 0.1


def test_a_horizon_of_nothing_is_refused():
    with pytest.raises(ConformanceError, match="steps"):
        check_local_planner(NoSteps())
