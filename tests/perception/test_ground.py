import dataclasses

import numpy as np
import pytest

from cohelm.geometry import transform
from cohelm.perception.cloud_detection.ground import ground_heights
from cohelm.perception.preprocessing.merged_cloud import merge_clouds
from cohelm.robots import DepthCameraMount
from cohelm.simulation.sensors import FloorSurface

from .clouds import HERE, LIDAR, SPARSE, cloud_of, scenery, see

AT = np.array([2.0, 0.0])
FLOORS = {
    "level": FloorSurface(at=AT, direction=0.0, gradient=0.0),
    "ramp ahead": FloorSurface(at=AT, direction=0.0, gradient=0.1, length=4.0),
    "ramp down": FloorSurface(at=AT, direction=0.0, gradient=-0.1, length=4.0),
    "ramp aside": FloorSurface(
        at=np.array([0.0, 2.0]), direction=np.pi / 2, gradient=0.08, length=5.0
    ),
    "on the ramp": FloorSurface(at=np.array([-1.0, 0.0]), direction=0.0, gradient=0.1, length=4.0),
}


@pytest.mark.parametrize("floor", FLOORS.values(), ids=FLOORS)
@pytest.mark.parametrize("mount", [LIDAR, SPARSE, DepthCameraMount()], ids=["32", "16", "depth"])
@pytest.mark.parametrize("height", ["known", "unknown"])
def test_floors_and_ramps_are_no_obstacle_and_boxes_on_them_are(floor, mount, height):
    boxes = [(4.0, 1.0, (0.4, 0.4), 0.25), (3.0, -1.0, (0.4, 0.4), 0.15)]
    cloud = cloud_of(scenery(*boxes, floor=floor), mount=mount)
    if height == "unknown":
        cloud = dataclasses.replace(cloud, mount=cloud.mount * [1, 1, np.nan, 1, 1, 1])
    points = standing(cloud)
    within = [(np.abs(points - box[:2]) < 0.4).all(axis=1) for box in boxes]
    assert within[0].any()
    assert within[1].any()
    in_the_hall = (np.abs(points) < (6.0 if len(cloud.points) < 7000 else 9.6)).all(axis=1)
    assert not (in_the_hall & ~within[0] & ~within[1]).any()


def standing(cloud):
    """(k, 2) returns on what stands on the ground, thinner than the detector takes it."""
    seen = merge_clouds((cloud,), HERE[None], 15.0)
    heights = ground_heights(seen.points, 0.12, 0.03, 15.0)
    away = np.hypot(*seen.points[:, :2].T)
    above = (heights > 0.06 + 0.004 * away) & (heights < 2.0)
    return transform(seen.X_MS, seen.points[above, :2])


@pytest.mark.parametrize("step", [0.12, 0.17])
@pytest.mark.parametrize("mount", [LIDAR, SPARSE])
def test_a_kerb_across_the_way_stays_in_the_way(step, mount):
    seen = see(scenery((6.0, 0.0, (4.0, 12.0), step)), mount=mount)
    inside = seen.points[(np.abs(seen.points) < 9.0).all(axis=1)]
    edge = (inside[:, 0] < 5.0) & (np.abs(inside[:, 1]) < 3.0)
    assert edge.sum() > 10
    assert (inside[:, 0] > 3.8).all()


def test_an_unknown_height_is_found():
    seen = merge_clouds(
        (dataclasses.replace(cloud_of(scenery()), mount=np.array([0, 0, np.nan, 0, 0, 0])),),
        HERE[None],
        15.0,
    )
    assert abs(seen.sensors[0, 2] - LIDAR.pose[2]) < 0.03


def test_returns_from_below_the_floor_do_not_lift_it():
    cloud = cloud_of(scenery())
    ghosts = np.random.default_rng(0).uniform([2.0, -2.0, -2.5], [5.0, 2.0, -1.7], (30, 3))
    points = np.concatenate([cloud.points, ghosts.astype(np.float32)])
    seen = merge_clouds((dataclasses.replace(cloud, points=points),), HERE[None], 15.0)
    heights = ground_heights(seen.points, 0.12, 0.03, 15.0)
    # what lies a hand's breadth over the floor at z = 0 is told as such to within 3 cm
    off = heights - seen.points[:, 2]
    assert np.abs(off[np.hypot(*seen.points[:, :2].T) < 8.0]).max() < 0.05


def test_nothing_has_no_ground():
    assert len(ground_heights(np.empty((0, 3)), 0.15, 0.06, 15.0)) == 0
