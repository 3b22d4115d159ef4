"""The scenario library: cards that pose what they are called, flowsand floors."""

import json
import math
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
import yaml

from cohelm.benchmarks.paper.global_planners import office
from cohelm.benchmarks.rides import cards as bench
from cohelm.benchmarks.study import varied
from cohelm.config import override
from cohelm.errors import ConfigError, ScenarioError
from cohelm.evaluation import run
from cohelm.evaluation.episode.ride import Outcome
from cohelm.evaluation.metrics.people import side_by_side_share
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.maps import distance_field
from cohelm.scenarios import build_scenario, load_scenario, scenario_names
from cohelm.scenarios.collection import Collection
from cohelm.scenarios.crowd import MIN_SPACING, ROBOT_CLEARANCE, flow_routes
from cohelm.scenarios.floor import floor_plan
from cohelm.scenarios.pedestrian_spec import FlowSpec
from cohelm.scenarios.picture import draw_scenario
from cohelm.simulation import generator

CARDS = bench.known_cards()
OFFICES = tuple(f"office-{i}" for i in range(10))
PAGE = Path(__file__).parents[2] / "docs" / "scenarios.md"
FAR = np.array([-50.0, -50.0])  # a chair in nobody's way


@lru_cache(maxsize=64)
def staged(name, *settings):
    return build_scenario(load_scenario(name, settings), 0)


def way(stage, i):
    points = stage.world.crowd.waypoints[i]
    return points[np.isfinite(points).all(axis=1)]


def bearing(stage, i):
    """Of person i as the chair stands at its start, rad."""
    x, y = stage.world.crowd.position[i] - stage.start[:2]
    return math.remainder(math.atan2(y, x) - stage.start[2], 2.0 * math.pi)


def in_sight(stage, i):
    ends = np.array([stage.start[:2], stage.world.crowd.position[i]])
    line = ends[0] + np.linspace(0.0, 1.0, 200)[:, None] * (ends[1] - ends[0])
    return bool(distance_field(stage.world.grid).at(line).min() > 0.0)


def width_at(stage, point, across):
    """Free width through a point across a direction, m."""
    aside = np.array([-math.sin(across), math.cos(across)])
    steps = np.arange(0.0, 10.0, 0.01)
    field = distance_field(stage.grid)
    return sum(
        steps[int(np.argmax(field.at(point + side * steps[:, None] * aside) <= 0.0))]
        for side in (-1.0, 1.0)
    )


def test_every_card_of_the_list_is_there():
    assert set(CARDS) == {
        "frontal", "overtaking", "overtaken", "intersection", "blind-corner", "narrow-hallway",
        "narrow-doorway", "entering-room", "leaving-room", "joining-group", "leaving-group",
        "parallel-flow", "perpendicular-flow", "circular-flow", "circular-crossing", "crowding",
        "accompanying",
    }  # fmt: skip


@pytest.mark.parametrize("name", CARDS)
def test_nobody_of_a_card_starts_in_a_wall_or_in_the_chair(name):
    stage = staged(name)
    crowd = stage.world.crowd
    assert len(crowd.radius)
    assert (distance_field(stage.world.grid).at(crowd.position) > crowd.radius).all()
    assert np.hypot(*(crowd.position - stage.start[:2]).T).min() > 1.2


def test_frontal_is_head_on():
    stage = staged("frontal")
    assert abs(bearing(stage, 0)) < 0.05
    step = np.diff(way(stage, 0), axis=0)[0]
    assert math.atan2(step[1], step[0]) == pytest.approx(math.pi, abs=0.05)


def test_overtaking_asks_for_it_and_being_overtaken_happens():
    slow, fast = staged("overtaking"), staged("overtaken")
    assert abs(bearing(slow, 0)) < 0.1  # ahead, on the same way
    assert slow.world.crowd.preferred_speed[0] < 0.5 * slow.request.profile.preferred_speed
    # who only follows arrives later than who passes by more than ten seconds
    assert way(slow, 0)[-1, 0] > slow.request.goal[0]
    assert abs(bearing(fast, 0)) > math.pi - 0.1  # behind
    assert fast.world.crowd.preferred_speed[0] > 1.5 * fast.request.profile.preferred_speed
    assert fast.world.crowd.sees_robot[0]


