"""Every planner refuses an invalid problem with a typed error."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm import plugins
from cohelm.errors import InvalidProblem, OutsideMap
from cohelm.maps import CostmapFilter, OccupancyGrid
from cohelm.messages import Crowding, Wish
from cohelm.testing.global_planners import route_problem
from cohelm.testing.scenes import room

TASK = route_problem(room())
NAN = float("nan")
METHODS = plugins.names("global_planners")


def mask(resolution=0.1, **numbers):
    grid = OccupancyGrid(data=np.zeros((5, 5)), resolution=resolution, X_MG=np.zeros(3))
    return CostmapFilter(type="keepout", mask=grid, **numbers)


def crowd(resolution=0.5, people=0.1, x=0.0):
    return Crowding(
        density=np.full((3, 3), people), resolution=resolution, X_MG=np.array([x, 0.0, 0.0])
    )


WRONG = {
    "a negative radius": {"wishes": (Wish(kind="avoid", points=[[5, 3]], radius=-2.0),)},
    "no radius": {"wishes": (Wish(kind="avoid", points=[[5, 3]], radius=NAN, hard=True),)},
    "an endless radius": {"wishes": (Wish(kind="avoid", points=[[5, 3]], radius=np.inf),)},
    "no clearance": {"clearance": NAN},
    "a negative clearance": {"clearance": -0.1},
    "wished from nowhere": {"wish_origin": np.array([NAN, 4.0])},
    "a group nowhere": {"groups": (np.array([[1.0, NAN], [2.0, 2.0]]),)},
    "crowding without cells": {"crowding": crowd(resolution=0.0)},
    "crowding without numbers": {"crowding": crowd(people=NAN)},
    "crowding nowhere": {"crowding": crowd(x=NAN)},
    "a mask without cells": {"filters": (mask(resolution=0.0),)},
    "a mask without a base": {"filters": (mask(base=NAN),)},
    "a mask without bounds": {"filters": (mask(multiplier=np.inf),)},
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("what", WRONG)
def test_what_cannot_be_meant_is_refused(method, what):
    planner = plugins.build("global_planners", method)
    with pytest.raises(InvalidProblem):
        planner.plan(replace(TASK, **WRONG[what]))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", ["attract", "stroke", "avoid"])
@pytest.mark.parametrize("x", [NAN, np.inf, 1e18, -1e300])
def test_a_wish_is_somewhere_on_earth(method, kind, x):
    wish = Wish(kind=kind, points=np.array([[1.0, 1.0], [x, 2.0]]))
    with pytest.raises(OutsideMap, match=f"wish \\({kind}\\)"):
        plugins.build("global_planners", method).plan(replace(TASK, wishes=(wish,)))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", ["attract", "stroke"])
def test_a_wish_may_lie_far_off_the_map(method, kind):
    wish = Wish(kind=kind, points=np.array([[1e6, 1.0], [1e7, 2.0]]))
    path = plugins.build("global_planners", method).plan(replace(TASK, wishes=(wish,)))
    assert np.isfinite(path.cost)
