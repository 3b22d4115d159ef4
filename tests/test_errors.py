import inspect

import pytest

from cohelm import errors
from cohelm.messages import Reason

CODES = {
    "CohelmError": "cohelm",
    "BuildingError": "building",
    "ConfigError": "config",
    "ControlError": "control",
    "GoalBlocked": "goal_blocked",
    "Infeasible": "infeasible",
    "InvalidProblem": "invalid_problem",
    "MapError": "map",
    "NoPath": "no_path",
    "NoRoute": "no_route",
    "OutsideMap": "outside_map",
    "PlanningError": "planning",
    "PlanningTimeout": "planning_timeout",
    "PlatformError": "platform",
    "PluginError": "plugin",
    "RecordingError": "recording",
    "ScenarioError": "scenario",
    "SolverFailed": "solver_failed",
    "StartBlocked": "start_blocked",
    "StoreError": "store",
    "TooManyWishes": "too_many_wishes",
}
"""Codes cross the wire: one that changes breaks whoever listens."""

TREE = {
    name: cls
    for name, cls in vars(errors).items()
    if inspect.isclass(cls) and issubclass(cls, Exception) and not name.startswith("_")
}


def test_codes_are_as_they_always_were():
    assert {name: cls.code for name, cls in TREE.items()} == CODES


def test_codes_are_unique():
    assert len(set(CODES.values())) == len(CODES)


def test_everything_is_a_cohelm_error():
    assert all(issubclass(cls, errors.CohelmError) for cls in TREE.values())


def test_the_tree_at_the_top_of_the_file_names_every_error():
    for name in TREE:
        assert name in errors.__doc__


@pytest.mark.parametrize(
    ("kind", "parent"),
    [
        (errors.ScenarioError, errors.ConfigError),
        (errors.StartBlocked, errors.PlanningError),
        (errors.GoalBlocked, errors.PlanningError),
        (errors.OutsideMap, errors.PlanningError),
        (errors.NoPath, errors.PlanningError),
        (errors.PlanningTimeout, errors.PlanningError),
        (errors.SolverFailed, errors.ControlError),
        (errors.Infeasible, errors.ControlError),
    ],
)
def test_a_kind_can_be_caught_by_its_parent(kind, parent):
    assert issubclass(kind, parent)


def test_a_config_error_reads_file_key_problem():
    error = errors.ConfigError("unknown", file="a.yaml", key="planner.horizon")
    assert str(error) == "a.yaml: planner.horizon: unknown"
    assert str(errors.ConfigError("unknown")) == "unknown"


def test_a_blocked_goal_carries_its_evidence():
    error = errors.GoalBlocked(point=(1.0, 2.0), clearance=0.12, needed=0.35)
    assert (error.point, error.clearance, error.needed) == ((1.0, 2.0), 0.12, 0.35)
    assert str(error) == "the goal (1.00, 2.00) has 0.12 m of clearance, the robot needs 0.35 m"


def test_a_point_inside_a_wall_is_said_to_be_there():
    error = errors.StartBlocked(point=(0.0, 0.0), clearance=-0.4, needed=0.35)
    assert "lies in a wall, an obstacle or unknown space, the robot needs 0.35 m" in str(error)
    error = errors.GoalBlocked(
        point=(0.0, 0.0), clearance=0.0, needed=0.35, because="a keepout zone"
    )
    assert "the goal (0.00, 0.00) lies in a keepout zone" in str(error)


def test_no_path_and_outside_say_where():
    lost = errors.NoPath(start=(0.0, 0.0), goal=(5.0, 1.0), needed=0.35)
    assert "from (0.00, 0.00) to (5.00, 1.00)" in str(lost)
    out = errors.OutsideMap(what="goal", point=(9.0, 9.0), bounds=(0.0, 0.0, 5.0, 4.0))
    assert "the goal (9.00, 9.00) is outside the map" in str(out)


def test_a_control_error_carries_the_problem():
    evidence = object()
    assert errors.SolverFailed("no answer", evidence=evidence).evidence is evidence


def test_every_planning_error_that_reaches_a_rider_has_a_sentence():
    words = {reason.value for reason in Reason}
    told = {"start_blocked", "goal_blocked", "outside_map", "no_path", "planning", "solver_failed"}
    assert told <= words
