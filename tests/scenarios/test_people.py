import numpy as np
import pytest

from cohelm.errors import ScenarioError
from cohelm.geometry import nearest_on_polyline, resample
from cohelm.maps import OccupancyGrid, distance_field
from cohelm.scenarios import build_scenario, load_scenario, make_crowd
from cohelm.scenarios.crowd import SPACING
from cohelm.scenarios.pedestrian_spec import CrowdSpec, PedestrianSpec
from cohelm.scenarios.walkable import walkable


@pytest.fixture(scope="module")
def stages():
    return [build_scenario(load_scenario("hospital"), seed) for seed in range(4)]


def ways(crowd):
    return [each[np.isfinite(each[:, 0])] for each in crowd.waypoints]


def test_there_are_as_many_as_asked_for_and_they_walk_to_and_fro(stages):
    for stage in stages:
        crowd = stage.world.crowd
        assert len(crowd.radius) == 12
        assert crowd.loop.all()
        assert crowd.sees_robot.all()
        assert ((crowd.preferred_speed >= 0.9) & (crowd.preferred_speed <= 1.3)).all()


def test_starts_keep_their_distance_from_the_chair_and_each_other(stages):
    for stage in stages:
        starts = np.concatenate([stage.start[None, :2], stage.world.crowd.position])
        apart = np.hypot(*(starts[:, None] - starts[None]).T)
        np.fill_diagonal(apart, np.inf)
        assert apart.min() > SPACING - 2 * 0.05 - 1e-9  # each is jittered by up to 5 cm


def test_every_way_meets_the_route_and_keeps_off_the_walls(stages):
    for stage in stages:
        field = distance_field(stage.world.grid)
        route = np.ascontiguousarray(stage.route.points)
        for way in ways(stage.world.crowd):
            points = resample(np.concatenate([way, way[:1]]), 0.1)
            assert min(nearest_on_polyline(route, x, y)[1] for x, y in points) < 0.5
            # a way is clear by radius and margin at cell centres; between them by a cell less
            assert field.at(points).min() > 0.25 - 0.15


def test_they_are_drawn_from_the_seed_alone(stages):
    again = build_scenario(load_scenario("hospital"), 1).world.crowd
    assert np.array_equal(again.position, stages[1].world.crowd.position)
    assert not np.array_equal(again.position, stages[2].world.crowd.position)


def test_explicit_ways_come_first_and_drawn_ones_make_up_the_count(stages, rng):
    explicit = PedestrianSpec(points=((33.0, 8.0), (30.0, 8.0)), speed=0.5, see_robot=False)
    stage = stages[0]
    crowd = make_crowd(
        CrowdSpec(pedestrians=(explicit,), count=3, jitter=0.0), stage.grid, stage.route.points, rng
    )
    assert len(crowd.radius) == 3
    assert np.array_equal(crowd.position[0], [33.0, 8.0])
    assert crowd.preferred_speed[0] == 0.5
    assert list(crowd.sees_robot) == [False, True, True]
    assert list(crowd.loop) == [False, True, True]


def test_nobody_is_nobody(stages, rng):
    crowd = make_crowd(CrowdSpec(), stages[0].grid, stages[0].route.points, rng)
    assert crowd.position.shape == (0, 2)


def test_jitter_moves_a_start_by_no_more_than_it_says(stages, rng):
    way = PedestrianSpec(points=((4.0, 8.0),))
    for _ in range(50):
        crowd = make_crowd(
            CrowdSpec(pedestrians=(way,)), stages[0].grid, stages[0].route.points, rng
        )
        assert np.hypot(*(crowd.position[0] - [4.0, 8.0])) <= 0.05


def test_walkable_cells_leave_room_for_a_body(stages):
    grid = stages[0].grid
    floor = walkable(grid, 0.25, stages[0].route.points)
    cells = np.argwhere(floor.free)
    assert (distance_field(grid).at(floor.points(cells)) > 0.25).all()
    assert floor.cell(floor.points(cells[:1])[0]) == tuple(cells[0])


