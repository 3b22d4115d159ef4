"""The map of the ground: what a chair knows of the floor that it drives towards."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.maps import OccupancyGrid
from cohelm.messages import LiveObstacles, PointCloud
from cohelm.perception.ground.cells import FLOOR, LOWER, GroundCells
from cohelm.perception.ground.ground_map import (
    GroundParameters,
    known_floor,
    open_edges,
    rules_of,
    update_ground,
    with_edges,
)
from cohelm.perception.ground.kinds import update_kinds
from cohelm.robots import load_robot
from cohelm.simulation import FloorPiece, FloorRelief
from cohelm.simulation.sensors import HumanBodies, StaticScene, scan_cloud
from cohelm.simulation.sensors.floor_relief import floor_cells

CHAIR = load_robot("quantum_q6_edge_lidar")
FRONT = CHAIR.outline[:, 0].max()
NOBODY = HumanBodies.standing(np.empty((0, 2)))
EDGE = 6.0
"""Where the floor changes, m along x."""


def piece(at, size, height=0.0, rise=0.0, steps=0, dark=False):
    shape = {"at": np.array(at), "size": np.array(size), "angle": 0.0}
    return FloorPiece(**shape, height=height, rise=rise, steps=steps, dark=dark)


def beyond(height, rise=0.0, steps=0):
    """Floor at another height from the edge on."""
    return (piece((EDGE + 2.0, 3.0), (4.0, 6.0), height, rise, steps),)


def hall():
    data = np.zeros((120, 240), dtype=np.int8)
    data[:2] = data[-2:] = data[:, :2] = data[:, -2:] = 100
    return OccupancyGrid(data=data, resolution=0.05, X_MG=np.zeros(3))


def approach(
    pieces, *, stop=0.3, speed=0.8, seed=0, bodies=NOBODY, robot=CHAIR, error=0.01, level_until=9.0
):
    """Drive along x until the front is ``stop`` before the edge: (map, lead, pose, maps).

    The floor is level until the front is ``level_until`` before the edge, m.

    Lead is the distance from the front at which the first edge was known, m; None: never. Poses
    are wrong by ``error`` (m; half of it in rad), new in each sweep.
    """
    grid = hall()
    changed, level = (
        StaticScene(grid=grid, cells=floor_cells(FloorRelief(pieces=each), grid), ceiling=2.5)
        for each in (pieces, ())
    )
    rng, lead, ground, k = np.random.default_rng(seed), None, None, 0
    pose = np.array([2.0, 3.0, 0.0])
    maps = []
    while pose[0] < EDGE - FRONT - stop:
        scene = level if EDGE - FRONT - pose[0] > level_until else changed
        mounts = [*(robot.lidars if k % 2 == 0 else ()), *(robot.depth_cameras if k % 4 else ())]
        clouds = tuple(scan_cloud(m, scene, bodies, pose, time=0.05 * k, rng=rng) for m in mounts)
        seen = pose + rng.normal(0.0, error, 3) * [1.0, 1.0, 0.5] if error else pose
        ground = update_ground(ground, clouds, np.tile(seen, (len(clouds), 1)), grid, robot)
        maps.append(ground)
        if lead is None and len(ground.edges.cells):
            lead = EDGE - pose[0] - FRONT
        pose = pose + np.array([speed * 0.05, 0.0, 0.0])
        k += 1
    return ground, lead, pose, maps


def first_edge(ground):
    """x (n,) of the first cell behind an edge in each row of a way 2 m wide, m; NaN without."""
    cells = ground.edges.cells
    rows = [cells[cells[:, 0] == row][:, 1] for row in range(40, 80)]
    return np.array([0.05 * row.min() if len(row) else math.nan for row in rows])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("height", "rise", "steps"),
    [
        (-0.05, 0.0, 0),
        (-0.06, 0.0, 0),
        (-0.1, 0.0, 0),
        (-0.5, 0.0, 0),
        (0.0, -1.7, 10),
        (0.1, 0, 0),
    ],
    ids=["5 cm", "6 cm", "10 cm", "50 cm", "stairs", "kerb up"],
)
def test_an_edge_is_known_where_it_is_before_the_chair_is_there(height, rise, steps, seed):
    ground, lead, *_ = approach(beyond(height, rise, steps), seed=seed)
    # it stops from 0.8 m/s in 0.52 m: 0.25 s and 1 m/s²
    assert lead > 1.0
    at = first_edge(ground)
    # stairs begin with a step down of 17 cm
    assert not np.isnan(at).any()
    assert np.abs(at - EDGE).max() <= 0.1 + 1e-9


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "pieces",
    [
        (),
        (piece((EDGE, 3.0), (0.2, 5.5), 0.02),),
        (piece((EDGE + 2.0, 3.0), (4.0, 6.0), 0.0, 4.0 / 12.0),),
        (piece((EDGE + 2.0, 3.0), (4.0, 6.0), 0.0, -4.0 / 20.0),),
        (piece((EDGE, 3.0), (3.0, 6.0), -0.01), piece((EDGE, 4.0), (1.0, 1.0), 0.01)),
    ],
    ids=["level", "bar of 2 cm", "1:12 up", "1:20 down", "mats of 1 cm"],
)
def test_safe_floors_have_no_edge_in_the_way(pieces, seed):
    ground, *_ = approach(pieces, seed=seed)
    cells = ground.edges.cells * 0.05
    in_way = (np.abs(cells[:, 0] - 3.0) < 0.6) & (cells[:, 1] < EDGE + 0.5)
    assert not in_way.any()


def test_without_clouds_nothing_is_known():
    grid = hall()
    assert update_ground(None, (), np.empty((0, 3)), grid, CHAIR) is None
    cloud = PointCloud(
        time=0.0, mount=np.full(6, np.nan), points=np.zeros((4, 3), np.float32), range_max=9.0
    )
    assert update_ground(None, (cloud,), np.zeros((1, 3)), grid, CHAIR) is None


def test_an_update_leaves_its_argument_as_it_was():
    ground, _, pose, _ = approach(beyond(-0.1), stop=1.0)
    grid, rng = hall(), np.random.default_rng(5)
    before = [each.copy() for each in ground.cells]
    scene = StaticScene(grid=grid, ceiling=2.5)
    clouds = tuple(scan_cloud(m, scene, NOBODY, pose, time=9.0, rng=rng) for m in CHAIR.lidars)
    after = update_ground(ground, clouds, pose[None], grid, CHAIR)
    assert identical(before, list(ground.cells))
    assert not identical(before, list(after.cells))
    assert not any(each.flags.writeable for each in after.cells)


def test_a_chair_that_pitches_sees_no_edges():
    # the sensors nod by 1° and nobody tells the map
    ground, grid = None, hall()
    scene, rng = StaticScene(grid=grid, ceiling=2.5), np.random.default_rng(0)
    for k in range(40):
        nod, clouds = math.radians(math.sin(0.4 * k)), []
        pose = np.array([2.0 + 0.04 * k, 3.0, 0.0])
        for mount in (*CHAIR.lidars, *CHAIR.depth_cameras):
            x, y, z, roll, pitch, yaw = mount.pose
            nodding = mount.model_copy(update={"pose": (x, y, z - nod * x, roll, pitch + nod, yaw)})
            cloud = scan_cloud(nodding, scene, NOBODY, pose, time=0.0, rng=rng)
            clouds.append(replace(cloud, mount=np.array(mount.pose)))
        ground = update_ground(ground, tuple(clouds), np.tile(pose, (2, 1)), grid, CHAIR)
    cells = ground.edges.cells * 0.05
    assert not (np.abs(cells[:, 0] - 3.0) < 0.6).any()


def test_a_person_who_stands_in_the_way_is_no_edge():
    person = HumanBodies.standing(np.array([[EDGE, 3.0]]))
    ground, *_ = approach((), bodies=person, stop=0.8)
    cells = ground.edges.cells * 0.05
    assert not (np.hypot(cells[:, 0] - 3.0, cells[:, 1] - EDGE) < 1.0).any()


def test_at_first_a_chair_knows_only_the_floor_on_which_it_could_turn():
    grid, rng = hall(), np.random.default_rng(0)
    scene, pose = StaticScene(grid=grid, ceiling=2.5), np.array([5.0, 3.0, 0.0])
    camera = CHAIR.depth_cameras[0]
    cloud = scan_cloud(camera, scene, NOBODY, pose, time=0.0, rng=rng)
    ground = update_ground(None, (cloud,), pose[None], grid, CHAIR)

    def known(twist, **which):
        return known_floor(ground, grid, CHAIR.wheels, pose, np.array(twist), **which)

    ahead = known([0.5, 0.0, 0.0], seen=False)
    back = known([-0.5, 0.0, 0.0], seen=False)
    turn = known([0.0, 0.0, 0.5], seen=False)
    # the camera sees floor from 0.98 m on: a ring of it is known by nobody
    radius = CHAIR.circumscribed_radius + 0.1
    wheels = CHAIR.wheels[:, 0]
    assert ahead == pytest.approx(radius - wheels.max(), abs=0.1)
    assert back == pytest.approx(radius + wheels.min(), abs=0.1)
    assert turn == pytest.approx(2.5, abs=0.06)
    assert known([0.0, 0.0, 0.0]) == 2.5
    # it has seen none of that
    assert known([0.5, 0.0, 0.0]) < 0.05
    assert known([-0.5, 0.0, 0.0]) < 0.05


def test_floor_that_was_assumed_does_not_hold_against_rays_that_pass_below_it():
    pose = np.array([EDGE - 0.7, 3.0, 0.0])  # within the circle in which the chair can turn
    grid, rng = hall(), np.random.default_rng(0)
    cells = floor_cells(FloorRelief(pieces=beyond(-0.5)), grid)
    scene, ground = StaticScene(grid=grid, cells=cells, ceiling=2.5), None
    for _ in range(4):
        clouds = tuple(
            scan_cloud(m, scene, NOBODY, pose, time=0.0, rng=rng)
            for m in (*CHAIR.lidars, *CHAIR.depth_cameras)
        )
        ground = update_ground(ground, clouds, np.tile(pose, (2, 1)), grid, CHAIR)
    at = first_edge(ground)[10:30]
    assert np.abs(at - EDGE).max() <= 0.25


def test_dark_floor_is_neither_known_nor_an_edge():
    ground, _, pose, _ = approach((piece((EDGE + 1.5, 3.0), (3.0, 5.5), dark=True),))
    assert not (np.abs(first_edge(ground) - EDGE) < 1.0).any()
    way = known_floor(ground, hall(), CHAIR.wheels, pose, np.array([0.5, 0.0, 0.0]))
    wheel = CHAIR.wheels[:, 0].max()
    assert way == pytest.approx(EDGE - pose[0] - wheel, abs=0.11)


def test_the_map_remembers_what_passes_below_its_sensors():
    ground, _, pose, _ = approach(())
    corner = ground.corner * 0.05
    row, col = ((pose[[1, 0]] - corner) / 0.05).astype(int)
    assert (ground.kind[row - 6 : row + 7, col - 10 : col + 14] == FLOOR).all()


def test_edges_are_remembered_when_they_leave_the_window_and_forgotten_when_floor_is_seen():
    grid, rng = hall(), np.random.default_rng(0)
    cells = floor_cells(FloorRelief(pieces=beyond(-0.2)), grid)
    pit = StaticScene(grid=grid, cells=cells, ceiling=2.5)
    level = StaticScene(grid=grid, ceiling=2.5)

    def look(ground, scene, x, times=4):
        pose = np.array([x, 3.0, 0.0])
        for _ in range(times):
            clouds = tuple(
                scan_cloud(m, scene, NOBODY, pose, time=0.0, rng=rng) for m in CHAIR.depth_cameras
            )
            ground = update_ground(ground, clouds, pose[None], grid, CHAIR)
        return ground

    near = look(None, pit, 4.5)
    assert (near.kind == LOWER).any()
    away = look(near, pit, 1.0)
    assert len(away.edges.cells) > 0.5 * len(near.edges.cells)
    back = look(away, pit, 4.5, times=1)
    assert (first_edge(back) <= EDGE + 0.1).mean() > 0.9
    mended = look(back, level, 4.5, times=12)
    seen = first_edge(mended)
    assert not (np.abs(seen[10:30] - EDGE) < 0.3).any()


def test_remembered_edges_do_not_grow_when_they_come_back():
    n = np.zeros((60, 60), dtype=np.uint8)
    cells = GroundCells(n.astype(np.float32), n, n.astype(np.float32), n.copy(), n.copy(), n.copy())
    cells.bound[30:36, 30:36], cells.passed[30:36, 30:36] = -np.inf, 255
    rules = rules_of(CHAIR, 0.05, GroundParameters())
    for _ in range(3):
        update_kinds(cells, np.array([0.5, 1.5]), 0.0, rules)
        assert np.count_nonzero(cells.kind == LOWER) == 36


@pytest.mark.parametrize("depth", [0.2, 0.5, 1.2])
def test_floor_that_goes_away_is_forgotten(depth):
    # a platform lift that has been seen, and goes down when the chair is near
    ground, *_ = approach(beyond(-depth), level_until=1.5)
    at = first_edge(ground)
    assert not np.isnan(at).any()
    assert np.abs(at - EDGE).max() <= 0.1 + 1e-9


def test_mirrored_returns_are_no_drop():
    level, *_ = approach((), stop=1.5)
    grid, rng = hall(), np.random.default_rng(0)
    scene, pose = StaticScene(grid=grid, ceiling=2.5), np.array([EDGE - FRONT - 1.5, 3.0, 0.0])
    ground = level
    for k in range(20):
        clouds = []
        for mount in (*CHAIR.lidars, *CHAIR.depth_cameras):
            cloud = scan_cloud(mount, scene, NOBODY, pose, time=9.0 + 0.1 * k, rng=rng)
            # one return in ten comes from as far again, along its ray: below the floor
            twice = np.where(rng.random((len(cloud.points), 1)) < 0.1, 2.0, 1.0)
            points = (twice * cloud.points).astype(np.float32)
            clouds.append(replace(cloud, points=points))
        ground = update_ground(ground, tuple(clouds), np.tile(pose, (2, 1)), grid, CHAIR)
    x, y = grid.centres(ground.edges.cells).T
    # farther away, floor beyond is too sparsely seen to tell
    assert not ((np.abs(y - 3.0) < 0.6) & (x > pose[0]) & (x < pose[0] + 2.4)).any()


def test_edges_are_obstacles_of_the_live_layer():
    ground, *_ = approach(beyond(-0.2), stop=0.5)
    live = LiveObstacles(
        occupied=np.zeros((60, 60), dtype=np.uint8), corner=np.array([30, 100]), version=3
    )
    both = with_edges(live, ground.edges)
    assert with_edges(live, ground.edges) is both
    cells = ground.edges.cells
    inside = ((cells >= live.corner) & (cells < live.corner + 60)).all(axis=1)
    assert both.occupied.sum() == len(np.unique(cells[inside], axis=0)) > 0
    assert live.occupied.sum() == 0
    assert both.version == 3 + ground.edges.version


def test_a_leg_beside_an_edge_that_may_be_crossed_stays_an_obstacle():
    ground, *_ = approach(beyond(-0.2), stop=0.5)
    corner = np.array([30, 100])
    row, col = ground.edges.cells[len(ground.edges.cells) // 2] - corner
    occupied = np.zeros((60, 60), dtype=np.uint8)
    occupied[row, col] = occupied[row, col - 3] = 1  # the step's face, and a leg before it
    live = LiveObstacles(occupied=occupied, corner=corner, version=3)
    tall = np.zeros_like(ground.tall)
    tall[*(np.array([row, col - 3]) + corner - ground.corner)] = 10
    left = open_edges(live, replace(ground, tall=tall))
    assert np.argwhere(left.occupied).tolist() == [[row, col - 3]]
    assert left.version != with_edges(live, ground.edges).version
