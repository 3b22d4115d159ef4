import numpy as np
import pytest
import yaml

from cohelm.errors import ConfigError, MapError, PlanningError, ScenarioError
from cohelm.maps import OccupancyGrid
from cohelm.messages import Mode
from cohelm.scenarios import build_scenario, load_scenario, scenario_names
from cohelm.scenarios.floor import grid_changes, with_heights, with_obstacles
from cohelm.scenarios.objects import Obstacle, ScheduledDoor


@pytest.fixture
def write(tmp_path):
    def _write(**keys):
        file = tmp_path / "mine.yaml"
        given = {"floor": "hall", "start": [2, 7], "goal": [12, 7], **keys}
        file.write_text(yaml.safe_dump({k: v for k, v in given.items() if v is not None}))
        return file

    return _write


@pytest.mark.parametrize("name", scenario_names())
def test_every_scenario_that_comes_along_can_be_set_on_stage(name):
    stage = build_scenario(load_scenario(name), 0)
    assert stage.scenario.name == name
    assert stage.scenario.description
    assert np.allclose(stage.route.points[0], stage.start[:2])
    plan = stage.scenario.rider_plan
    if plan is None or plan.goal_told:
        assert np.allclose(stage.route.points[-1], stage.request.goal)


@pytest.mark.parametrize("name", ["crossing", "aggressive", "distracted", "empty"])
def test_start_and_goal_of_the_papers_scenes_are_ten_metres_apart(name):
    stage = build_scenario(load_scenario(name), 0)
    apart = np.hypot(*(stage.request.goal - stage.start[:2]))
    assert apart == pytest.approx(10.0, abs=0.005)


def test_a_scenario_needs_little(write):
    scenario = load_scenario(write())
    assert scenario.name == "mine"
    assert scenario.mode is Mode.SHARED
    assert scenario.local_planner == {"use": "ss_mpc_dcbf"}


def test_a_part_is_a_name_or_a_mapping(write):
    assert load_scenario(write(rider="idle")).rider == {"use": "idle"}
    assert load_scenario(write(rider={"use": "nudge", "side": "right"})).rider["side"] == "right"


def test_settings_reach_into_parts_that_the_file_only_names_or_leaves_out(write):
    file = write(rider="nudge")
    scenario = load_scenario(file, ["rider.side=right", "people.model.max_neighbors=3"])
    assert scenario.rider == {"use": "nudge", "side": "right"}
    assert load_scenario(file, ["mode=autonomous"]).mode is Mode.AUTONOMOUS
    settings = ["global_planner.cost_weight=2"]
    assert load_scenario(file, settings).global_planner == {"use": "soft_via", "cost_weight": 2}


@pytest.mark.parametrize(
    ("keys", "key", "says"),
    [
        ({"gaol": [1, 2]}, "gaol", "did you mean 'goal'"),
        ({"people": {"cuont": 3}}, "people.cuont", "did you mean 'count'"),
        ({"people": {"speed": [2, 1]}}, "people", "lowest"),
        ({"profile": {"preferred_spead": 1}}, "profile.preferred_spead", "preferred_speed"),
        ({"floor": None}, "", "floor: NAME or map"),
        ({"floor": "hospitl"}, "floor", "did you mean 'hospital'"),
        ({"start": [1]}, "start", "[x, y]"),
        ({"goal": None}, "goal", "missing"),
        ({"mode": "automatic"}, "mode", "autonomous"),
        ({"obstacles": [{"at": [1, 1]}]}, "obstacles.0", "size"),
        ({"time_limit": -1}, "time_limit", "greater than or equal to 0.05"),
    ],
)
def test_a_wrong_scenario_names_file_key_and_remedy(write, keys, key, says):
    file = write(**keys)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(file)
    assert caught.value.file == file
    assert caught.value.key == key
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"local_planner": {"use": "ss_mpc_dcbf", "horizn": 2}}, "local_planner.horizn: unknown"),
        ({"local_planner": "ss_mpc"}, "did you mean 'ss_mpc_dcbf'"),
        ({"people": {"model": "orka", "count": 1}}, "did you mean 'orca'"),
        ({"start": "Wset"}, "did you mean 'West'"),
        ({"robot": "quantum"}, "no robot is called 'quantum'"),
        ({"people": {"count": 300}}, "there is space for"),
    ],
)
def test_what_only_the_stage_can_know_is_refused_there(write, keys, says):
    with pytest.raises(ConfigError) as caught:
        build_scenario(load_scenario(write(**keys)), 0)
    assert says in str(caught.value)


def test_a_goal_in_a_wall_is_a_planning_error(write):
    with pytest.raises(PlanningError):
        build_scenario(load_scenario(write(goal=[0.0, 7.0])), 0)


