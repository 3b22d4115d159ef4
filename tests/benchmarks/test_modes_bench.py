"""Riders in modes: pairs, verdicts, tables and options, on rows that are made up."""

import json
import math

import numpy as np
import pytest

from cohelm.benchmarks.bench import Result
from cohelm.benchmarks.claims import AGREES, CONTRADICTS, MET, MISSED, UNCLEAR
from cohelm.benchmarks.ride_claims import few_rides, judge
from cohelm.benchmarks.rides import modes, report
from cohelm.benchmarks.rides.modes import (
    ALL_RIDES,
    BY,
    MODES,
    WITHOUT_DESTINATION,
    known_riders,
    modes_report,
)
from cohelm.benchmarks.rides.report import rides_by
from cohelm.benchmarks.tables import column, paired_differences
from cohelm.errors import ConfigError, PluginError, ScenarioError
from cohelm.evaluation.report.rides import Rides


def row(mode, seed, *, rider="ideal", scene="corridor-1", outcome="reached", time=20.0, **changes):
    hit = outcome == "collision"
    return {
        "scene": scene,
        "rider": rider,
        "mode": mode,
        "seed": seed,
        "outcome": outcome,
        "time": time if outcome == "reached" else math.nan,
        "time_empty_floor": 18.0,
        "collision_speed": math.nan,
        "collision_speed_wall": 0.5 if hit else math.nan,
        "collisions_person": 0,
        "collisions_wall": int(hit),
        "standing_contacts": 0,
        "path_length": 12.0,
        "heading_change": 2.0,
        "rider_effort": 5.0,
        "agreement": 0.9,
        "conflict_share": 0.05,
        "people_source": "tracker",
        "error": "",
        "replay": f"cohelm run {scene} --seed {seed}",
        **changes,
    }


def every(count=20, **changes):
    return [row(mode, seed, **changes) for mode in MODES for seed in range(count)]


def rides_of(rows):
    return Rides(rows, BY)


def groups_of(rows):
    rides = rides_of(rows)
    return {
        ALL_RIDES: rides_by(rides, "mode"),
        **{f"scene {k}": rides_by(each, "mode") for k, each in rides_by(rides, "scene").items()},
        **{f"rider {k}": rides_by(each, "mode") for k, each in rides_by(rides, "rider").items()},
    }


def verdicts(claims, rows, word=""):
    return [each for each in judge(claims, groups_of(rows)) if word in str(each)]


# ---------------------------------------------------------------------------- pairs


def test_riders_of_one_scene_and_seed_count_as_one():
    one = rides_of(
        [row("shared", s, rider=r, time=t + s) for s in (0, 1) for r, t in (("a", 10), ("b", 14))]
    )
    other = rides_of([row("manual", s, rider=r, time=9.0) for s in (0, 1) for r in ("a", "b")])
    # seed 0: (10 − 9 + 14 − 9) / 2 = 3; seed 1: 4
    assert paired_differences(one, other, "time").tolist() == [3.0, 4.0]


def test_only_rides_that_both_had_are_paired():
    one = rides_of([row("shared", 0), row("shared", 1), row("shared", 2, scene="corridor-2")])
    other = rides_of([row("manual", 1, time=25.0), row("manual", 2)])
    assert paired_differences(one, other, "time").tolist() == [-5.0]


def test_a_time_is_that_of_who_arrives_and_a_touch_that_of_anything():
    rides = rides_of([row("shared", 0), row("shared", 1, outcome="collision")])
    assert np.isnan(rides.column("time")).tolist() == [False, True]
    assert rides.column("any_collision").tolist() == [0.0, 1.0]
    assert column(rides, "touch_speed").tolist()[1] == 0.5
    person = rides_of([row("shared", 0, collisions_person=1, collision_speed=0.7)])
    assert column(person, "touch_speed").tolist() == [0.7]


# ---------------------------------------------------------------------------- requirements


def test_a_soft_contact_is_allowed_and_a_hard_one_is_named_with_its_ride():
    soft = row("assisted", 20, outcome="collision", collision_speed_wall=0.19)
    missed = verdicts(modes.REQUIREMENTS, [*every(), soft], MISSED)
    assert [each for each in missed if "contacts" in each.claim] == []
    hard = row("assisted", 21, outcome="collision", rider="tremor")
    missed = verdicts(modes.REQUIREMENTS, [*every(), soft, hard], MISSED)
    whole, by_rider = (each for each in missed if "contacts" in each.claim)
    assert (whole.subject, whole.found) == (f"{ALL_RIDES}, assisted", "1 of 22")
    assert whole.claim == "contacts above 0.2 m/s"
    assert by_rider.subject == "rider tremor, assisted"
    assert by_rider.remark == "up to 0.50 m/s: cohelm run corridor-1 --seed 21"


def test_where_rides_broke_off_contacts_are_unknown():
    broken = row("assisted", 20, outcome="error", error="KeyError: 1")
    missed = verdicts(modes.REQUIREMENTS, [*every(), broken], MISSED)
    assert missed[0].found == "0 of 21, 1 ended by an error"


def test_nineteen_of_twenty_shared_rides_are_enough():
    rides = every()
    shared = modes.MODES.index("shared") * 20
    rides[shared] = row("shared", 0, outcome="stopped")
    _, reached = verdicts(modes.REQUIREMENTS, rides, "goal reached")
    assert (reached.found, reached.required, reached.result) == ("19 of 20", "≥ 95 %", MET)
    rides[shared + 1] = row("shared", 1, outcome="timeout")
    _, whole, by_rider = verdicts(modes.REQUIREMENTS, rides, "goal reached")
    assert whole.result == MISSED
    assert (by_rider.subject, by_rider.found) == ("rider ideal, shared", "18 of 20")


