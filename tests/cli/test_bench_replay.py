"""A ride that broke off says where, and by which command it breaks off again."""

import shlex

import pytest

from cohelm.evaluation.sweeps import RideTask, ride_row
from cohelm.evaluation.sweeps.ride_task import ERROR
from cohelm.navigation import Navigator

SETTINGS = ("local_planner.use=path_follower", "goal=[12.0, 7.0]", "tracker.use=given")


def test_a_fault_in_the_middle_of_a_ride_comes_again_by_its_command(monkeypatch, cohelm):
    step = Navigator.step

    def faulty(self, observation, request, previous=None):
        if observation.time > 0.4:
            raise ZeroDivisionError(f"at {observation.time:.2f} s")
        return step(self, observation, request, previous)

    monkeypatch.setattr(Navigator, "step", faulty)
    row = ride_row(RideTask((("scene", "empty"),), "empty", SETTINGS, 3)).row
    assert (row["outcome"], row["error"]) == (ERROR, "ZeroDivisionError: at 0.45 s")
    assert "in faulty" in row["traceback"]
    assert row["traceback"].endswith("ZeroDivisionError: at 0.45 s\n")
    program, *words = shlex.split(row["replay"])
    assert program == "cohelm"
    with pytest.raises(ZeroDivisionError, match=r"at 0\.45 s"):
        cohelm(*words)


def test_a_ride_that_cannot_begin_says_so_both_times(cohelm):
    row = ride_row(RideTask((), "empty", ("goal=[-99.0, 0.0]",), 0)).row
    assert "OutsideMap" in row["traceback"]
    code, _, err = cohelm(*shlex.split(row["replay"])[1:])
    assert code == 2
    assert row["error"].partition(": ")[2] in err.replace("\n", " ")