def test_only_a_corridor_too_narrow_to_pass_in_is_narrow():
    # two halls joined by a corridor of 1.6 m: half of that is less than 1.05 m
    data = np.full((100, 200), 100, dtype=np.int8)
    data[5:95, 5:60] = data[5:95, 140:195] = 0
    data[42:58, 60:140] = 0
    grid = OccupancyGrid(data=data, resolution=0.1, X_MG=np.zeros(3))
    floor = walkable(grid, 0.25, np.array([[2.0, 5.0], [18.0, 5.0]]))
    assert floor.narrow[floor.cell(np.array([10.0, 5.0]))]
    assert not floor.narrow[floor.cell(np.array([2.0, 5.0]))]
    assert not floor.narrow[floor.cell(np.array([3.0, 1.0]))]


def test_ways_that_belong_together_are_a_group_and_walk_as_before():
    ways = [{"points": [(float(x), 5.0)]} for x in (2, 3, 6)]
    apart, together = (
        CrowdSpec.model_validate({"pedestrians": ways, "grouped": each}) for each in ((), [(0, 1)])
    )
    assert "grouped" not in apart.model_dump()
    assert together.model_dump()["grouped"] == ((0, 1),)
    grid = OccupancyGrid(data=np.zeros((100, 100), dtype=np.int8), resolution=0.1, X_MG=np.zeros(3))
    route = np.array([[1.0, 1.0], [9.0, 9.0]])
    one, other = (make_crowd(c, grid, route, np.random.default_rng(0)) for c in (apart, together))
    assert one.group is None
    assert other.group.tolist() == [0, 0, -1]
    assert np.array_equal(one.position, other.position)
    for wrong in ([(0, 3)], [(0, 1), (1, 2)]):
        with pytest.raises(ValueError, match="grouped"):
            CrowdSpec.model_validate({"pedestrians": ways, "grouped": wrong})


@pytest.fixture(scope="module")
def floor_without_goal():
    """A chair in the corner of two halls, each 12 m square, joined by a corridor."""
    data = np.full((140, 400), 100, dtype=np.int8)
    data[10:130, 10:130] = data[10:130, 270:390] = 0
    data[60:80, 130:270] = 0
    data[0:8, 0:8] = 0  # a space that nobody can leave
    grid = OccupancyGrid(data=data, resolution=0.1, X_MG=np.zeros(3))
    return grid, np.array([[2.0, 2.0], [2.0, 2.0]])


def test_without_a_goal_people_walk_over_the_whole_connected_floor(floor_without_goal):
    grid, route = floor_without_goal
    field = distance_field(grid)
    crowd = make_crowd(CrowdSpec(count=24), grid, route, np.random.default_rng(1))
    assert len(crowd.radius) == 24
    assert crowd.loop.all()
    # Both halls have people, none of them starts at the chair, and their routes pass far from it.
    assert (crowd.position[:, 0] < 13.0).sum() > 4
    assert (crowd.position[:, 0] > 27.0).sum() > 4
    assert np.hypot(*(crowd.position - route[0]).T).min() > SPACING - 0.1
    nearest = [np.hypot(*(resample(way, 0.1) - route[0]).T).min() for way in ways(crowd)]
    assert np.median(nearest) > 4.0
    for way in ways(crowd):
        points = resample(np.concatenate([way, way[:1]]), 0.1)
        assert field.at(points).min() > 0.25 - 0.15
        assert points[:, 0].min() > 0.9  # the closed space stays empty


def test_without_a_goal_the_crowd_is_drawn_from_the_seed_alone(floor_without_goal):
    grid, route = floor_without_goal
    one, same, other = (
        make_crowd(CrowdSpec(count=6), grid, route, np.random.default_rng(seed))
        for seed in (1, 1, 2)
    )
    assert np.array_equal(one.waypoints, same.waypoints, equal_nan=True)
    assert not np.array_equal(one.position, other.position)


def test_without_a_goal_too_many_people_are_refused(floor_without_goal):
    data = np.full((60, 60), 100, dtype=np.int8)
    data[10:50, 10:50] = 0
    grid = OccupancyGrid(data=data, resolution=0.1, X_MG=np.zeros(3))
    route = np.array([[3.0, 3.0], [3.0, 3.0]])
    with pytest.raises(ScenarioError, match="there is space for") as caught:
        make_crowd(CrowdSpec(count=60), grid, route, np.random.default_rng(0))
    assert caught.value.key == "people.count"