@pytest.mark.parametrize("name", ["intersection", "narrow-doorway", "narrow-hallway"])
def test_both_would_be_in_the_same_place_at_the_same_time(name):
    stage = staged(name)
    speed = stage.request.profile.preferred_speed
    route, line = stage.route.points, way(stage, 0)
    pace = stage.world.crowd.preferred_speed[0]
    times = np.arange(0.0, 30.0, 0.05)
    at = [
        np.column_stack([np.interp(v * times, arc_length(p), p[:, k]) for k in (0, 1)])
        for p, v in ((route, speed), (line, pace))
    ]
    assert np.hypot(*(at[0] - at[1]).T).min() < 0.6  # chair's half width and a body


def test_a_blind_corner_hides_both_until_they_are_near_it():
    stage = staged("blind-corner")
    assert not in_sight(stage, 0)
    assert not in_sight(staged("intersection"), 0)
    assert in_sight(staged("frontal"), 0)


@pytest.mark.parametrize(
    ("name", "at", "width"),
    [("narrow-hallway", (8.5, 3.1), 1.8), ("narrow-doorway", (6.5, 3.5), 1.0)],
)
def test_what_is_called_narrow_is(name, at, width):
    assert width_at(staged(name), np.array(at), 0.0) == pytest.approx(width, abs=0.06)


@pytest.mark.parametrize(("name", "inside"), [("entering-room", "goal"), ("leaving-room", "start")])
def test_rooms_are_entered_and_left_by_their_door(name, inside):
    stage = staged(name)
    room = stage.places.find("Room")
    ends = {"start": stage.start[:2], "goal": stage.request.goal}
    outside = ends["goal" if inside == "start" else "start"]
    low, high = room.polygon.min(axis=0), room.polygon.max(axis=0)
    assert ((ends[inside] > low) & (ends[inside] < high)).all()
    assert not ((outside > low) & (outside < high)).all()
    door = np.array([8.0, 2.6])
    assert nearest_on_polyline(stage.route.points, *door)[1] < 0.6
    assert nearest_on_polyline(way(stage, 0), *door)[1] < 0.6  # and somebody comes the other way


def test_the_place_in_the_group_is_the_free_one_of_four():
    joining, leaving = staged("joining-group"), staged("leaving-group")
    for stage, place in ((joining, joining.request.goal), (leaving, leaving.start[:2])):
        corners = np.vstack([stage.world.crowd.waypoints[:, 0], place])
        centre = np.array([9.0, 7.0])
        assert np.allclose(np.hypot(*(corners - centre).T), [0.88, 0.88, 0.88, 1.15], atol=0.01)
        angles = np.sort(np.arctan2(*(corners - centre).T[::-1]))
        assert np.allclose(np.diff(angles), math.pi / 2.0, atol=0.01)
    assert math.degrees(leaving.start[2]) == pytest.approx(135.0)  # facing the middle


def test_flows_go_along_across_and_round():
    def directions(name):
        stage = staged(name)
        crowd = stage.world.crowd
        ahead = crowd.waypoints[:, 1] - crowd.waypoints[:, 0]
        return np.degrees(np.arctan2(ahead[:, 1], ahead[:, 0])), stage

    along, _ = directions("parallel-flow")
    assert sorted({round(abs(a)) for a in along}) == [0, 180]
    across, _ = directions("perpendicular-flow")
    assert np.allclose(across, -90.0)
    round_, stage = directions("circular-flow")
    from_centre = stage.world.crowd.position - np.array([12.0, 12.0])
    radial = np.degrees(np.arctan2(from_centre[:, 1], from_centre[:, 0]))
    assert np.allclose(np.remainder(round_ - radial - 90.0 + 180.0, 360.0) - 180.0, 0.0, atol=31.0)
    assert stage.world.crowd.loop.all()


def test_a_companion_walks_beside_the_chair_to_a_place_beside_its_goal():
    stage = staged("accompanying")
    who = stage.scenario.companion
    line = way(stage, who)
    assert np.allclose(line[-1] - stage.request.goal, line[0] - stage.start[:2], atol=0.06)
    assert abs(stage.world.crowd.preferred_speed[who] - 0.75) <= 0.05


