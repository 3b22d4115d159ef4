"""What clouds put into the live obstacle layer and take out of it."""

import dataclasses

import numpy as np
import pytest

from cohelm.messages import People
from cohelm.perception import CloudClusters, Detections, update_obstacle_layer
from cohelm.robots import DepthCameraMount, LidarMount

from .clouds import LIDAR, NOBODY, cloud_of, hall, scenery

NONE = People.empty(0.0)
BOX = (0.0, 0.0, (0.4, 0.4), 0.25)
SIX = LidarMount(pose=(0.0, 0.0, 1.3, 0.0, 0.0, 0.0), rings=16, azimuths=360)


def look(scene, x, layer=None, mounts=(LIDAR,), seed=0):
    """The layer after one look from (x, 0)."""
    pose = np.array([x, 0.0, 0.0])
    clouds = tuple(cloud_of(scene, NOBODY, mount, pose, seed) for mount in mounts)
    seen = CloudClusters().detect(clouds, np.tile(pose, (len(clouds), 1)), hall()[1])
    return update_obstacle_layer(layer, (seen,), NONE, hall()[0], pose)


def standing(layer, near=(0.0, 0.0), within=0.35):
    """How many occupied cells there are near a place."""
    known = layer.obstacles
    at = hall()[0].centres(np.argwhere(known.occupied) + known.corner)
    return int((np.hypot(*(at - near).T) < within).sum())


@pytest.mark.parametrize("mount", [LIDAR, SIX], ids=["32", "16"])
@pytest.mark.parametrize("height", [0.12, 0.25, 0.4])
def test_a_low_box_stays_when_the_beams_pass_over_it(mount, height):
    scene, layer = scenery((0.0, 0.0, (0.4, 0.4), height), ceiling=np.inf), None
    most = 0
    for k, x in enumerate(np.arange(-4.0, -0.7, 0.08)):
        layer = look(scene, x, layer, (mount,), seed=k)
        most = max(most, standing(layer))
    # nearer than 2.5 m even the top of the box is below the lowest ring
    assert most >= 4
    assert standing(layer) >= 0.8 * most


def test_what_a_camera_saw_of_a_low_box_stays_beside_the_lidars_beams():
    scene = scenery(BOX, ceiling=np.inf)
    camera = DepthCameraMount(pose=(0.0, 0.0, 0.75, 0.0, 0.42, 0.0))
    layer = None
    for k in range(6):
        layer = look(scene, -1.2, layer, (LIDAR, camera), seed=k)
    seen = standing(layer)
    assert seen >= 4
    for k in range(30):
        layer = look(scene, -1.2, layer, (LIDAR,), seed=k)
    assert standing(layer) == seen


@pytest.mark.parametrize("mount", [LIDAR, SIX], ids=["32", "16"])
@pytest.mark.parametrize("height", [0.25, 0.6, 1.8, np.nan])
def test_what_is_taken_away_is_cleared_from_where_the_floor_is_seen(mount, height):
    there = scenery((0.0, 0.0, (0.4, 0.4), height), ceiling=np.inf)
    gone, layer = scenery(ceiling=np.inf), None
    for k in range(6):
        layer = look(there, -4.0, layer, (mount,), seed=k)
    assert standing(layer) >= 4
    # beams of far apart rings go through a low thing now and then only, so that the chair drives on
    for k in range(40):
        layer = look(gone, -4.0 + 0.04 * k, layer, (mount,), seed=k)
    assert standing(layer) <= 1
    assert not layer.span[:, layer.evidence == 0].any()


def test_a_planar_scan_leaves_what_clouds_saw_and_clears_what_scans_saw():
    grid, scene, layer = hall()[0], scenery(BOX, ceiling=np.inf), None
    nothing = Detections.empty(0.0, np.array([-3.0, 0.0]))
    post = dataclasses.replace(
        nothing,
        points=np.array([[1.01, 1.01]]),
        detection_of_return=np.array([-1]),
        mapped=np.array([False]),
        cluster_of_return=np.array([-1]),
    )
    for k in range(6):
        layer = look(scene, -3.0, layer, seed=k)
        layer = update_obstacle_layer(layer, (post,), NONE, grid, np.array([-3.0, 0.0]))
    box = standing(layer)
    assert box >= 4
    assert standing(layer, (1.0, 1.0), 0.1) == 1
    free = np.array([[5.02, 2.02 + 0.01 * k] for k in range(-30, 30)])
    over = dataclasses.replace(nothing, free_ends=np.concatenate([free, free - [0.0, 2.0]]))
    for _ in range(12):
        layer = update_obstacle_layer(layer, (over,), NONE, grid, np.array([-3.0, 0.0]))
    assert standing(layer) == box
    assert standing(layer, (1.0, 1.0), 0.1) == 0
