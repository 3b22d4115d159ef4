"""Features of a route."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.planning.floors import path_of, problem, room

from cohelm.geometry import resample
from cohelm.messages import Crowding
from cohelm.planning.alternatives.features import FeatureParameters, route_features, travel_time
from cohelm.planning.planners.route import GridPlannerParameters
from cohelm.planning.problem import prepare
from cohelm.planning.reference import ComfortLimits


def measured(points, grid=None, measuring=None, **more):
    grid = room(20.0, 10.0, 0.05) if grid is None else grid
    points = np.asarray(points, dtype=float)
    asked = problem(grid, points[0], points[-1], **more)
    ground = prepare(asked, GridPlannerParameters())
    return route_features(ground, path_of(resample(points, 0.1)), measuring)


def test_time_is_speeding_up_cruising_and_braking():
    # a = 0.8 m/s² up to 0.8 m/s and 0.6 m/s² down: each ramp takes half its speed's time more
    line = [(2.0, 5.0), (18.0, 5.0)]
    asked = problem(room(20.0, 10.0), line[0], line[1])
    speed, up, down = 0.8, asked.robot.max_acceleration, 0.6
    expected = 16.0 / speed + 0.5 * speed / up + 0.5 * speed / down
    ground = prepare(asked, GridPlannerParameters())
    measuring = FeatureParameters(speed=speed, comfort=ComfortLimits(deceleration=down))
    assert travel_time(ground, path_of(resample(np.array(line), 0.1)), measuring) == pytest.approx(
        expected, abs=0.2
    )


def test_a_corner_takes_time():
    straight = measured([(2.0, 2.0), (12.0, 2.0)])
    bent = measured([(2.0, 2.0), (7.0, 2.0), (7.0, 7.0)])
    assert bent.length == pytest.approx(straight.length, abs=0.1)
    assert bent.time > straight.time + 0.5


def test_a_path_that_goes_nowhere_takes_no_time():
    point = measured([(5.0, 5.0), (5.0, 5.0)])
    assert (point.length, point.time, point.turns, point.doors) == (0.0, 0.0, 0, 0)


def test_clearance_is_that_to_the_nearest_wall():
    # walls are a cell of 0.05 m thick, so the middle line of 10 m is 4.95 m from them
    route = measured([(6.0, 5.0), (14.0, 5.0)])
    assert route.clearance_min == pytest.approx(4.95, abs=0.05)
    assert route.clearance == FeatureParameters().roomy
    beside = measured([(6.0, 1.05), (14.0, 1.05)])
    assert beside.clearance == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(
    ("corners", "turns"),
    [
        ([(2, 2), (18, 2)], 0),
        ([(2, 2), (10, 2), (10, 8)], 1),
        ([(2, 2), (10, 2), (10, 8), (18, 8)], 2),  # left, then right
        ([(2, 2), (10, 2), (10, 8), (4, 8)], 2),  # twice to the left, 6 m apart
        ([(2, 2), (10, 3), (18, 2)], 0),  # 14° is no turn
    ],
)
def test_turns(corners, turns):
    assert measured(corners).turns == turns


def test_change_of_heading_is_summed():
    there = measured([(2, 2), (10, 2), (10, 8), (18, 8)])
    assert there.heading_change == pytest.approx(np.pi, abs=0.1)


@pytest.mark.parametrize(("width", "doors"), [(0.9, 1), (1.2, 1), (1.6, 0)])
def test_a_door_is_a_narrow_passage(width, doors):
    low, high = 5.0 - width / 2.0, 5.0 + width / 2.0
    grid = room(20.0, 10.0, 0.05, boxes=[(10.0, 0.0, 10.2, low), (10.0, high, 10.2, 10.0)])
    assert measured([(4, 5), (16, 5)], grid).doors == doors


def test_two_doors_are_two_and_a_narrow_corridor_is_one():
    walls = [(x, y0, x + 0.2, y1) for x in (7, 13) for y0, y1 in ((0, 4.5), (5.5, 10))]
    assert measured([(4, 5), (16, 5)], room(20.0, 10.0, 0.05, boxes=walls)).doors == 2
    corridor = [(7, 0, 13, 4.5), (7, 5.5, 13, 10)]
    assert measured([(4, 5), (16, 5)], room(20.0, 10.0, 0.05, boxes=corridor)).doors == 1


def test_passing_something_on_one_side_is_no_door():
    assert measured([(4, 5), (16, 5)], room(20.0, 10.0, 0.05, boxes=[(9, 5.5, 11, 6)])).doors == 0


def test_people_met_are_density_times_the_band():
    # 0.1 people/m² on the right half of a 10 m way: 5 m × 2 m × 0.1 = 1 person
    density = np.zeros((10, 20), dtype=np.float32)
    density[:, 10:] = 0.1
    crowding = Crowding(density=density, resolution=1.0, X_MG=np.zeros(3))
    route = measured([(5, 5), (15, 5)], crowding=crowding)
    assert route.crowding == pytest.approx(0.05, abs=0.002)
    assert route.encounters == pytest.approx(1.0, abs=0.03)
    assert measured([(5, 5), (15, 5)]).encounters == 0.0


def test_nobody_is_known_beyond_the_heat_map():
    crowding = Crowding(
        density=np.full((2, 2), 9.0, dtype=np.float32), resolution=1.0, X_MG=np.array([15, 8, 0.0])
    )
    assert measured([(2, 2), (10, 2)], crowding=crowding).encounters == 0.0


def test_a_turned_map_changes_nothing():
    boxes = [(10.0, 0.0, 10.2, 4.5), (10.0, 5.5, 10.2, 10.0)]
    X_MG = np.array([3.0, -2.0, 0.7])
    from cohelm.geometry import transform

    line = np.array([(4, 5), (16, 5), (16, 8)], dtype=float)
    plain = measured(line, room(20.0, 10.0, 0.05, boxes=boxes))
    turned = measured(transform(X_MG, line), room(20.0, 10.0, 0.05, boxes=boxes, X_MG=X_MG))
    for name in ("length", "time", "clearance", "clearance_min", "turns", "doors"):
        assert getattr(turned, name) == pytest.approx(getattr(plain, name), abs=0.02)


@settings(max_examples=40, deadline=None)
@given(
    aslant=st.floats(-50.0, 50.0),
    off=st.floats(-0.15, 0.15),
    thick=st.sampled_from([0.05, 0.2, 0.6]),
    shift=st.floats(0.0, 0.1),
)
def test_a_door_is_one_however_it_is_taken(aslant, off, thick, shift):
    boxes = [(10.0, 0.0, 10.0 + thick, 4.5), (10.0, 5.5, 10.0 + thick, 10.0)]
    ahead = np.array([np.cos(np.deg2rad(aslant)), np.sin(np.deg2rad(aslant))])
    middle = np.array([10.0 + thick / 2.0, 5.0 + off])
    line = [middle - (2.0 + shift) * ahead, middle + 2.0 * ahead]
    assert measured(line, room(20.0, 10.0, 0.05, boxes=boxes)).doors == 1


def test_a_corner_of_a_room_is_no_door():
    around = [(1.0, 3.0), (0.8, 1.2), (1.2, 0.8), (3.0, 1.0)]
    assert measured(around).doors == 0
