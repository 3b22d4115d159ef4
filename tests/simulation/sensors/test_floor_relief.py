"""Floors with height against closed forms, and what rays meet on them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.arrays import identical
from cohelm.geometry import compose
from cohelm.maps import OccupancyGrid
from cohelm.robots import DepthCameraMount, LidarMount
from cohelm.simulation import FloorPiece, FloorRelief
from cohelm.simulation.sensors import HumanBodies, StaticScene, scan_cloud
from cohelm.simulation.sensors.floor_relief import floor_cells
from cohelm.simulation.sensors.point_cloud import sensor_pose

NOBODY = HumanBodies.standing(np.empty((0, 2)))
MOUNTS = [
    LidarMount(pose=(0.0, 0.0, 1.3, 0.0, 0.0, 0.0), noise=0.0, dropout=0.0),
    DepthCameraMount(pose=(0.4, 0.0, 0.75, 0.0, 0.5, 0.0), noise=0.0, dropout=0.0),
]


def piece(at, size, height=0.0, rise=0.0, steps=0, angle=0.0, dark=False):
    shape = {"at": np.array(at), "size": np.array(size), "angle": angle}
    return FloorPiece(**shape, height=height, rise=rise, steps=steps, dark=dark)


RELIEFS = {
    "pit": piece((7.0, 3.0), (2.0, 4.0), -0.5),
    "kerb": piece((8.0, 3.0), (4.0, 6.0), 0.12),
    "stairs down": piece((8.0, 3.0), (4.0, 6.0), 0.0, -1.6, 8),
    "stairs up": piece((8.0, 3.0), (4.0, 6.0), 0.0, 1.6, 8),
    "ramp down": piece((8.0, 3.0), (4.0, 6.0), 0.0, -0.3),
    "ramp aside": piece((6.0, 3.0), (6.0, 12.0), -0.25, 0.5, angle=np.pi / 2),
}


def scene_of(*pieces):
    data = np.zeros((120, 200), dtype=np.int8)
    data[:2] = data[-2:] = data[:, :2] = data[:, -2:] = 100
    grid = OccupancyGrid(data=data, resolution=0.05, X_MG=np.zeros(3))
    return StaticScene(grid=grid, cells=floor_cells(FloorRelief(pieces=pieces), grid), ceiling=2.7)


def returns(scene, mount, pose):
    """Returns (n, 3) in the world, m, and their rays' lengths (n,)."""
    cloud = scan_cloud(mount, scene, NOBODY, pose, time=0.0, rng=np.random.default_rng(0))
    origin, R = sensor_pose(mount, scene, pose)
    points = np.asarray(cloud.points, dtype=float)
    return origin + points @ R.T, np.linalg.norm(points, axis=1)


@given(st.floats(-3.0, 3.0), st.floats(-2.0, 2.0), st.floats(-np.pi, np.pi), st.integers(0, 9))
def test_slabs_are_the_piece(x, y, angle, steps):
    whole = piece((1.0, 2.0), (4.0, 3.0), 0.1, -0.8, steps, angle)
    point = np.array([x, y]) + whole.at
    for at, size, begin, end in whole.slabs:
        slab = piece(at, size, begin, end - begin, 0, angle)
        inner = piece(at, size - 1e-6, begin, end - begin, 0, angle)
        if inner.covers(point):
            assert whole.covers(point)
            assert slab.heights(point) == pytest.approx(whole.heights(point), abs=1e-6)
            return
    near = any(piece(at, size + 1e-6, angle=angle).covers(point) for at, size, *_ in whole.slabs)
    assert near or not whole.covers(point)


def test_a_later_piece_lies_on_an_earlier_one():
    relief = FloorRelief(pieces=(piece((0, 0), (4, 4), 0.5), piece((1, 0), (1, 1), -0.2)))
    points = np.array([[1.0, 0.0], [-1.0, 0.0], [3.0, 0.0]])
    assert relief.heights(points).tolist() == [-0.2, 0.5, 0.0]


def test_a_flat_floor_has_no_cells():
    assert scene_of().cells is None


@pytest.mark.parametrize("angle", [0.0, 0.7, np.pi / 2, -2.0])
def test_a_chair_on_a_ramp_has_its_slope(angle):
    scene = scene_of(piece((5.0, 3.0), (8.0, 6.0), 0.0, 0.8))
    height, slope = scene.stance(np.array([5.0, 3.0, angle]))
    assert height == pytest.approx(0.4, abs=0.006)  # cells of 5 cm on 1:10
    assert slope == pytest.approx([0.1, 0.0], abs=0.02)


@pytest.mark.parametrize("mount", MOUNTS, ids=["lidar", "camera"])
@pytest.mark.parametrize("name", RELIEFS)
def test_returns_lie_on_the_floor_or_on_the_face_of_a_step(name, mount):
    scene = scene_of(RELIEFS[name])
    points, _ = returns(scene, mount, np.array([4.0, 3.0, 0.0]))
    inside = (np.abs(points[:, :2] - [5.0, 3.0]) < [4.7, 2.7]).all(axis=1)
    low = points[inside & (points[:, 2] < 1.7)]
    assert len(low) > 200
    around = np.array([[i, j] for i in (-0.05, 0.0, 0.05) for j in (-0.05, 0.0, 0.05)])
    near = scene.floor_height(low[:, None, :2] + around)
    assert (low[:, 2] >= near.min(axis=1) - 2e-3).all()
    assert (low[:, 2] <= near.max(axis=1) + 2e-3).all()
    assert (np.abs(scene.floor_height(low[:, :2])) > 0.03).any()  # the relief is seen


@pytest.mark.parametrize("mount", MOUNTS, ids=["lidar", "camera"])
def test_dark_floor_returns_nothing_and_all_else_is_as_before(mount):
    pose = np.array([4.0, 3.0, 0.0])
    before, _ = returns(scene_of(), mount, pose)
    after, _ = returns(scene_of(piece((7.0, 3.0), (2.0, 3.0), dark=True)), mount, pose)
    within = (np.abs(before[:, 0] - 7.0) < 1.0) & (np.abs(before[:, 1] - 3.0) < 1.5)
    dark = within & (before[:, 2] < 1e-3)
    assert dark.sum() > 10
    assert np.isnan(after[dark]).all()
    assert after[~dark] == pytest.approx(before[~dark], abs=1e-4, nan_ok=True)


def test_a_piece_at_height_zero_changes_no_ray():
    pose = compose(np.array([3.0, 3.0, 0.3]), np.zeros(3))
    for mount in MOUNTS:
        plain, _ = returns(scene_of(), mount, pose)
        level, _ = returns(scene_of(piece((6.0, 3.0), (2.0, 2.0))), mount, pose)
        assert identical(plain, level)
