"""The benchmark of perception: its rows, what it says of what it could not run, its scenes."""

import math

import numpy as np
import pytest

from cohelm.benchmarks.bench import Result
from cohelm.benchmarks.claims import MET, MISSED, NOT_RUN, Bound, measured, skipped
from cohelm.benchmarks.perception import bench as perception
from cohelm.benchmarks.perception import cost as perception_cost
from cohelm.benchmarks.perception import empty_floors as perception_rooms
from cohelm.benchmarks.perception import filmed_crowds as perception_crowds
from cohelm.benchmarks.perception import held_out as perception_held_out
from cohelm.benchmarks.perception import invalid_readings as perception_odd
from cohelm.benchmarks.perception import recordings as perception_recordings
from cohelm.errors import ConfigError
from cohelm.maps import read_floor_plan
from cohelm.robots import LidarMount, load_robot
from cohelm.scenarios.scenario import floor_file
from cohelm.simulation.sensors import HumanBodies

OUTSIDE = {
    "held_out": lambda _: perception_held_out.held_out(),
    "demo": perception_recordings.demo,
    "kitti": perception_recordings.kitti,
    "crowd": lambda _: perception_crowds.crowd("ETH", False, 0, 1),
    "groups": lambda _: perception_crowds.groups(),
    "prediction": lambda _: perception_crowds.prediction(),
}


@pytest.mark.parametrize(
    ("figure", "bounds", "met"),
    [
        (0.95, {"bound": Bound(low=0.95)}, MET),
        (0.94, {"bound": Bound(low=0.95)}, MISSED),
        (0.0, {"bound": Bound(high=0.0)}, MET),
        (0.5, {"bound": Bound(high=0.0)}, MISSED),
        (math.nan, {"bound": Bound(low=0.95)}, MISSED),
        (math.nan, {"bound": Bound(high=0.95)}, MISSED),
        (1.0, {"bound": Bound(high=2.0), "valid": False}, MISSED),
        (7.0, {}, ""),
    ],
)
def test_a_row_says_whether_what_is_wanted_is_met(figure, bounds, met):
    assert measured("part", "what", figure, **bounds)["verdict"] == met


@pytest.mark.parametrize("part", OUTSIDE)
def test_what_is_not_there_is_said_and_not_passed_over(part, monkeypatch, tmp_path):
    monkeypatch.delenv("COHELM_DATA", raising=False)
    rows = list(OUTSIDE[part](tmp_path))
    assert rows
    assert {each["verdict"] for each in rows} == {NOT_RUN}
    assert all("COHELM_DATA is not set" in each["remark"] for each in rows)
    monkeypatch.setenv("COHELM_DATA", str(tmp_path))
    assert all("is not in COHELM_DATA" in each["remark"] for each in OUTSIDE[part](tmp_path))


def test_each_seed_is_a_window_and_windows_lie_side_by_side():
    crowds = [task for task in perception.create().tasks(range(3, 7)) if task[0] == "crowd"]
    assert len(crowds) == 4
    assert all(task[-2:] == (3, 4) for task in crowds)
    assert len(set(perception.create().tasks(range(1)))) == len(perception.create().tasks(range(1)))


def test_parts_of_the_table_run_alone():
    tasks = perception.create(parts=["held_out", "crowd"]).tasks(range(1))
    assert {task[0] for task in tasks} == {"held_out", "crowd"}
    assert len(tasks) == 1 + len(perception_crowds.CROWDS)
    with pytest.raises(ConfigError, match=r"--part: no part is called 'heldout'.*held_out"):
        perception.create(parts=["heldout"])


def test_the_report_counts_and_names_what_is_missed(tmp_path):
    rows = [
        measured("a", "one", 1.0, bound=Bound(low=0.5)),
        measured("a", "two", 1.0, bound=Bound(high=0.5), unit="m"),
        skipped("b", "three", "no data"),
        measured("b", "four", 2.0),
    ]
    (tmp_path / "who.png").write_bytes(b"")
    report = perception.create().report([Result(each) for each in rows], tmp_path)
    assert report.notes[0] == f"1 {MET}, 1 {MISSED}, 1 {NOT_RUN}"
    assert [sheet.title for sheet in report.sheets] == ["a", "b"]
    assert report.sheets[0].rows[1] == ("two", "1 m", "≤ 0.5", MISSED, "")
    assert report.sheets[1].rows[0] == ("three", "", "", NOT_RUN, "no data")
    assert any("two" in note for note in report.notes)
    assert any("no data" in note for note in report.notes)
    assert report.files == (tmp_path / "who.png",)


def test_every_task_has_its_rows(monkeypatch, tmp_path):
    monkeypatch.delenv("COHELM_DATA", raising=False)
    for task in [("held_out",), ("crowd", "zara01", True, 0, 1), ("groups",)]:
        results = perception.create().work(task, tmp_path)
        assert [result.row["verdict"] for result in results].count(NOT_RUN) == len(results) > 0


def test_readings_that_make_no_sense(monkeypatch):
    monkeypatch.setattr(perception_odd, "MANY", 3000)
    rows = list(perception_odd.rows())
    assert len(rows) == 14
    assert [each for each in rows if each["verdict"] != MET] == []
    assert all("sensing " in each["remark"] for each in rows)


@pytest.mark.parametrize("sensor", perception_rooms.ROBOTS)
def test_a_drive_sees_the_hall_from_where_the_chair_is(sensor):
    grid = read_floor_plan(floor_file("hall")).draw()[0]
    robot = load_robot(perception_rooms.ROBOTS[sensor])
    line = perception_rooms.LINES["hall"]
    frames = list(perception_rooms.drive(grid, robot, line, seconds=0.5))
    assert len(frames) == 5
    for k, frame in enumerate(frames):
        seen = frame.observation
        assert np.hypot(*(seen.pose - line.at(k / 10)[0])[:2]) < 0.05  # the localiser's error
        assert len(seen.scans) == len(robot.lasers)
        assert len(seen.clouds) == len(robot.cloud_mounts)


def test_somebody_who_stands_in_the_hall_is_met():
    grid = read_floor_plan(floor_file("hall")).draw()[0]
    robot, line = load_robot("quantum_q6_edge"), perception_rooms.LINES["hall"]
    place = line.at(0.0)[0][:2] + 1.5 * np.array([np.cos(line.axis), np.sin(line.axis)])
    bodies = HumanBodies.standing(place[None])
    with_one, without = (
        next(perception_rooms.drive(grid, robot, line, bodies=each, seconds=0.1)).observation
        for each in (bodies, None)
    )
    assert np.nanmin(with_one.scans[0].ranges) < np.nanmin(without.scans[0].ranges)


def test_fifty_tracks_are_fifty_people():
    (found,) = perception_cost.tracking(frames=5)
    assert "50 people tracked" in found["remark"]
    assert found["unit"] == "ms"


def test_crowds_for_timing_have_as_many_as_asked(tmp_path):
    mount = LidarMount(azimuths=64, rings=8)
    observations = perception_cost.crowded(3, mount, 2)
    assert len(observations) == perception_cost.WARM + 2
    assert all(len(each.clouds[0].points) == 8 * 64 for each in observations)
    assert np.all(np.diff([each.time for each in observations]) > 0.0)


@pytest.mark.data
def test_the_pedestrian_of_kitti_is_found(data, monkeypatch, tmp_path):
    monkeypatch.setenv("COHELM_DATA", str(data))
    found, others = perception_recordings.kitti(tmp_path)
    assert found["verdict"] == MET
    assert others["required"] == ""
    assert (tmp_path / "kitti_obj_000000.png").stat().st_size > 10_000