def test_names_of_places_and_headings(write):
    stage = build_scenario(load_scenario(write(start="West", goal="North")), 0)
    assert np.allclose(stage.start[:2], [2, 7])
    turned = build_scenario(load_scenario(write(start=[2, 7, 90])), 0)
    assert turned.start[2] == pytest.approx(np.pi / 2)


def test_a_file_beside_the_scenario_is_found(write, tmp_path):
    robot = {
        "name": "mine",
        "footprint": [[0.3, 0.3], [-0.3, 0.3], [-0.3, -0.3], [0.3, -0.3]],
        "max_speed": 1.0,
        "max_turn_rate": 1.0,
        "max_acceleration": 1.0,
        "max_deceleration": 1.0,
        "emergency_deceleration": 1.0,
        "max_turn_acceleration": 1.0,
    }
    (tmp_path / "chair.yaml").write_text(yaml.safe_dump(robot))
    assert build_scenario(load_scenario(write(robot="chair.yaml")), 0).robot.name == "mine"


def test_obstacles_cover_the_cells_whose_centres_they_hold():
    grid = OccupancyGrid(
        data=np.zeros((40, 40), dtype=np.int8), resolution=0.1, X_MG=np.array([1.0, 2.0, 0.4])
    )
    box = Obstacle(at=(2.0, 4.5), size=(0.6, 0.3), angle_deg=30.0)
    disc = Obstacle(at=(3.0, 4.0), radius=0.3)
    covered = with_obstacles(grid, (box,)).occupied().sum() * 0.01
    assert covered == pytest.approx(0.6 * 0.3, abs=0.05)
    covered = with_obstacles(grid, (disc,)).occupied().sum() * 0.01
    assert covered == pytest.approx(np.pi * 0.09, abs=0.05)
    assert with_obstacles(grid, ()) is grid


def test_heights_are_those_of_the_last_thing_that_stands_there():
    grid = OccupancyGrid(
        data=np.zeros((40, 40), dtype=np.int8), resolution=0.1, X_MG=np.array([1.0, 2.0, 0.4])
    )
    low = Obstacle(at=(2.0, 4.5), size=(0.6, 0.3), height=0.4)
    wall = Obstacle(at=(2.0, 4.5), radius=0.1)
    assert with_heights(None, grid, (wall,)) is None
    heights = with_heights(None, grid, (low, wall))
    covered = with_obstacles(grid, (low,)).occupied() & ~with_obstacles(grid, (wall,)).occupied()
    assert (heights[covered] == np.float32(0.4)).all()
    assert np.isnan(heights[~covered]).all()


def test_the_furniture_of_a_floor_is_as_high_as_its_plan_says(write):
    stage = build_scenario(load_scenario("lidar"), 0)
    heights, grid = stage.world.heights, stage.world.grid
    bed, stool, column = ([1.5, 22.8], [14.0, 18.9], [7.0, 10.2])
    found = [float(heights[tuple(grid.cells(point))]) for point in (bed, stool, column)]
    np.testing.assert_allclose(found, [0.7, 0.5, np.nan], rtol=1e-6)
    assert stage.world.ceiling == stage.world.wall_height == 2.5
    assert ((stage.world.statures >= 1.55) & (stage.world.statures <= 1.9)).all()


# ------------------------------------------------------------------ wishes, doors, masks, crowds


def test_preferred_points_are_wishes_of_their_own_or_one_wish_in_order(write):
    stage = build_scenario(load_scenario(write(prefer=[[5, 9], [[6, 5], [8, 9]]])), 0)
    assert [len(wish.points) for wish in stage.request.wishes] == [1, 2]
    assert stage.prefer.tolist() == [[5, 9], [6, 5], [8, 9]]


def test_strokes_and_zones_reach_the_planner(write):
    avoid = [
        {"points": [[7, 7]], "radius": 1.0},
        {"points": [[4, 4], [5, 4], [5, 5]], "hard": True},
    ]
    stage = build_scenario(load_scenario(write(stroke=[[3, 9], [11, 9]], avoid=avoid)), 0)
    kinds = [(wish.kind, wish.radius, wish.hard) for wish in stage.request.wishes]
    assert kinds == [("stroke", 0.0, False), ("avoid", 1.0, False), ("avoid", 0.0, True)]
    beside = np.hypot(*(stage.route.points - [7, 7]).T).min()
    assert beside > 0.9


