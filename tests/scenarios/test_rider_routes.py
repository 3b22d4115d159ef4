"""The rider's own destination and route."""

import numpy as np
import pytest

from cohelm.errors import ConfigError
from cohelm.scenarios.build import build_scenario
from cohelm.scenarios.scenario import load_scenario


def stage(*settings):
    return build_scenario(load_scenario("empty", settings), 0)


def test_a_rider_wants_what_the_chair_does_unless_told_otherwise():
    found = stage("rider=ideal")
    np.testing.assert_array_equal(found.world.rider_route, found.route.points)
    np.testing.assert_array_equal(found.world.rider_goal, found.route.points[-1])


def test_a_goal_of_the_riders_own_has_a_way_of_its_own():
    home = stage("rider=ideal")
    goal = home.start[:2] + np.ones(2)
    found = stage("rider=ideal", f"rider_goal=[{goal[0]}, {goal[1]}]")
    np.testing.assert_array_equal(found.request.goal, home.request.goal)
    np.testing.assert_array_equal(found.route.points, home.route.points)
    np.testing.assert_allclose(found.world.rider_goal, goal)
    np.testing.assert_allclose(found.world.rider_route[0], home.start[:2], atol=0.1)


def test_a_route_of_the_riders_own_leads_from_the_start_to_the_goal():
    home = stage("rider=ideal")
    found = stage("rider=ideal", "rider_route=[[3, 9], [5, 9]]")
    ends = [home.start[:2], [3.0, 9.0], [5.0, 9.0], home.request.goal]
    np.testing.assert_allclose(found.world.rider_route, ends)


def test_riders_upon_riders_are_built_from_a_scenario():
    found = stage("rider={use: tremor, base: {use: delayed, delay: 0.6}}")
    assert found.world.rider.base.parameters.delay == 0.6
    with pytest.raises(ConfigError, match="delya"):
        stage("rider={use: tremor, base: {use: delayed, delya: 0.6}}")
