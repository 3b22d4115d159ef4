import numpy as np
import pytest
from scipy.spatial.distance import cdist

from cohelm.geometry import resample, transform
from cohelm.maps import CostmapFilter, OccupancyGrid, distance_field
from cohelm.messages import Path, Wish, WishReport
from cohelm.planning.path_measures import (
    driven_backward,
    gap_to_zone,
    min_gap,
    poses_along,
    poses_driven,
    time_in_speed_zones,
)

ORIGIN = np.zeros(3)


def path_of(points, **gears):
    points = np.asarray(points, dtype=float)
    return Path(
        points=points,
        length=1.0,
        cost=1.0,
        method="drawn",
        wishes=WishReport(closest=np.zeros(0)),
        without_wishes=points,
        **gears,
    )


def test_poses_head_along_the_line():
    poses = poses_along(path_of([[0.0, 0.0], [2.0, 2.0]]), 0.5)
    assert poses[:, 2] == pytest.approx(np.pi / 4)
    assert poses[[0, -1], :2].tolist() == [[0.0, 0.0], [2.0, 2.0]]


def test_a_line_of_one_point_has_a_pose():
    assert poses_along(path_of([[1.0, 2.0], [1.0, 2.0]]), 0.5)[0].tolist() == [1.0, 2.0, 0.0]


def test_the_gap_along_a_wall(chair):
    # A wall along y < 0.5; the chair, 0.61 m wide, drives 1 m above it: 1 − 0.305 = 0.695 m.
    data = np.zeros((80, 120), dtype=np.int8)
    data[:10] = 100
    walls = distance_field(OccupancyGrid(data=data, resolution=0.05, X_MG=ORIGIN))
    gap = min_gap(path_of([[1.0, 1.5], [5.0, 1.5]]), chair, walls)
    assert gap == pytest.approx(1.0 - 0.5 * (np.ptp(chair.outline[:, 1])), abs=1e-9)


def test_a_gap_to_nothing_is_the_fields_diagonal(chair):
    grid = OccupancyGrid(data=np.zeros((30, 40), dtype=np.int8), resolution=0.1, X_MG=ORIGIN)
    gap = min_gap(path_of([[1.0, 1.0], [2.0, 1.0]]), chair, distance_field(grid))
    assert gap == pytest.approx(5.0)


@pytest.mark.parametrize("seed", range(8))
def test_the_gap_is_that_of_outline_and_squares(chair, seed):
    # Oracle: the distance of closely spaced points of outline and squares, at every pose.
    rng = np.random.default_rng(seed)
    data = np.zeros((60, 60), dtype=np.int8)
    cells = rng.integers(0, 60, size=(12, 2))
    cells = cells[np.hypot(*(cells - 30).T) > 12]
    data[cells[:, 0], cells[:, 1]] = 100
    X_MG = np.array([-1.0, 2.0, rng.uniform(-3.0, 3.0)])
    line = 1.5 + np.array([[-0.4, 0.0], [0.0, rng.uniform(-0.2, 0.2)], [0.1, 0.3]])
    heading = np.arctan2(*np.diff(line, axis=0).T[::-1])
    steps = np.linspace(0.0, 1.0, 12)
    driven = [
        (*(a + t * (b - a)), h)
        for a, b, h in zip(line, line[1:], heading, strict=False)
        for t in steps
    ]
    driven += [(*line[1], heading[0] + t * (heading[1] - heading[0])) for t in steps]
    edge = resample(np.concatenate([chair.outline, chair.outline[:1]]), 0.02)
    side = np.linspace(0.0, 0.05, 6)
    squares = np.concatenate(
        [0.05 * c[::-1] + np.stack(np.meshgrid(side, side), -1).reshape(-1, 2) for c in cells]
    )
    expected = min(cdist(transform(np.array(pose), edge), squares).min() for pose in driven)
    walls = distance_field(OccupancyGrid(data=data, resolution=0.05, X_MG=X_MG))
    gap = min_gap(path_of(transform(X_MG, line)), chair, walls)
    assert gap == pytest.approx(expected, abs=0.012)


def test_a_chair_that_stands_in_something_has_no_gap(chair):
    data = np.zeros((60, 60), dtype=np.int8)
    data[30, 30] = 100
    walls = distance_field(OccupancyGrid(data=data, resolution=0.05, X_MG=ORIGIN))
    assert min_gap(path_of([[1.5, 1.5], [1.6, 1.5]]), chair, walls) == 0.0


def test_a_leg_backwards_is_measured_with_the_rear_ahead(chair):
    """Into a dead end along x, 0.8 m wide: forward to 4 m, and backwards to 1 m and to the wall."""
    front, rear = chair.outline[:, 0].max(), -chair.outline[:, 0].min()
    data = np.full((60, 140), 100, dtype=np.int8)
    data[22:38, 10:110] = 0  # x from 0.5 to 5.5 m, y from 1.1 to 1.9 m
    walls = distance_field(OccupancyGrid(data=data, resolution=0.05, X_MG=ORIGIN))
    side = 0.4 - 0.5 * np.ptp(chair.outline[:, 1])
    line = path_of([[1.5, 1.5], [4.0, 1.5], [1.0, 1.5]], cusps=[1])
    assert driven_backward(line).tolist() == [False, True]
    # the rear ends at 1 − 0.46 m, before the wall at 0.5 m; no turn sweeps the walls beside
    assert min_gap(line, chair, walls) == pytest.approx(min(side, 0.5 - rear), abs=1e-6)
    out = path_of([[1.0, 1.5], [4.0, 1.5]], backs_out=True)
    assert np.abs(poses_along(out, 0.5)[:, 2]) == pytest.approx(np.pi)
    zone = Wish(kind="avoid", points=np.array([[4.0 + front + 0.2, 1.5]]), radius=0.1)
    assert gap_to_zone(out, chair, zone) == pytest.approx(front - rear + 0.1, abs=0.01)


def test_a_turn_on_the_spot_at_a_change_of_gear_is_swept():
    """Forward along x, a right angle on the spot, and backwards along y."""
    line = [[1.0, 2.0], [2.0, 2.0], [2.0, 3.0]]
    poses = poses_driven(np.array(line), driven_backward(path_of(line, cusps=[1])), 0.7)
    turns = np.rad2deg(np.unwrap(poses[(poses[:, :2] == [2.0, 2.0]).all(axis=1), 2]))
    assert turns.min() == pytest.approx(-90.0)
    assert np.abs(np.diff(turns)).max() < 3.0


def test_speed_zones_cost_what_the_slower_half_takes():
    # Half of 4 m at 50 % of 1.0 m/s instead of 0.8: 2/0.5 − 2/0.8 = 1.5 s.
    data = np.zeros((10, 40), dtype=np.int8)
    data[:, 20:] = 50
    slow = CostmapFilter(
        type="speed_percent", mask=OccupancyGrid(data=data, resolution=0.1, X_MG=ORIGIN)
    )
    line = np.array([[0.0, 0.5], [4.0, 0.5]])
    assert time_in_speed_zones(line, (slow,), 0.8, 1.0) == pytest.approx(1.5, abs=0.05)
    assert time_in_speed_zones(line, (), 0.8, 1.0) == 0.0
