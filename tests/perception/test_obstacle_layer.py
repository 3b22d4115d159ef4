import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.maps import OccupancyGrid
from cohelm.messages import People
from cohelm.perception import (
    KalmanTracker,
    ObstacleLayerParameters,
    ScanClusters,
    update_obstacle_layer,
)

from .rays import Laser, box, observation, room

HERE = np.zeros(2)
NOBODY = People.empty(0.0)


def somebody(x, y, radius=0.25):
    return People(
        time=0.0,
        id=np.array([0]),
        mean=np.array([[x, y, 0.0, 0.0]]),
        covariance=0.01 * np.eye(4)[None],
        heading=np.zeros(1),
        radius=np.array([radius]),
        confidence=np.ones(1),
    )


def look(laser, layer=None, scans=1, people=NOBODY, discs=(), pose=(0.0, 0.0, 0.0), **parameters):
    """The layer after some scans."""
    for _ in range(scans):
        scan, told = laser.scan(0.0, pose, discs)
        seen = ScanClusters().detect(scan, told, laser.walls)
        layer = update_obstacle_layer(
            layer, (seen,), people, laser.grid, told[:2], ObstacleLayerParameters(**parameters)
        )
    return layer


def places(layer, grid):
    """Centres of the occupied cells in the map frame, (k, 2)."""
    known = layer.obstacles
    return grid.centres(np.argwhere(known.occupied) + known.corner)


def test_a_box_is_in_the_layer_where_it_stands_and_the_walls_are_not():
    laser = Laser(segments=box(3.0, 1.0, 0.6, 0.3))
    found = places(look(laser, scans=5), laser.grid)
    assert len(found) > 8
    assert (np.hypot(*(found - [3.0, 1.0]).T) < 0.3 * np.sqrt(2) + 0.06).all()


def test_an_empty_room_stays_empty_however_badly_localised():
    laser = Laser(localisation=1.0)
    layer = None
    for k in range(60):
        layer = look(laser, layer, pose=(-4.0 + 0.1 * k, 1.0, 0.05 * k))
    assert not layer.obstacles.occupied.any()


def test_where_nothing_stands_and_nothing_comes_the_layer_is_the_same_value():
    laser = Laser(localisation=0.0)
    layer = look(laser)
    assert not layer.evidence.any()
    assert look(laser, layer) is layer
    assert look(Laser(segments=box(3.0, 0.0, 0.6)), layer) is not layer


def test_one_noisy_return_marks_nothing_and_one_free_scan_clears_nothing():
    laser, empty = Laser(segments=box(3.0, 0.0, 0.6)), Laser()
    once = look(laser)
    assert not once.obstacles.occupied.any()
    assert once.obstacles.version == 0
    known = look(laser, scans=6)
    assert known.obstacles.occupied.any()
    after = look(empty, known)
    assert identical(after.obstacles, known.obstacles)
    # evidence is 9 at most and a scan takes 1; a few beams are lost
    assert not look(empty, known, scans=12).obstacles.occupied.any()


def test_what_is_out_of_view_is_kept():
    laser = Laser(segments=box(3.0, 0.0, 0.6))
    known = look(laser, scans=6)
    laser.segments = np.concatenate([laser.segments[:4], [[2.0, -1.0, 2.0, 1.0]]])
    hidden = look(laser, known, scans=30)
    before = places(known, laser.grid)
    after = {tuple(p) for p in places(hidden, laser.grid).round(3)}
    assert {tuple(p) for p in before.round(3)} <= after


def test_tracked_people_are_not_in_the_layer_and_strangers_are():
    laser = Laser()
    body = [[3.0, 1.0, 0.25]]
    stranger = look(laser, scans=5, discs=body)
    assert len(places(stranger, laser.grid)) > 5
    tracked = look(laser, scans=5, discs=body, people=somebody(3.0, 1.0))
    assert not tracked.obstacles.occupied.any()
    # once recognised, what was marked for it goes
    recognised = look(laser, stranger, discs=body, people=somebody(3.0, 1.0))
    assert not recognised.obstacles.occupied.any()
    assert recognised.obstacles.version > stranger.obstacles.version


def test_a_walker_leaves_no_trail():
    laser = Laser(segments=box(-3.0, 2.0, 0.5))
    detector, tracker = ScanClusters(), KalmanTracker()
    memory = layer = None
    for tick in range(80):
        time = tick / 20
        detections = ()
        if tick % 2 == 0:
            scan, told = laser.scan(time, (0.0, 0.0, 0.0), [[4.0, -2.0 + 1.2 * time, 0.27]])
            detections = (detector.detect(scan, told, laser.walls),)
        people, memory = tracker.track(observation(time), detections, memory)
        layer = update_obstacle_layer(layer, detections, people, laser.grid, HERE)
    found = places(layer, laser.grid)
    assert len(found) > 5
    assert (np.hypot(*(found - [-3.0, 2.0]).T) < 0.45).all()


def test_the_window_goes_along_and_keeps_what_stays_inside():
    laser = Laser(grid=room(60.0, 16.0), segments=box(3.0, 0.0, 0.6))
    layer = look(laser, scans=6)
    before = places(layer, laser.grid)
    for x in (4.0, 8.0, 12.0):
        layer = update_obstacle_layer(layer, (), NOBODY, laser.grid, np.array([x, 0.0]))
        assert np.array_equal(places(layer, laser.grid), before)
        assert layer.obstacles.occupied.shape == (400, 400)
        centre = laser.grid.centres(layer.obstacles.corner + 199.5)
        assert np.abs(centre - [x, 0.0]).max() <= 1.0
    # 3 m is now farther than 10 m behind
    gone = update_obstacle_layer(layer, (), NOBODY, laser.grid, np.array([14.0, 0.0]))
    assert not gone.obstacles.occupied.any()
    assert gone.obstacles.version > layer.obstacles.version


def test_the_version_grows_exactly_when_a_cell_changes():
    laser, layer = Laser(segments=box(3.0, 0.0, 0.6)), None
    for _ in range(20):
        after = look(laser, layer)
        if layer is not None:
            changed = not np.array_equal(after.obstacles.occupied, layer.obstacles.occupied)
            assert after.obstacles.version == layer.obstacles.version + changed
            assert changed or after.obstacles is layer.obstacles
        layer = after


def test_nothing_new_changes_nothing():
    laser = Laser(segments=box(3.0, 0.0, 0.6))
    layer = look(laser, scans=5)
    assert update_obstacle_layer(layer, (), NOBODY, laser.grid, HERE) is layer


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.0])
def test_the_maps_own_turn_does_not_matter(yaw):
    # the same room about the origin, on a grid that is turned and free of walls
    turned = OccupancyGrid(
        data=np.zeros((600, 600), dtype=np.int8),
        resolution=0.05,
        X_MG=np.array(
            [
                *(
                    np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
                    @ [-15.0, -15.0]
                ),
                yaw,
            ]
        ),
    )
    laser = Laser(segments=box(3.0, 1.0, 0.6))
    laser.grid = turned
    found = places(look(laser, scans=5), turned)
    assert len(found) > 8
    assert (np.hypot(*(found - [3.0, 1.0]).T) < 0.3 * np.sqrt(2) + 0.06).all()


def test_beams_that_meet_nothing_clear_what_is_gone():
    wide = Laser(grid=room(60.0, 60.0), segments=box(3.0, 0.0, 0.6))
    known = look(wide, scans=6)
    wide.segments = wide.segments[:4]
    assert not look(wide, known, scans=12).obstacles.occupied.any()
