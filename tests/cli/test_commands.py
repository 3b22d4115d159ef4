import json
import math
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from cohelm.cli import parsing, progress
from cohelm.cli.listings import count_people
from cohelm.cli.report import as_json
from cohelm.cli.requests import RunRequest
from cohelm.cli.run import _headline
from cohelm.cli.scenario_request import scenario_of
from cohelm.config import read_yaml
from cohelm.errors import ConfigError
from cohelm.evaluation import Outcome
from cohelm.evaluation.metrics.measures import RIDE_MEASURES
from cohelm.scenarios import load_scenario
from cohelm.scenarios.crowd import pedestrian_count
from cohelm.scenarios.scenario import scenario_names

SHORT = ("run", "empty", "--set", "time_limit=1.5")


def test_the_version_is_said_without_importing_what_takes_time():
    out = subprocess.run(
        [
            sys.executable,
            "-X",
            "importtime",
            "-c",
            "from cohelm.cli import main; main()",
            "--version",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    assert out.stdout.startswith("cohelm 0.")
    imported = {line.rpartition("|")[2].strip() for line in out.stderr.splitlines()}
    assert not imported & {"numpy", "numba", "matplotlib", "scipy", "cv2", "pydantic"}


def test_help_names_the_commands(cohelm):
    code, out, _ = cohelm("--help")
    assert code == 0
    for command in ("run", "plan", "scenarios", "plugins", "data"):
        assert command in out


def test_json_is_exactly_one_object_with_every_metric(cohelm):
    code, out, err = cohelm(*SHORT, "--json", "--quiet")
    assert code == 1  # the time is too short to arrive
    assert out.count("\n") == 1
    assert err == ""
    report = json.loads(out)
    assert report["outcome"] == "timeout"
    assert report["seed"] == 0
    assert report["min_distance"] is None  # nobody there
    assert set(RIDE_MEASURES) <= set(report)
    assert {"cohelm", "numpy", "python"} <= set(report["versions"])
    assert {"tick", "wall_time"} <= set(report["timing"])
    assert list(report) == sorted(report)


def test_twice_the_same_but_for_timing(cohelm):
    ride = ("run", "crossing", "--set", "time_limit=1.5", "--seed", "3", "--json")
    first, second = (json.loads(cohelm(*ride)[1]) for _ in range(2))
    assert first.pop("timing") != {}
    assert second.pop("timing") != {}
    assert as_json(first) == as_json(second)


def test_a_table_ends_with_the_outcome(cohelm):
    code, out, _ = cohelm(*SHORT)
    assert code == 1
    assert "path_length" not in out
    assert out.splitlines()[-1] == "outcome: timeout"
    # title, five figures, outcome
    assert len(out.splitlines()) == 7
    assert "path_length" in cohelm(*SHORT, "--all")[1]
    assert cohelm(*SHORT, "-q")[1] == "outcome: timeout\n"


def test_a_collision_says_when_where_and_with_what(cohelm):
    blind = ("--planner", "path_follower", "--set", "gate.separation=false")
    code, out, _ = cohelm("run", "aggressive", *blind)
    assert code == 1
    assert out.splitlines()[-1] == "outcome: collision"
    found = re.search(
        r"at (\S+) s: the chair touched a person at (\S+) m/s, at \((\S+), (\S+)\)", out
    )
    report = json.loads(cohelm("run", "aggressive", *blind, "--json")[1])
    assert float(found[1]) == pytest.approx(report["simulated_time"], abs=0.06)
    assert float(found[2]) > 0.0
    assert 2.0 < float(found[3]) < 12.0


def test_who_touches_a_standing_chair_is_reported(cohelm):
    code, out, _ = cohelm("run", "aggressive", "--seed", "1", "--planner", "mpc")
    assert code == 0
    assert out.count("a person touched the chair while it stood") >= 1


def test_options_change_the_scenario(cohelm):
    options = ("--mode", "autonomous", "--rider", "idle", "--method", "astar", "--people", "2")
    report = json.loads(cohelm(*SHORT, *options, "--planner", "path_follower", "--json")[1])
    assert report["mode"] == "autonomous"
    assert report["rider"] == "idle"
    assert report["method"] == "astar"
    assert report["planner"] == "path_follower"
    assert report["people"] == 2


def test_a_map_of_ones_own(cohelm, room):
    ride = ("run", "empty", "--map", room, "--start=-4,0,0", "--goal=3.5,1", "--prefer=-1,2")
    code, out, _ = cohelm(*ride, "--people", "1", "--set", "time_limit=1.5", "--json")
    assert code == 1
    report = json.loads(out)
    assert report["people"] == 1
    assert report["outcome"] == "timeout"


def test_nothing_that_lies_somewhere_is_brought_to_another_map(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(
        "{floor: hall, start: [2, 7], goal: East, rider_goal: East, rider_route: [[5, 7]],"
        " companion: 0, people: {groups: [{points: [[7, 4]], size: 3}], flows: [{lane: [[2, 2],"
        " [9, 2]], count: 4}]}}"
    )
    request = RunRequest(scenario=str(file), map="room.yaml", start="-4,0", goal="3,1")
    scenario = scenario_of(request)
    assert (scenario.people.groups, scenario.people.flows, scenario.people.count) == ((), (), 7)
    assert (scenario.rider_goal, scenario.rider_route, scenario.companion) == (None, (), None)


def test_out_writes_a_folder_of_files(cohelm, tmp_path):
    folder = tmp_path / "ride"
    code, _, _ = cohelm(*SHORT, "--out", folder, "-q")
    assert code == 1
    assert json.loads((folder / "ride.json").read_text())["outcome"] == "timeout"
    header, first, *rest = (folder / "track.csv").read_text().splitlines()
    assert header.startswith("time,x,y,heading")
    assert first.startswith("0,2,7,0")
    assert len(rest) == 30  # 1.5 s at 20 Hz
    assert (folder / "ride.png").stat().st_size > 10_000
    steps = json.loads((folder / "socnav3.json").read_text())["sequence"]
    assert [each["timestamp"] for each in steps[:3]] == pytest.approx([0.0, 0.1, 0.2])
    track = [float(each) for each in rest[-1].split(",")[1:4]]
    robot, half = steps[-1]["robot"], steps[-1]["robot"]["shape"]["length"] / 2.0
    ahead = math.hypot(robot["x"] - track[0], robot["y"] - track[1])
    assert robot["angle"] == pytest.approx(track[2], abs=1e-5)
    assert 0.0 < ahead < half  # the middle of the chair lies before its drive axle


def test_plan_says_what_a_wish_costs(cohelm, room, tmp_path):
    plot = tmp_path / "route.png"
    ends = ("plan", room, "--start=-4,-1", "--goal", "4,-1")
    code, out, err = cohelm(*ends, "--prefer=0,1.5", "--json", "--plot", plot)
    assert (code, err) == (0, "")
    report = json.loads(out)
    assert report["extra_length"] > 0.1
    assert report["closest_to_preference"] < 2.0  # 2.5 m straight on; a flat valley stays away
    assert report["points"][0] == [-4.0, -1.0]
    assert report["points"][-1] == [4.0, -1.0]
    assert report["cost"] >= report["length"] - 0.1
    assert plot.stat().st_size > 5_000
    straight = json.loads(cohelm(*ends, "--json")[1])
    assert straight["length"] == pytest.approx(8.0, abs=0.1)
    assert straight["closest_to_preference"] is None
    assert straight["extra_length"] == 0.0


def test_plan_prints_a_table(cohelm, room):
    code, out, _ = cohelm("plan", room, "--start=-4,-1", "--goal", "4,-1", "--method", "astar")
    assert code == 0
    assert "length" in out


def test_listings(cohelm, monkeypatch, tmp_path):
    assert "hospital" in cohelm("scenarios")[1]
    assert "ss_mpc_dcbf" in cohelm("plugins")[1]
    assert "32 × 1024" in cohelm("robots")[1]
    monkeypatch.setenv("COHELM_DATA", str(tmp_path))
    (tmp_path / "barn").mkdir()
    (tmp_path / "barn" / "worlds.json").write_text("{}")
    lines = cohelm("data")[1].splitlines()
    here = {line.split()[0]: line.split()[1] for line in lines if not line.startswith(" ")}
    assert here["barn"] == "present"
    assert here["crowdnav"] == "absent"


@pytest.mark.parametrize(
    ("text", "spot"),
    [("1,2", (1.0, 2.0)), ("-1,-2.5", (-1.0, -2.5)), ("Ward 3", "Ward 3"), ("3,4,90", (3, 4, 90))],
)
def test_places_are_points_or_names(text, spot):
    assert parsing.place(text, "--start", heading=True) == spot


@pytest.mark.parametrize("text", ["", "1", "1,2,3", "1,", "inf,0", "1 2"])
def test_what_is_no_point(text):
    with pytest.raises(ConfigError):
        parsing.point(text, "--prefer")


def test_json_has_no_nan():
    assert as_json({"b": float("nan"), "a": [float("inf"), 1.0]}) == '{"a": [null, 1.0], "b": null}'


def test_every_measure_is_explained():
    page = (Path(__file__).parents[2] / "docs" / "measures.md").read_text(encoding="utf-8")
    for name in RIDE_MEASURES:
        head, _, tail = name.rpartition("_")
        assert f"`{name}`" in page or (f"`{head}_" in page and f"`_{tail}`" in page), name


@pytest.mark.parametrize(
    ("outcome", "says"), [("reached", "after 4.5 s"), ("timeout", "after 9.0 s")]
)
def test_a_picture_says_when_the_goal_was_reached_else_how_long_was_tried(outcome, says):
    ride = SimpleNamespace(outcome=Outcome(outcome), time=[0.0, 9.0])
    report = {"time": 4.5, "min_distance": float("nan")}
    assert _headline(ride, report, "a ride") == f"a ride: {outcome} {says}"


@pytest.mark.parametrize(
    ("arguments", "option"),
    [
        (("--mode", "nonsense"), "--mode"),
        (("--goal", "Nowhere"), "--goal"),
        (("--robot", "nope"), "--robot"),
        (("--planner", "nope"), "--planner"),
        (("--set", "mode=nonsense"), "--set mode"),
        (("--set", "people.count=-1"), "--set people.count"),
    ],
)
def test_an_error_names_the_option_and_not_the_scenario_file(cohelm, arguments, option):
    code, _, err = cohelm("run", "hospital", *arguments)
    assert code == 2
    *notices, error = err.splitlines()
    assert set(notices) <= {f"{progress.COMPILING} …"}  # with an empty cache
    assert error.startswith(f"error: {option}: ")
    assert not re.search(r"\w\.yaml", err)  # a hint may say ".yaml", no file is named


@pytest.mark.parametrize(
    ("option", "file"),
    [("--plot", "x/a.png"), ("--animate", "x/a.gif"), ("--out", "x/y"), ("--record", "x/a.mcap")],
)
def test_a_mistyped_folder_is_named_and_not_made(cohelm, tmp_path, option, file):
    code, _, err = cohelm(*SHORT, option, tmp_path / file)
    assert (code, err) == (2, f"error: {option}: no folder {tmp_path / 'x'}\n")
    assert not (tmp_path / "x").exists()


def test_map_prints_size_and_checks_points(cohelm, room, tmp_path):
    code, out, _ = cohelm("map", room, "--at=0,0", "--plot", tmp_path / "map.png")
    assert code == 0
    assert "10.00 × 6.00 m" in out
    assert "(0.00, 0.00): the chair fits and can turn on the spot" in out
    assert (tmp_path / "map.png").stat().st_size > 5_000
    code, out, _ = cohelm("map", room, "--at=-4.9,0", "--at=30,30", "--json")
    assert code == 1
    report = json.loads(out)
    # free: without the walls of one cell, 9.8 × 5.8 m
    assert report["free_area"] == pytest.approx(9.8 * 5.8)
    assert [each["fits"] for each in report["at"]] == [False, False]
    x, y = report["at"][0]["nearest"]
    assert cohelm("map", room, f"--at={x},{y}")[0] == 0


@pytest.mark.parametrize("name", scenario_names())
def test_a_listing_counts_the_people_of_the_scenario(name):
    scenario = load_scenario(name)
    content = read_yaml(scenario._file)
    assert count_people(content.get("people", {})) == pedestrian_count(scenario.people)
