"""People among walls: no person walks through one, and all pass doors and corners."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cohelm.geometry import transform
from cohelm.maps import OccupancyGrid
from cohelm.simulation import Orca
from cohelm.simulation.wall_geometry import free_region, walls_of

BODY = 0.25


def gaps(grid, positions):
    """Exact distance of points (..., 2) to the nearest blocked cell, by brute force."""
    corner = transform(grid.X_MG, np.zeros(2))
    turn = np.array([0.0, 0.0, -grid.X_MG[2]])
    p = transform(turn, np.asarray(positions) - corner)
    cells = (np.argwhere(grid.blocked())[:, ::-1] + 0.5) * grid.resolution
    beyond = np.maximum(np.abs(p[..., None, :] - cells) - grid.resolution / 2.0, 0.0)
    return np.hypot(beyond[..., 0], beyond[..., 1]).min(axis=-1)


def walk(crowd, scene, seconds, model=None, dt=0.05):
    """All positions (t, n, 2) on the way, and the crowd at the end."""
    rng = np.random.default_rng(0)
    model = model or Orca()
    positions = [crowd.position]
    for k in range(round(seconds / dt)):
        scene_now = scene(time=k * dt)
        crowd = model.step(crowd, scene_now, dt, rng)
        positions.append(crowd.position)
    return np.array(positions), crowd


def corridor(boxes):
    return ((0, 0, 12, 4), (0, 5.6, 12, 10), *boxes)


@pytest.mark.parametrize("yaw", [0.0, 0.4, np.pi / 2])
def test_people_meet_in_a_corridor_and_pass(make_grid, make_crowd, make_scene, yaw):
    X = (3.0, -1.0, yaw)
    grid = make_grid(boxes=corridor(()), X_MG=X)
    starts, ends = np.array([[1.0, 4.7], [11.0, 4.8]]), np.array([[11.0, 4.8], [1.0, 4.7]])
    crowd = make_crowd(transform(X, starts), transform(X, ends)[:, None])
    positions, after = walk(crowd, lambda **now: make_scene(grid, **now), 20.0)
    assert (after.target == 1).all()
    assert gaps(grid, positions[::5]).min() >= BODY - 1e-6


def test_one_walks_through_a_narrow_door_without_stopping(make_grid, make_crowd, make_scene):
    grid = make_grid(boxes=((5.9, 0, 6.1, 4.6), (5.9, 5.4, 6.1, 10)))  # 0.8 m wide
    crowd = make_crowd([[2.0, 3.5]], [[[5.4, 5.0], [6.6, 5.0], [10.0, 6.5]]])
    positions, after = walk(crowd, lambda **now: make_scene(grid, **now), 14.0)
    assert after.target[0] == 3
    assert gaps(grid, positions).min() >= BODY - 1e-6
    speed = np.hypot(*np.diff(positions[:, 0], axis=0).T) / 0.05
    assert speed[(positions[:-1, 0, 0] > 2.1) & (positions[:-1, 0, 0] < 8.0)].min() > 0.2


def test_eight_get_through_one_door_from_both_sides(make_grid, make_crowd, make_scene):
    grid = make_grid(boxes=((5.9, 0, 6.1, 4.5), (5.9, 5.5, 6.1, 10)))  # 1 m wide
    y = np.array([2.0, 4.0, 6.0, 8.0])
    here, there = np.column_stack([np.full(4, 2.5), y]), np.column_stack([np.full(4, 9.5), y])
    to, fro = np.tile([5.4, 5.0], (4, 1)), np.tile([6.6, 5.0], (4, 1))
    crowd = make_crowd(
        np.vstack([here, there]),
        np.vstack([np.stack([to, fro, there], axis=1), np.stack([fro, to, here], axis=1)]),
    )
    positions, after = walk(crowd, lambda **now: make_scene(grid, **now), 60.0)
    assert (after.target == 3).all()
    assert gaps(grid, positions[::5]).min() >= BODY - 1e-6


def test_one_slides_round_a_corner_that_is_in_the_way(make_grid, make_crowd, make_scene):
    grid = make_grid(boxes=((3.0, 0.0, 7.0, 5.1),))
    crowd = make_crowd([[1.0, 4.6]], [[[9.0, 5.6]]])  # the straight way cuts the block's corner
    positions, after = walk(crowd, lambda **now: make_scene(grid, **now), 14.0)
    assert after.target[0] == 1
    assert gaps(grid, positions).min() >= BODY - 1e-6


@settings(
    max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(seed=st.integers(0, 10**6), dt=st.sampled_from([0.05, 0.25, 1.0]))
def test_nobody_walks_through_anything(make_crowd, make_scene, seed, dt):
    rng = np.random.default_rng(seed)
    data = np.where(rng.random((40, 40)) < 0.03, 100, 0).astype(np.int8)
    data[rng.integers(40)] = -1  # unknown stands in the way, too
    X = np.array([*rng.uniform(-2, 2, 2), rng.uniform(-3, 3)])
    grid = OccupancyGrid(data=data, resolution=0.2, X_MG=X)
    starts = transform(X, rng.uniform(0.0, 8.0, (200, 2)))
    starts = starts[gaps(grid, starts) > BODY][:6]
    goals = transform(X, rng.uniform(0.0, 8.0, (len(starts), 1, 2)))
    crowd = make_crowd(starts, goals, preferred_speed=rng.uniform(0.5, 2.0, len(starts)))
    positions, _ = walk(crowd, lambda **now: make_scene(grid, **now), 40 * dt, dt=dt)
    if len(starts):
        assert gaps(grid, positions).min() >= BODY - 1e-6


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.integers(0, 60))
def test_the_free_region_holds_no_cell(seed, count):
    rng = np.random.default_rng(seed)
    cells = rng.integers(-20, 20, (count, 2)) * 0.1 + 0.05
    x, y = rng.uniform(-2.0, 2.0, 2)
    region = free_region(cells, 0.05, x, y)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 0.05
    for cell in cells:
        if np.abs(cell - [x, y]).max() > 0.05:  # not the one that the person stands in
            ahead = (cell + corners - [x, y]) @ region[:, :2].T - region[:, 2]
            assert ahead.min(axis=0).max() >= -1e-6  # wholly behind one half-plane


def test_the_index_of_walls_is_remembered_by_grid(make_grid):
    grid, same = make_grid(), make_grid()
    assert walls_of(grid) is walls_of(grid)
    assert walls_of(grid) is not walls_of(same)