def test_somebody_stays_in_the_dead_sector_until_it_is_too_late():
    stage = staged("blind-spot")
    laser = stage.robot.lasers[0]
    crowd, speed = stage.world.crowd, stage.request.profile.preferred_speed
    dead = math.radians(360.0 - laser.field_of_view_deg) / 2.0
    middle = laser.pose[2] + math.pi
    for t in np.arange(0.0, 7.0, 0.25):
        ridden = max(speed * (t - 0.5), 0.5 * 0.8 * min(t, 1.0) ** 2)
        person = crowd.position[0] + t * crowd.preferred_speed[0] * np.array([0.0, -1.0])
        away = person - stage.start[:2] - np.array([ridden, 0.0])
        off = math.remainder(math.atan2(away[1], away[0]) - middle, 2.0 * math.pi)
        assert abs(off) < dead, t
    assert not crowd.sees_robot[0]


@pytest.mark.parametrize("name", OFFICES)
def test_the_office_files_are_what_the_bench_draws(name):
    stage = staged(name)
    scene = office(int(name[-1]), stage.robot)
    assert np.array_equal(stage.grid.data, scene.grid.data)
    assert np.allclose(stage.start, [*scene.start, math.pi / 2.0], atol=1e-3)
    assert np.allclose(stage.request.goal, scene.goal, atol=1e-3)
    assert np.allclose(stage.prefer[0], scene.click, atol=1e-3)
    assert stage.scenario.collection is Collection.GLOBAL


def test_a_flow_keeps_to_its_lane_and_its_people_apart():
    flow = FlowSpec(lane=((0, 0), (10, 0), (10, 10)), width=2.0, spread=8.0, count=8)
    chair = np.array([5.0, 1.5])  # beside the lane's middle: on it nobody has room for as much
    ways = flow_routes([flow], 8, chair, generator(3, "crowd"))
    starts = np.array([way.points[0] for way in ways])
    assert len(ways) == 8
    assert (np.abs(starts[:, 1]) <= 1.0 + 1e-9).all()
    assert (starts[:, 0] <= 8.8 + 1e-9).all()  # the outer border of the first leg is 11 m for 10
    apart = np.hypot(*(starts[:, None] - starts).transpose(2, 0, 1)) + 99 * np.eye(8)
    assert apart.min() >= MIN_SPACING
    assert np.hypot(*(starts - chair).T).min() >= ROBOT_CLEARANCE
    for start, each in zip(starts, ways, strict=True):
        corner, end = np.array(each.points[-2:])  # offset along both legs by the same amount
        assert np.allclose(corner, [10.0 - start[1], start[1]])
        assert np.allclose(end, [10.0 - start[1], 10.0])


def test_flows_share_the_people_there_are():
    lanes = [FlowSpec(lane=((0, y), (9, y)), count=n) for y, n in ((0, 6), (20, 3))]
    counts = [
        sum(way.points[0][1] < 10 for way in flow_routes(lanes, n, FAR, generator(0, "crowd")))
        for n in (0, 3, 9, 18)
    ]
    assert counts == [0, 2, 6, 12]
    assert len(staged("perpendicular-flow", "people.count=4").world.crowd.radius) == 4
    assert len(staged("perpendicular-flow", "people.count=14").world.crowd.radius) == 14
    assert not len(staged("perpendicular-flow", "people.count=0").world.crowd.radius)


@pytest.mark.parametrize("width", [1.5, 1.9, 2.4])
def test_a_floors_widths_are_set_by_the_scenario(width):
    # 1.9 m between the middles of walls of 0.1 m is 1.8 m between their faces
    hall = staged("narrow-hallway", f"floor_plan.corridors.Hallway.width={width}")
    assert width_at(hall, np.array([8.5, 3.1]), 0.0) == pytest.approx(width - 0.1, abs=0.06)
    door = staged("narrow-doorway", f"floor_plan.doors.0.width={width}")
    assert width_at(door, np.array([6.5, 3.5]), 0.0) == pytest.approx(width, abs=0.06)


@pytest.mark.parametrize(
    ("setting", "key", "says"),
    [
        ("widht=2", "widht", "did you mean 'width'"),
        ("width=-1", "width", "greater than 0"),
        ("line.7=[1, 2]", "line.7", "has 2 entries"),
    ],
)
def test_a_floor_is_not_changed_to_what_it_cannot_be(setting, key, says):
    setting, key = (f"floor_plan.corridors.Hallway.{each}" for each in (setting, key))
    with pytest.raises(ConfigError) as caught:
        floor_plan(load_scenario("narrow-hallway", [setting]))
    assert caught.value.key == key
    assert says in str(caught.value)


def test_a_map_has_no_plan_to_change():
    with pytest.raises(ScenarioError, match="needs floor"):
        floor_plan(load_scenario("office-0", ["floor_plan.wall=0.2"]))