def test_the_median_time_is_compared_with_the_empty_floor():
    assert verdicts(modes.REQUIREMENTS, every(time=25.0), "1.39")[0].result == MET  # 25 / 18
    assert verdicts(modes.REQUIREMENTS, every(time=25.3), "1.41")[0].result == MISSED


def test_manual_driving_may_collide():
    rides = [*every(), row("manual", 20, outcome="collision")]
    assert verdicts(modes.REQUIREMENTS, rides, MISSED) == []


def test_few_rides_are_called_few():
    assert few_rides(groups_of(every(3)))
    assert not few_rides(groups_of(every(20)))


# ---------------------------------------------------------------------------- the paper's corridors


def test_shared_collides_less_than_manual_where_it_clearly_does():
    rides = [each for each in every() if each["mode"] != "manual"]
    rides += [row("manual", s, outcome="collision" if s % 2 else "reached") for s in range(20)]
    (found,) = verdicts(modes.PAPER, rides, "shared control collides less")
    assert found.result == AGREES
    assert found.found == f"{ALL_RIDES}, shared 0, manual 50"
    (same,) = verdicts(modes.PAPER, every(), "shared control collides less")
    assert same.result == UNCLEAR


@pytest.mark.parametrize(
    ("alone", "shared", "result"),
    [
        ({"outcome": "stopped"}, {}, AGREES),
        ({"time": 25.0}, {}, AGREES),
        ({}, {"time": 25.0}, CONTRADICTS),
        ({}, {"outcome": "timeout"}, CONTRADICTS),
    ],
)
def test_better_is_to_arrive_more_often_or_as_often_and_sooner(alone, shared, result):
    rides = [row("autonomous", s, **alone) for s in range(20)]
    rides += [row("shared", s, **shared) for s in range(20)]
    (found,) = verdicts(modes.PAPER, rides, "better than autonomous driving")
    assert found.result == result
    assert ("neither fails nor freezes" in found.remark) == (result == CONTRADICTS)


# ---------------------------------------------------------------------------- report


def test_the_tables_are_complete(tmp_path, monkeypatch):
    asked = {}
    monkeypatch.setattr(report, "write_results", lambda *what, **how: asked.update(how) or ())
    rows = [*every(2), *every(2, rider="tremor", scene="corridor-2")]
    made = modes_report([Result(each) for each in rows], tmp_path, modes.ALL_RIDERS)
    titles = [sheet.title.partition(":")[0] for sheet in made.sheets]
    assert titles[0] == "all riders in all scenes"
    assert {f"{mode}, all scenes" for mode in MODES} <= set(titles)
    assert {"corridor-1, all riders", "corridor-2, all riders"} <= set(titles)
    assert all(len(line) == len(s.columns) for s in made.sheets for line in s.rows)
    assert made.summary["modes"]["shared"]["rides"] == 4
    assert made.summary["riders"]["tremor"]["manual"]["rides"] == 2
    assert asked["by"] == ("scene", "rider", "mode")
    assert asked["base"] == "shared"
    json.dumps(made.summary)


@pytest.mark.parametrize("experiment", [modes.CORRIDORS, modes.ALL_RIDERS])
def test_part_of_a_sweep_is_a_report_too(tmp_path, monkeypatch, experiment):
    monkeypatch.setattr(report, "write_results", lambda *what, **how: ())
    broken = row("manual", 0, outcome="error", error="KeyError: 1")
    made = modes_report([Result(broken)], tmp_path, experiment)
    assert any("ideal, manual ended by an error in 1 rides" in note for note in made.notes)


# ---------------------------------------------------------------------------- what is ridden


def test_every_rider_rides_every_mode_with_the_same_seed():
    bench = modes.create_riders(riders="ideal,tremor", scenes="corridor-1,distracted")
    tasks = bench.tasks(range(3))
    assert len(tasks) == 3 * 2 * 2
    for task in tasks:
        assert [dict(ride.columns)["mode"] for ride in task] == list(MODES)
        assert len({(ride.scenario, ride.seed, dict(ride.columns)["rider"]) for ride in task}) == 1
    scenario = tasks[1][0].load()
    assert (scenario.mode.value, scenario.rider["use"]) == ("manual", "tremor")
    turns = {tasks[k][0].load().people.pedestrians[0].points[0] for k in (2, 6, 10)}
    assert len(turns) == 3  # swept over the seeds


def test_ten_riders_ride_by_default():
    names = known_riders()
    assert names[0] == "ideal"
    assert len(names) == 10
    assert not set(names) & set(WITHOUT_DESTINATION)
    for study, scenes in ((modes.create_riders(), 5), (modes.create_corridors(), 4)):
        columns = [dict(task[0].columns) for task in study.tasks(range(1))]
        assert {each["rider"] for each in columns} == set(names)
        assert len({each["scene"] for each in columns}) == scenes


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"riders": "no_such"}, PluginError),
        ({"modes": "hand"}, ConfigError),
        ({"scenes": "no_such"}, ScenarioError),
        ({"riders": ","}, ConfigError),
    ],
)
def test_what_does_not_exist_is_said_before_anything_is_ridden(options, error):
    with pytest.raises(error):
        modes.create_corridors(**options)


@pytest.mark.slow
def test_a_small_sweep_gives_whole_tables(tmp_path):
    bench = modes.create_corridors(riders="ideal", scenes="corridor-1", modes="shared,autonomous")
    results = [each for task in bench.tasks(range(1)) for each in bench.work(task, tmp_path)]
    assert [result.row["mode"] for result in results] == ["shared", "autonomous"]
    assert {result.row["error"] for result in results} == {""}
    assert bench.report(results, tmp_path).sheets[0].rows