def test_doors_make_the_same_grid_whenever_the_same_ones_are_closed():
    grid = OccupancyGrid(data=np.zeros((40, 40), dtype=np.int8), resolution=0.1, X_MG=np.zeros(3))
    one = ScheduledDoor(at=(1.0, 1.0), size=(1.0, 0.2), closed=((2.0, 4.0), (8.0, 9.0)))
    two = ScheduledDoor(at=(3.0, 3.0), size=(1.0, 0.2), closed=((3.0, 5.0),))
    made = grid_changes(grid, (one, two))
    assert [change.time for change in made] == [0.0, 2.0, 3.0, 4.0, 5.0, 8.0, 9.0]
    grids = [change.grid for change in made]
    assert grids[0] is grids[4] is grids[6] is grid
    assert grids[1] is grids[5]
    # 10 × 2 cells each
    assert [int(g.occupied().sum()) for g in grids] == [0, 20, 40, 20, 0, 20, 0]


def test_a_door_that_is_closed_at_first_is_closed_in_the_world_and_open_on_the_map(write):
    door = {"at": [7, 7], "size": [0.2, 2.0], "closed": [[0, 9]]}
    stage = build_scenario(load_scenario(write(doors=[door])), 0)
    assert stage.world.grid.occupied().sum() > stage.grid.occupied().sum()
    (opening,) = stage.world.changes
    assert opening.time == 9.0
    assert np.array_equal(opening.grid.data, stage.grid.data)


def test_a_heat_map_moves_the_first_route(write, tmp_path):
    people = np.zeros((140, 140), dtype=np.uint8)
    people[40:100, 60:80] = 100
    (tmp_path / "heat.pgm").write_bytes(b"P5 140 140 255\n" + people[::-1].tobytes())
    header = {"image": "heat.pgm", "mode": "raw", "resolution": 0.1, "origin": [0, 0, 0]}
    header |= {"negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.25}
    (tmp_path / "heat.yaml").write_text(yaml.safe_dump(header))
    alone = build_scenario(load_scenario(write()), 0)
    among = build_scenario(load_scenario(write(crowding="heat.yaml")), 0)
    assert np.abs(alone.route.points[:, 1] - 7.0).max() < 0.5
    assert np.abs(among.route.points[:, 1] - 7.0).max() > 2.0
    assert among.navigator.heat is not None


@pytest.mark.parametrize(
    ("keys", "key"),
    [
        ({"stroke": [[1, 1]]}, ""),
        ({"avoid": [{"points": [[1, 1]]}]}, "avoid.0"),
        ({"doors": [{"at": [1, 1], "size": [1, 1], "closed": [[5, 4]]}]}, "doors.0"),
        ({"doors": [{"at": [1, 1], "size": [1, 1], "closed": []}]}, "doors.0.closed"),
        ({"filters": [{"type": "keep_out", "file": "a.yaml"}]}, "filters.0.type"),
        ({"filters": [{"file": "a.yaml"}]}, "filters.0"),
        ({"prefer": [[]]}, "prefer.0"),
    ],
)
def test_wrong_wishes_doors_and_masks_name_their_key(write, keys, key):
    with pytest.raises(ScenarioError) as caught:
        load_scenario(write(**keys))
    assert caught.value.key == key


def test_a_mask_takes_its_numbers_from_nav2s_samples_or_its_description(write, tmp_path):
    header = {"image": "slow.pgm", "mode": "raw", "resolution": 0.1, "origin": [0, 0, 0]}
    header |= {"negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.25}
    (tmp_path / "slow.pgm").write_bytes(b"P5 140 140 255\n" + bytes([30]) * 140 * 140)
    (tmp_path / "slow.yaml").write_text(yaml.safe_dump(header))
    (tmp_path / "nav2.yaml").write_text("{type: 2, base: 0.1, multiplier: 0.01}")
    filters = [
        {"type": "speed_percent", "file": "slow.yaml"},
        {"file": "slow.yaml", "info": "nav2.yaml"},
        {"file": "slow.yaml", "info": "nav2.yaml", "base": 0.2},
    ]
    built = build_scenario(load_scenario(write(filters=filters)), 0).navigator.filters
    found = [(each.type, each.base, each.multiplier) for each in built]
    assert found == [
        ("speed_percent", 100.0, -1.0),
        ("speed_absolute", 0.1, 0.01),
        ("speed_absolute", 0.2, 0.01),
    ]
    wrong = [{"type": "keepout", "file": "slow.yaml", "info": "nav2.yaml"}]
    with pytest.raises(MapError, match=r"nav2\.yaml: describes no mask of type keepout"):
        build_scenario(load_scenario(write(filters=wrong)), 0)


def test_a_mask_that_is_not_there_is_named(write):
    filters = [{"type": "keepout", "file": "nowhere.yaml"}]
    with pytest.raises(MapError, match=r"nowhere\.yaml"):
        build_scenario(load_scenario(write(filters=filters)), 0)
