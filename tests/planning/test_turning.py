"""The search over (x, y, heading) finds what a chair can drive, and turns where it may."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.maps import signed_distance
from cohelm.planning.chaining import Effort, all_round
from cohelm.planning.dubins import advance, words
from cohelm.planning.footprint import body_on, directions, met_along, turn_between
from cohelm.planning.land import Land, misfits
from cohelm.planning.repairing import fit
from cohelm.planning.search import Weights
from cohelm.planning.smoothing import curvature_of
from cohelm.planning.turning import turn_through

from .floors import CHAIR

RES = 0.05
RADIUS = CHAIR.inscribed_radius


def land_of(blocked):
    clearance = signed_distance(blocked, RES)
    weights = Weights.of(np.where(clearance > RADIUS, 1.0, np.inf).astype(np.float32))
    body = body_on(CHAIR.outline, clearance, RES)
    return Land(
        body=body,
        grown=body_on(1.02 * CHAIR.outline, clearance, RES),
        weights=weights.packed,
        heaviest=weights.heaviest,
        clearance=body.clearance,
        floor=RADIUS,
        radius=RADIUS,
        curvature=CHAIR.max_curvature,
    )


def corridor(width, length=8.0, end=False):
    """A corridor along x in solid walls, from x = 1."""
    blocked = np.ones((80, round((length + 2.0) / RES)), dtype=bool)
    half = round(0.5 * width / RES)
    blocked[40 - half : 40 + half, round(1.0 / RES) : round((1.0 + length) / RES)] = False
    return blocked


def check(land, turned, start, goal):
    points = turned.points
    assert np.allclose(points[[0, -1]], [start[:2], goal[:2]], atol=1e-6)
    assert not misfits(land, points, turned.pivots).any()
    steps = np.hypot(*np.diff(points, axis=0).T)
    assert steps.max() < 0.101


@settings(max_examples=100, deadline=None)
@given(
    pose=st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3.1, 3.1)),
    goal=st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3.1, 3.1)),
    to_point=st.booleans(),
)
def test_words_lead_to_the_goal(pose, goal, to_point):
    start, end = np.array(pose), np.array(goal)
    if to_point:
        end[2] = np.nan
    tried = words(start, end, 0.4)
    found = np.isfinite(tried).all(axis=(1, 2))
    # Arc, line and arc on one side always exists; to a point unless it is inside the circle.
    assert found[:2].all() or to_point
    for word in tried[found]:
        here = start.copy()
        for kappa, length in word:
            there = np.empty(3)
            advance(here, kappa, length, there)
            here = there
        assert here[:2] == pytest.approx(end[:2], abs=1e-6)
        if not to_point:
            assert math.cos(here[2] - end[2]) == pytest.approx(1.0, abs=1e-9)


def test_a_free_floor_is_crossed_in_a_straight_line():
    land = land_of(np.zeros((80, 160), dtype=bool))
    start, goal = np.array([1.5, 2.0, 0.0]), np.array([6.5, 2.0, 0.0])
    turned, looked = turn_through(land, start[None], goal, reach=1.5, pivots=True, budget=2000)
    check(land, turned, start, goal)
    assert np.abs(turned.points[:, 1] - 2.0).max() < 1e-9
    assert not len(turned.pivots)
    assert looked <= 2 + 100


@pytest.mark.parametrize("heading", [0.0, 1.0, 2.5, np.pi])
def test_any_heading_is_left_on_a_curve_where_there_is_room(heading):
    land = land_of(np.zeros((160, 160), dtype=bool))
    start, goal = np.array([4.0, 4.0, heading]), np.array([6.0, 4.0, 0.0])
    turned, _ = turn_through(land, start[None], goal, reach=1.5, pivots=False, budget=4000)
    check(land, turned, start, goal)
    assert not len(turned.pivots)
    first, last = directions(turned.points)[[0, -1]]
    assert abs(turn_between(heading, first)) < 0.2
    assert abs(last) < 0.2
    assert curvature_of(turned.points).max() <= CHAIR.max_curvature


def test_in_a_bay_wide_enough_to_turn_and_too_small_for_a_curve_it_turns_on_the_spot():
    # A bay 1.7 m square at the end of a corridor 0.9 m wide: 2 × 0.718 m lets the chair turn in
    # it, and an arc of radius 0.305 m about a centre 0.305 m aside sweeps 2 × (0.305 + 0.891) m.
    blocked = corridor(0.9)
    blocked[23:57, round(9.0 / RES) : round(9.7 / RES)] = False
    blocked[23:57, round(8.0 / RES) : round(9.0 / RES)] = False
    blocked = np.pad(blocked, ((0, 0), (0, 20)), constant_values=True)
    land = land_of(blocked)
    start, goal = np.array([3.0, 2.0, 0.0]), np.array([2.0, 2.0, np.pi])
    none, _ = turn_through(land, start[None], goal, reach=7.5, pivots=False, budget=20_000)
    assert none is None
    turned, _ = turn_through(land, start[None], goal, reach=7.5, pivots=True, budget=20_000)
    check(land, turned, start, goal)
    assert len(turned.pivots) >= 1
    assert (turned.points[turned.pivots, 0] > 8.0).all()


def test_where_it_cannot_turn_it_cannot():
    land = land_of(corridor(0.9))
    start, goal = np.array([4.0, 2.0, 0.0]), np.array([2.0, 2.0, np.pi])
    for pivots in (False, True):
        none, looked = turn_through(
            land, start[None], goal, reach=9.0, pivots=pivots, budget=50_000
        )
        assert none is None
        assert looked < 50_000  # everything was tried


def test_the_budget_is_kept():
    land = land_of(corridor(0.9))
    start, goal = np.array([4.0, 2.0, 0.0]), np.array([2.0, 2.0, np.pi])
    assert turn_through(land, start[None], goal, reach=9.0, pivots=True, budget=50) == (None, 50)


def test_any_direction_will_do_where_none_is_asked():
    land = land_of(corridor(0.8))
    start, goal = np.array([4.0, 2.0, np.nan]), np.array([2.0, 2.0, np.nan])
    turned, _ = turn_through(land, all_round(start), goal, reach=2.0, pivots=False, budget=4000)
    check(land, turned, start, goal)
    assert abs(turn_between(np.pi, turned.begun)) < 0.3


# ------------------------------------------------------------------------------------ repairs


def test_a_line_that_fits_is_left_alone():
    land = land_of(corridor(1.0))
    line = np.stack([np.linspace(2.0, 7.0, 51), np.full(51, 2.0)], axis=-1)
    effort = Effort(1000)
    fitted = fit(land, line, pins=np.empty((0, 2)), effort=effort)
    assert np.array_equal(fitted.points, line)
    assert fitted.stuck is None
    assert effort.left == 1000


def test_a_start_beside_a_wall_is_left_along_it():
    # A wall at y = 1; the line leaves it at right angles, where the chair's back would be in it.
    blocked = np.zeros((100, 160), dtype=bool)
    blocked[:20] = True
    land = land_of(blocked)
    line = np.stack([np.full(26, 4.0), np.linspace(1.4, 3.9, 26)], axis=-1)
    assert met_along(land.body, line)[0]
    fitted = fit(land, line, pins=np.empty((0, 2)), effort=Effort(12_000))
    assert fitted.stuck is None
    assert not len(fitted.pivots)
    assert np.allclose(fitted.points[[0, -1]], line[[0, -1]])
    assert not misfits(land, fitted.points, fitted.pivots).any()
    # The rear corner stays off the wall: 0.46 sin θ + 0.305 cos θ ≤ 0.4, so sin θ ≤ 0.213.
    assert abs(math.sin(directions(fitted.points)[0])) < 0.213


def test_a_pin_on_a_stretch_that_is_replaced_is_still_passed():
    blocked = np.zeros((120, 200), dtype=bool)
    blocked[52:56, 96:100] = True  # beside the corner, where the chair's side swings
    land = land_of(blocked)
    east = np.stack([np.arange(2.0, 5.01, 0.1), np.full(31, 3.2)], axis=-1)
    north = np.stack([np.full(20, 5.0), np.arange(3.3, 5.25, 0.1)], axis=-1)
    line = np.concatenate([east, north])
    assert misfits(land, line, np.empty(0, dtype=np.int64)).any()
    pin = np.array([[5.0, 3.2]])
    fitted = fit(land, line, pins=pin, effort=Effort(12_000))
    assert fitted.stuck is None
    assert np.hypot(*(fitted.points - pin).T).min() < RES


def test_where_nothing_fits_the_place_is_told():
    # Straight along a corridor 0.9 m wide, and back: nothing turns there.
    land = land_of(corridor(0.9))
    line = np.stack([[*np.linspace(3, 6, 31), *np.linspace(5.9, 3.1, 29)], np.full(60, 2.0)], -1)
    fitted = fit(land, line, pins=line[30:31], effort=Effort(6000))
    assert fitted.stuck == pytest.approx([6.0, 2.0], abs=0.5)


def test_no_loop_is_driven_where_a_wider_curve_does():
    # A corridor 1.2 m wide bends at a right angle; the line takes the bend as sharp as it can.
    blocked = np.ones((140, 140), dtype=bool)
    blocked[40:64, 10:104] = blocked[40:130, 80:104] = False
    land = land_of(blocked)
    east = np.stack([np.arange(1.5, 4.61, 0.1), np.full(32, 2.6)], axis=-1)
    north = np.stack([np.full(28, 4.6), np.arange(2.7, 5.41, 0.1)], axis=-1)
    fitted = fit(land, np.concatenate([east, north]), pins=np.empty((0, 2)), effort=Effort(12_000))
    assert fitted.stuck is None
    assert not len(fitted.pivots)
    turns = np.diff(np.unwrap(directions(fitted.points)))
    assert np.ptp(np.cumsum(turns)) < np.pi  # a loop adds a whole turn
