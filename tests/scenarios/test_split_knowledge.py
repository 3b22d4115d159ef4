"""Scenes of the study of sharing: what the chair lacks is there, and the rider can get past it."""

import numpy as np
import pytest

from cohelm.benchmarks.rides.sharing_families import FAMILIES, SHIFT, TURN, beside_start
from cohelm.errors import ScenarioError
from cohelm.geometry import resample, transform
from cohelm.maps import distance_field
from cohelm.scenarios.build import build_scenario
from cohelm.scenarios.scenario import load_scenario
from cohelm.simulation import World
from cohelm.simulation.split_knowledge import grid_views
from cohelm.simulation.world import view_from


def names(*families):
    return [scene for family in families for scene in FAMILIES[family].scenes]


def built(name, *settings):
    return build_scenario(load_scenario(name, settings), 0)


def views(setup):
    return grid_views(setup.world.grid, setup.world.split)


def clearance(grid, line):
    return distance_field(grid).at(resample(line, 0.05)).min()


@pytest.mark.parametrize("name", ["glass-box", "glass-bench", "table-overhang"])
def test_an_obstacle_that_no_sensor_detects_is_real_and_on_no_map(name):
    setup = built(name)
    seen = views(setup)
    hidden = seen.truth.occupied() & ~seen.sensed.occupied()
    assert hidden.sum() > 20
    assert not (hidden & setup.grid.occupied()).any()
    assert (seen.rider.occupied() == seen.truth.occupied()).all()


def test_the_leg_of_the_table_is_sensed_and_its_top_is_not():
    setup = built("table-overhang")
    sensed = views(setup).sensed.occupied()
    row, col = setup.grid.cells(np.array([7.0, 7.0]))
    assert sensed[row, col]
    row, col = setup.grid.cells(np.array([7.0, 7.6]))
    assert not sensed[row, col]
    assert setup.world.grid.occupied()[row, col]


def test_a_scan_passes_glass_and_the_rider_sees_it():
    setup = built("glass-box", "start=[5, 7, 0]")
    scan = World(setup.world, 0).observe().scans[0]
    ahead = np.argmin(np.abs(scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))))
    assert np.nanmin(scan.ranges[ahead - 2 : ahead + 3]) > 8.0
    _, free = view_from(views(setup).truth, setup.start, setup.world.crowd, views(setup).rider)
    assert free[len(free) // 2] == pytest.approx(1.6, abs=0.06)


def test_no_beam_meets_the_person_of_the_dead_sector():
    with_person, alone = built("dead-sector"), built("dead-sector", "people.count=0")
    scans = [World(each.world, 0).observe().scans[0].ranges for each in (with_person, alone)]
    assert np.array_equal(*scans, equal_nan=True)
    people, _ = view_from(with_person.world.grid, with_person.start, with_person.world.crowd)
    assert len(people) == 1


def test_a_wet_floor_is_no_obstacle_and_the_rider_keeps_clear_of_it():
    setup = built("wet-floor")
    seen = views(setup)
    assert seen.sensed is seen.truth
    assert (seen.rider.occupied() & ~seen.truth.occupied()).sum() > 500
    assert clearance(seen.rider, setup.route.points) < setup.robot.inscribed_radius
    pose = np.array([2.0, 6.5, 0.0])
    _, free = view_from(seen.truth, pose, setup.world.crowd, seen.rider)
    assert free[len(free) // 2] == pytest.approx(1.0, abs=0.06)


@pytest.mark.parametrize("name", names("old-map"))
def test_an_old_map_differs_from_the_world_where_the_routes_do(name):
    setup = built(name)
    radius = setup.robot.inscribed_radius
    assert clearance(setup.grid, setup.route.points) >= radius
    assert clearance(setup.world.grid, setup.route.points) < radius
    assert clearance(setup.world.grid, setup.world.rider_route) >= radius


def test_the_map_lacks_the_new_door():
    setup = built("moved-door")
    assert clearance(setup.grid, setup.world.rider_route) < 0.05
    assert [door.a[1] > 6.0 for door in setup.world.doors] == [True]


def test_a_goal_is_another_one_or_none():
    changed, untold = built("new-goal"), built("untold-goal")
    assert np.hypot(*(changed.request.goal - changed.arrival)) > 5.0
    assert changed.arrival.tolist() == changed.world.goal_change.goal.tolist()
    assert np.isnan(untold.request.goal).all()
    assert untold.arrival.tolist() == [7.0, 12.5]


@pytest.mark.parametrize("name", names("way"))
def test_only_the_rider_s_route_passes_the_wanted_places(name):
    setup = built(name)
    plan = setup.scenario.rider_plan
    for place in plan.past:
        chair, rider = (
            np.hypot(*(resample(line, 0.05) - place).T).min()
            for line in (setup.route.points, setup.world.rider_route)
        )
        assert rider <= 0.1
        assert chair > 2.0 * plan.past_distance
    assert np.allclose(setup.request.goal, setup.arrival)


@pytest.mark.parametrize("name", names("hands"))
def test_where_hands_are_the_difficulty_the_chair_knows_map_and_goal(name):
    setup = built(name)
    assert setup.world.split is None
    assert setup.world.grid is setup.grid
    assert np.allclose(setup.request.goal, setup.arrival)


@pytest.mark.parametrize("name", names(*FAMILIES))
@pytest.mark.parametrize("seed", [0, 7])
def test_the_rider_can_get_where_the_rider_wants(name, seed):
    setup = built(name, *beside_start(name, seed))
    change = setup.world.goal_change
    lines = [setup.world.rider_route, *([change.route] if change else [])]
    for line in lines:
        assert clearance(views(setup).rider, line) >= setup.robot.inscribed_radius
    assert np.allclose(lines[-1][-1], setup.arrival)
    x, y, heading = load_scenario(name).start
    moved = setup.start - np.array([x, y, np.radians(heading)])
    across = transform([0.0, 0.0, -np.radians(heading)], moved[:2])
    assert np.allclose(across[0], 0.0, atol=1e-3)
    assert 0.0 < abs(across[1]) <= SHIFT
    assert abs(np.degrees(moved[2])) <= TURN


def test_changes_of_the_world_need_a_drawing(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("map: floor.yaml\nstart: [1, 1]\ngoal: [2, 2]\nworld_plan: {size: [3, 3]}\n")
    with pytest.raises(ScenarioError, match="world_plan needs floor: NAME"):
        load_scenario(file)
    with pytest.raises(ScenarioError, match=r"world_plan\.doors\.7.*the list has 1 entries"):
        built("moved-door", "world_plan={doors: {7: {at: [7, 7.5]}}}")
