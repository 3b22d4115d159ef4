"""Rides of the bench of calm, draws on floors, and the report."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from tests.evaluation.sweep_rows import result

from cohelm.benchmarks.rides import calm, calm_report
from cohelm.benchmarks.rides.false_alarms import AlarmWatch
from cohelm.benchmarks.rides.floor_draws import (
    APART,
    CLEARANCE,
    PEOPLE,
    draw_ride,
    floor_settings,
    known_floor,
)
from cohelm.cli.requests import RunRequest
from cohelm.cli.scenario_request import scenario_of
from cohelm.errors import ConfigError
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.sweeps import RideTask
from cohelm.maps import FREE, OCCUPIED, UNKNOWN, OccupancyGrid, distance_field, write_map
from cohelm.messages import Reason
from cohelm.scenarios.build import build_scenario


def room(width, height, resolution=0.1):
    """A room with a wall around it; 2 m beyond its right wall are unknown."""
    data = np.full((round(height / resolution), round((width + 2.0) / resolution)), FREE)
    data[:, round(width / resolution) :] = UNKNOWN
    data[[0, -1], :] = data[:, [0, round(width / resolution)]] = OCCUPIED
    return OccupancyGrid(data=data.astype(np.int8), resolution=resolution, X_MG=np.zeros(3))


@pytest.fixture
def floors(tmp_path, monkeypatch):
    """COHELM_DATA with a hall, which has rides, and a cupboard, which has none."""
    folder = tmp_path / "ros_maps"
    folder.mkdir()
    write_map(room(20.0, 12.0), folder / "hall.yaml")
    write_map(room(6.0, 6.0), folder / "cupboard.yaml")
    monkeypatch.setenv("COHELM_DATA", str(tmp_path))
    return folder


def rides_of(**options):
    seeds = options.pop("seeds", range(100, 140))
    return [ride for (ride,) in calm.create(**options).tasks(seeds)]


def test_the_hospital_is_ridden_in_both_modes_and_blind_people_in_one():
    rides = rides_of(part=("hospital", "blind"))
    seen = {(dict(ride.columns)["part"], dict(ride.columns)["mode"]) for ride in rides}
    assert seen == {("hospital", "autonomous"), ("hospital", "shared"), ("blind", "autonomous")}
    assert [ride.seed for ride in rides[:4]] == [100, 100, 101, 101]
    assert len(rides) == 2 * 40 + 20
    shared, blind = rides[1].load(), rides[-1].load()
    assert (shared.mode, shared.rider["use"], shared.people.see_robot) == ("shared", "noisy", True)
    assert (blind.rider["use"], blind.people.see_robot) == ("none", False)


def test_a_share_takes_the_first_rides_of_every_part():
    whole, share = rides_of(part=("blind",)), rides_of(part=("blind",), share=0.15)
    assert share == whole[:3]
    assert len(rides_of(part=("blind",), share=0.001)) == 1
    assert len(rides_of(part=("hospital",), seeds=range(2), modes="assisted")) == 2


def test_a_floor_is_ridden_as_often_as_there_are_seeds_and_a_small_one_never(floors):
    rides = rides_of(part=("floors",), seeds=range(3), settings=("people.radius=0.2",))
    assert [(dict(ride.columns)["scene"], ride.seed) for ride in rides] == [
        ("hall", 0), ("hall", 1), ("hall", 2),
    ]  # fmt: skip
    assert rides == rides_of(part=("floors",), seeds=range(3), settings=("people.radius=0.2",))
    one, other = rides[0].load(), rides[1].load()
    assert (one.start, one.goal) != (other.start, other.goal)
    assert str(floors / "hall.yaml") in rides[0].replay
    setup = build_scenario(one, 0)
    assert PEOPLE[0] <= len(setup.world.crowd.radius) <= PEOPLE[1]
    assert not len(setup.prefer)
    assert one.people.radius == 0.2


def test_a_draw_keeps_clear_of_walls_and_in_proportion_to_its_length(floors):
    file = floors / "hall.yaml"
    grid = known_floor(file)
    field = distance_field(grid)
    for seed in range(5):
        draw = draw_ride(file, grid, seed)
        length = math.dist(draw.start, draw.goal)
        assert length >= APART - 0.02
        ends = np.array([draw.start, draw.goal])
        assert (field.at(ends) >= CLEARANCE - 0.1).all()
        # the room is empty: the path on a grid of eight directions is 8 % longer at most
        assert max(60.0, 5.0 * length) <= draw.time_limit <= max(61.0, 5.0 * 1.09 * length + 1.0)


def test_the_command_line_rides_the_same(floors):
    file = floors / "hall.yaml"
    draw = draw_ride(file, known_floor(file), 3)
    settings = ("mode=autonomous", *floor_settings(file, draw))
    ours = RideTask((), "hospital", settings, 3).load()
    request = RunRequest(
        map=str(file),
        start=f"{draw.start[0]},{draw.start[1]}",
        goal=f"{draw.goal[0]},{draw.goal[1]}",
        people=draw.people,
        mode="autonomous",
        settings=[f"time_limit={draw.time_limit:g}"],
    )
    assert scenario_of(request).model_dump() == ours.model_dump()


def test_a_map_that_reads_unknown_cells_as_free_is_not_ridden_there(floors):
    text = (floors / "hall.yaml").read_text()
    (floors / "hall.yaml").write_text(text.replace("free_thresh: 0.196", "free_thresh: 0.25"))
    assert (known_floor(floors / "hall.yaml").data == room(20.0, 12.0).data).all()


def test_the_narrow_rides_are_the_same_for_all_seeds(floors):
    with pytest.raises(ConfigError, match="utexas_gdc_3ne"):
        rides_of(part=("narrow",))
    write_map(room(20.0, 12.0), floors / "utexas_gdc_3ne.yaml")
    rides = rides_of(part=("narrow",))
    assert rides == rides_of(part=("narrow",), seeds=range(7))
    assert [(ride.seed, ride.load().people.count) for ride in rides] == [(0, 12), (1, 12), (0, 10)]
    assert rides[2].load().goal == (-36.78, -7.82)


def test_without_maps_only_the_hospital_is_ridden_by_default(monkeypatch, tmp_path):
    monkeypatch.setenv("COHELM_DATA", str(tmp_path))
    parts = {dict(task[0].columns)["part"] for task in calm.create().tasks(range(1))}
    assert parts == {"hospital", "blind"}
    for part in ("floors", "narrow"):
        with pytest.raises(ConfigError, match="ros_maps"):
            calm.create(part=(part,))


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"part": ("hospitol",)}, "hospital"),
        ({"modes": "alone"}, "alone"),
        ({"settings": ("mode=manual",)}, "--modes"),
        ({"settings": ("nonsense=1",)}, "nonsense"),
    ],
)
def test_what_does_not_exist_is_refused(options, match):
    with pytest.raises(ConfigError, match=match):
        calm.create(**options)


def test_a_ride_that_fails_is_listed_with_its_command(tmp_path):
    bench = calm.create(part=("hospital",), modes="autonomous",
                        settings=("people.count=0", "time_limit=1.5"))  # fmt: skip
    (task,) = bench.tasks(range(3, 4))
    (ridden,) = bench.work(task, tmp_path)
    assert ridden.row["outcome"] == "timeout"
    assert ridden.row["stop_rate"] == 0.0
    assert ridden.row["jerk_felt_p99"] > 0.0
    report = bench.report([ridden], tmp_path)
    (line,) = [note for note in report.notes if "timeout" in note]
    assert "cohelm run hospital --seed 3 --set mode=autonomous" in line
    assert report.summary["groups"]["hospital, autonomous"]["timeouts"] == 1.0
    assert (tmp_path / "summary.csv").is_file()


@pytest.mark.parametrize("faulty", [False, True])
def test_alarms_are_counted_where_no_fault_was_set(tmp_path, monkeypatch, faulty):
    """A finding that lasts is one alarm; with a fault it is none, because it may be true."""
    finds = iter([*[False] * 10, *[True] * 5, *[False] * 5, *[True] * 3])

    def see(watch, tick, truth):
        health = SimpleNamespace(findings=[SimpleNamespace(reason=Reason.LOST)][: next(finds, 0)])
        return original(watch, SimpleNamespace(health=health, decision=tick.decision), truth)

    original = AlarmWatch.see
    monkeypatch.setattr(AlarmWatch, "see", see)
    faults = ("faults=[{kind: scan_frozen, at: 1, duration: 1}]",) if faulty else ()
    bench = calm.create(part=("hospital",), modes="autonomous",
                        settings=("people.count=0", "time_limit=1.5", *faults))  # fmt: skip
    (task,) = bench.tasks(range(3, 4))
    results = bench.work(task, tmp_path)
    notes = bench.report(results, tmp_path).notes
    alarms = [note for note in notes if "false alarm" in note]
    if faulty:
        assert not alarms
        return
    found = results[0].row["alarm_reasons"]
    assert [each.split(" at ")[0] for each in found.split(", ")] == ["lost", "lost"]
    assert alarms[0].startswith(f"false alarm: {found}: cohelm run hospital --seed 3")
    assert alarms[1].startswith("false alarms: 2 in 0.00 h")


def row(seed, part="hospital", **changes):
    return result(
        seed=seed, part=part, mode="autonomous", scene="hospital", stop_rate=1.0, short_stops=0.0,
        braking_time=1.0, gentle_braking=1.0, hard_braking=0.0, jerk_felt_rms=1.0,
        jerk_felt_p99=4.0, collision_speed_wall=math.nan, **changes,
    ).row  # fmt: skip


def figures(rows):
    rides = Rides(rows, calm_report.BY)
    columns = {**calm_report.ARRIVALS, **calm_report.CALMNESS}
    return {name: each.value(rides) for name, each in columns.items()}


def test_collisions_are_counted_by_who_moved():
    end = {"outcome": "collision", "time": math.nan}
    rows = [
        row(0),
        row(1, **end, collisions_person=1.0, collision_speed=0.4),
        row(2, **end, collisions_wall=1.0),
        row(3, standing_contacts=2.0),
        row(4, outcome="timeout"),
        row(5, outcome="stopped"),
        row(6, outcome="error"),
    ]
    found = figures(rows)
    assert [found[name] for name in calm_report.ARRIVALS if name != "time_median"] == [
        7, 2, 1, 1, 1, 1, 1, 1,
    ]  # fmt: skip
    failed = calm_report.failures(Rides(rows, calm_report.BY))
    assert [line.split(": ")[1] for line in failed] == [
        "collision with a person at 0.40 m/s", "collision with a wall at nan m/s", "timeout",
        "stopped", "error",
    ]  # fmt: skip


def test_the_share_of_gentle_braking_is_that_of_all_rides_together():
    # 0.9 of 10 s and all of 2 s: 11 of 12 s; a ride that does not brake does not count
    still = {"braking_time": 0.0, "gentle_braking": math.nan}
    rows = [
        {**row(0), "braking_time": 10.0, "gentle_braking": 0.9, "jerk_felt_p99": 9.0},
        {**row(1), "braking_time": 2.0},
        {**row(2), **still, "short_stops": 3.0},
    ]
    found = figures(rows)
    assert found["gentle_share"] == pytest.approx(100.0 * 11.0 / 12.0)
    assert found["gentle_share_min"] == pytest.approx(90.0)
    assert (found["jerk_felt_p99_median"], found["jerk_felt_p99_max"]) == (4.0, 9.0)
    assert found["short_stops"] == 3.0
    assert math.isnan(figures([{**row(0), **still}])["gentle_share"])