def test_variants_are_every_combination():
    found = varied(["people.count=1,3", "people.speed=[0.4, 0.5],[1.0, 1.2]"])
    assert len(found) == 4
    assert found[1].columns == (("people.count", "1"), ("people.speed", "[1.0, 1.2]"))
    assert found[1].settings == ("people.count=1", "people.speed=[1.0, 1.2]")
    assert varied([])[0].settings == ()


def test_a_long_value_is_varied_as_it_is():
    ways = [{"points": [[1.125 + k, 2.0] for k in range(20)]}]
    (found,) = varied([f"people.pedestrians={json.dumps(ways)}"])
    assert override({}, found.settings) == {"people": {"pedestrians": ways}}


@pytest.mark.parametrize("text", ["people.count", "=1,2", "a=", "a=[1", "a=1,1"])
def test_what_varies_nothing_is_refused(text):
    with pytest.raises(ConfigError):
        varied([text])
    with pytest.raises(ConfigError, match="twice"):
        varied(["a=1,2", "a=3"])


def test_the_bench_rides_whole_comparisons():
    asked = bench.create("ss_mpc_dcbf,dwa", "frontal,crowding", vary=["people.count=1,2"])
    tasks = asked.tasks(range(3))
    assert len(tasks) == 3 * 2
    columns = [dict(ride.columns) for ride in tasks[0]]
    assert [(each["planner"], each["people.count"]) for each in columns] == [
        ("ss_mpc_dcbf", "1"), ("ss_mpc_dcbf", "2"), ("dwa", "1"), ("dwa", "2"),
    ]  # fmt: skip
    assert {each["card"] for each in columns} == {"frontal"}
    assert {ride.seed for ride in tasks[0]} == {0}


@pytest.mark.parametrize("name", scenario_names())
def test_every_scenario_is_told_and_shown_in_its_page(name):
    assert f"`{name}`" in PAGE.read_text(encoding="utf-8")
    picture = PAGE.parent / "images" / "scenarios" / f"{name}.png"
    assert 2_000 < picture.stat().st_size < 100_000


@pytest.mark.parametrize("name", ["door", "office-0", "circular-flow"])
def test_a_picture_is_small(name, tmp_path):
    file = tmp_path / f"{name}.png"
    draw_scenario(staged(name), file)
    assert 2_000 < file.stat().st_size < 100_000


def test_a_scenario_of_ones_own_is_listed_as_such(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump({"floor": "hall", "start": [2, 7], "goal": [12, 7]}))
    assert load_scenario(file).collection is Collection.OWN
    assert all(each.heading for each in Collection)


def test_beside_is_level_with_and_near(made_ride):
    # four ticks: level and near; 0.9 m ahead; 1.1 m ahead; level and 1.6 m away
    pose = [[0, 0, 0.5 * math.pi]] * 4
    people = [[[-1.5, y, 0, 0]] for y in (0.0, 0.9, 1.1, 0.0)]
    gap = [[0.75], [0.75], [0.75], [1.6]]
    alone = made_ride(pose, people=people, gap_people=gap)
    assert math.isnan(side_by_side_share(alone))
    scenario = alone.scenario.model_copy(update={"companion": 0})
    together = made_ride(pose, people=people, gap_people=gap, scenario=scenario)
    assert side_by_side_share(together) == pytest.approx(0.5)
    nobody = made_ride(pose, scenario=scenario)
    assert math.isnan(side_by_side_share(nobody))


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        name
        for name in scenario_names()
        # riders with knowledge of their own; circuits that are ridden from stop to stop
        if load_scenario(name).collection not in {Collection.SHARING, Collection.CIRCUITS}
    ],
)
def test_every_scenario_is_drawn_and_ridden_without_touching_anybody(name, tmp_path):
    draw_scenario(staged(name), tmp_path / f"{name}.png")
    ride = run(load_scenario(name), 0)
    assert ride.outcome is Outcome.REACHED
    assert not ride.hit_moving.any()
    assert not ride.hit_wall.any()


@pytest.mark.slow
def test_in_the_blind_spot_the_rider_makes_the_difference():
    together = run(load_scenario("blind-spot"), 0)
    alone = run(load_scenario("blind-spot", ["mode=autonomous", "rider.use=none"]), 0)
    assert together.outcome is Outcome.REACHED
    assert together.gap_people.min() > 0.3
    assert alone.outcome is Outcome.COLLISION or alone.gap_people.min() < 0.1
