"""The benchmark of rides: what is ridden, what a row says, what the report makes of the rows."""

import json
import math
import shlex

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.errors import ConfigError, PluginError, ScenarioError
from cohelm.evaluation import Outcome
from cohelm.evaluation.benches import rides
from cohelm.evaluation.benches.bench import Result, run_tasks
from cohelm.evaluation.benches.rides_report import groups_of, make_report, signed
from cohelm.evaluation.benches.rides_scenes import (
    OWN_SETTINGS,
    TURNS,
    Contender,
    Scene,
    ride_of,
    scenario_of,
    scenes_of,
)
from cohelm.evaluation.benches.rides_verdicts import OURS, verdicts
from cohelm.evaluation.bootstrap import Estimate, median_of, share
from cohelm.evaluation.results.rides import Rides
from cohelm.evaluation.sweeps import ride_row, ride_task
from cohelm.evaluation.sweeps.ride_task import ride_figures, speed_at_touch

PLAIN = Contender("ss_mpc_dcbf", "ss_mpc_dcbf")


# ---------------------------------------------------------------------------- scenes


def length(points):
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def test_the_turn_of_distracted_is_swept_over_twenty_moments():
    moments = []
    for seed in range(20):
        (way,) = scenario_of(Scene("distracted"), PLAIN, seed).people.ways
        *before, end, after = way.points
        assert end == (7.5, 5.8)
        assert after == (7.5, 13.0)
        moments.append(length(np.array([*before, end])) / 1.1)
    assert np.allclose(np.array(moments) - 7.2 / 1.1, TURNS, atol=0.01)
    assert np.allclose(np.diff(TURNS), 0.2)


def test_the_sweep_comes_round_again_and_is_of_that_scene_alone():
    scene = Scene("distracted")
    assert scenario_of(scene, PLAIN, 3).people == scenario_of(scene, PLAIN, 23).people
    assert math.isnan(Scene("crossing").turn(3))


def test_blind_people_do_not_see_and_true_people_are_given():
    scenario = scenario_of(Scene("crossing", blind=True, true_people=True), PLAIN, 0)
    assert not scenario.people.see_robot
    assert scenario.tracker["use"] == "given"


def test_who_is_blind_anyway_is_not_ridden_twice():
    scenes = scenes_of(["crossing", "aggressive"], blind=False, both=True, true_people=False)
    assert [s.label for s in scenes] == ["crossing", "crossing, blind", "aggressive"]


def test_who_walks_in_a_flow_or_a_group_can_be_blind_too():
    group = ("people.groups=[{points: [[7, 7]]}]", "people.ways=[]")
    for name, settings in (("parallel-flow", ()), ("crossing", group)):
        (scene,) = scenes_of([name], blind=True, both=False, true_people=False, settings=settings)
        assert scene.blind
        (again,) = scenes_of(
            [name], blind=True, both=False, true_people=False,
            settings=(*settings, "people.see_robot=false"),
        )  # fmt: skip
        assert not again.blind


def test_the_gate_does_not_save_who_is_blind_to_people():
    follower = Contender("path_follower", "path_follower")
    assert not scenario_of(Scene("crossing"), follower, 0).gate.separation
    assert scenario_of(Scene("crossing"), PLAIN, 0).gate.separation


def test_a_setting_of_the_scenario_wins_over_the_scene():
    scene = Scene("crossing", blind=True, settings=("people.see_robot=true",))
    assert scenario_of(scene, PLAIN, 0).people.see_robot


def test_a_row_can_be_ridden_again():
    contender = Contender("slow", "ss_mpc_dcbf", ("local_planner.iterations=1",))
    words = shlex.split(ride_of(Scene("distracted"), contender, 4).replay)
    assert words[:5] == ["cohelm", "run", "distracted", "--seed", "4"]
    planner, *settings = words[6::2]
    assert planner == "local_planner.use=ss_mpc_dcbf"
    assert settings == list(Scene("distracted").settings_for(contender, 4))


# ---------------------------------------------------------------------------- options


def test_ours_comes_first_and_no_rivals_last():
    names = rides.installed()
    assert names[0] == OURS
    assert set(names[-len(OWN_SETTINGS) :]) == set(OWN_SETTINGS)


@pytest.mark.parametrize(
    ("options", "error", "says"),
    [
        ({"planners": "ss_mpc_dcbg"}, PluginError, "did you mean"),
        ({"scenes": "crosing"}, ScenarioError, "did you mean"),
        ({"planners": OURS, "settings": ["local_planner.iteration=1"]}, ConfigError, "iterations"),
        ({"planners": ","}, ConfigError, r"--planners.*names nothing"),
        ({"scenes": ""}, ConfigError, r"--scenes.*names nothing"),
    ],
)
def test_what_does_not_exist_is_said_before_anything_is_ridden(options, error, says):
    with pytest.raises(error, match=says):
        rides.on(**options)


def test_tasks_keep_the_planners_of_a_seed_together():
    chosen = rides.on(planners="ss_mpc_dcbf, path_follower", scenes="crossing,aggressive")
    tasks = chosen.tasks(range(2))
    assert [(task[0].seed, task[0].scenario) for task in tasks] == [
        (0, "crossing"), (0, "aggressive"), (1, "crossing"), (1, "aggressive"),
    ]  # fmt: skip
    for task in tasks:
        assert [dict(ride.columns)["planner"] for ride in task] == ["ss_mpc_dcbf", "path_follower"]
        assert len({(ride.seed, ride.scenario) for ride in task}) == 1


# ---------------------------------------------------------------------------- rows


def test_the_speed_at_a_touch_is_the_greater_of_both_ticks(made_ride):
    twist = [[0.8, 0.0, 0.0], [0.5, 0.0, 0.0], [0.3, 0.0, 0.0]]
    ride = made_ride(
        np.zeros((3, 3)),
        people=np.zeros((3, 1, 4)),
        twist=twist,
        hit_moving=[[False], [False], [True]],
        outcome=Outcome.COLLISION,
    )
    assert speed_at_touch(ride) == 0.5
    row = ride_figures(ride)
    assert row["outcome"] == "collision"
    assert row["collisions_person"] == 1
    assert math.isnan(row["time"])


def test_without_a_touch_there_is_no_speed_of_one(made_ride):
    assert math.isnan(speed_at_touch(made_ride(np.zeros((3, 3)))))


def test_a_ride_that_breaks_off_is_a_row(monkeypatch, made_ride):
    def run(scenario, seed):
        if seed == 1:
            raise ZeroDivisionError("no way\nat all")
        return made_ride(np.zeros((2, 3)))

    monkeypatch.setattr(ride_task, "run", run)
    ride_task._time_alone.cache_clear()
    good, bad = (ride_row(ride_of(Scene("crossing"), PLAIN, seed)).row for seed in (0, 1))
    assert (bad["outcome"], bad["error"]) == ("error", "ZeroDivisionError: no way")
    assert list(good) == list(bad)
    ride_task._time_alone.cache_clear()


def test_the_ride_alone_is_the_same_scene_with_nobody(monkeypatch, made_ride):
    asked = []

    def run(scenario, seed):
        asked.append((scenario.people.count, seed))
        return made_ride([[0, 0, 0], [5, 0, 0], [10, 0, 0]])

    monkeypatch.setattr(ride_task, "run", run)
    ride_task._time_alone.cache_clear()
    rows = [ride_row(ride_of(Scene("crossing"), PLAIN, seed)).row for seed in (3, 4)]
    assert [row["time_alone"] for row in rows] == [1.0, 1.0]  # two steps of 0.5 s
    assert asked == [(None, 3), (0, 0), (None, 4)]  # alone once
    ride_task._time_alone.cache_clear()


# ---------------------------------------------------------------------------- report


def row(planner, seed, *, scene="crossing", outcome="reached", time=12.0, **changes):
    hit = outcome == "collision"
    return {
        "scene": scene,
        "planner": planner,
        "seed": seed,
        "outcome": outcome,
        "time": time if outcome == "reached" else math.nan,
        "time_alone": 10.0,
        "collision_speed": 0.4 if hit else math.nan,
        "stops": 0,
        "min_distance": 0.0 if hit else 0.5,
        "collisions_person": int(hit),
        "collisions_wall": 0,
        "standing_contacts": 0,
        "proxemics_intimate": 0.1,
        "stalled_time": 0.2,
        "path_length": 10.0,
        "solve_median_ms": 1.0,
        "solve_p99_ms": 2.0,
        "people_from": "tracker",
        "error": "",
        **changes,
    }


def test_a_median_and_a_share_have_intervals():
    assert median_of(np.array([1.0, 2.0, 9.0])).mean == 2.0
    none = share(np.zeros(100, dtype=bool))
    assert (none.mean, none.low) == (0.0, 0.0)
    # Wilson: z² / (n + z²) = 3.8416 / 103.8416
    assert none.high == pytest.approx(0.03699, abs=1e-4)
    assert share(np.zeros(0, dtype=bool)).count == 0


def test_the_table_says_what_the_rows_say(tmp_path):
    rows = [row(OURS, seed, time=11.0 + seed) for seed in range(3)]
    rows += [row("dwa", 0), row("dwa", 1, outcome="collision"), row("dwa", 2, outcome="timeout")]
    rows[0]["standing_contacts"] = 1
    made = make_report(rows, tmp_path)
    ours, dwa = made.sheets[0].rows
    cells = dict(zip(made.sheets[0].columns, ours, strict=True))
    assert cells["reached, %"].startswith("100 ")
    assert cells["time, s"].startswith("12.0 ")
    assert cells["× alone"] == "1.20"
    assert cells["wall/still"] == "0 / 1"
    cells = dict(zip(made.sheets[0].columns, dwa, strict=True))
    assert cells["hit moving, %"].startswith("33 ")
    assert cells["m/s"] == "0.40"
    assert (tmp_path / "rides.png").stat().st_size > 0
    assert made.summary["scenes"]["crossing"]["dwa"]["hit_moving"]["value"] == pytest.approx(1 / 3)
    json.dumps(made.summary)


def test_differences_are_taken_on_the_seeds_that_both_rode():
    ours = Rides([row(OURS, seed, time=10.0) for seed in (0, 1, 2)])
    other = Rides([row("dwa", seed, time=10.0 + seed) for seed in (2, 1, 5)])
    assert other.less(ours, "time").tolist() == [2.0, 1.0]
    assert other.less(ours, "reached").tolist() == [0.0, 0.0]
    assert signed(Estimate(mean=0.012, low=-0.0, high=0.02, count=9), 100.0, 1) == "+1.2 [0.0, 2.0]"


def test_a_fault_is_told_once_with_how_often(tmp_path):
    rows = [row(OURS, 0)] + [row("dwa", s, outcome="error", error="KeyError: 1") for s in (7, 4)]
    notes = make_report(rows, tmp_path).notes
    assert [note for note in notes if "KeyError" in note] == [
        "dwa broke off in 2 rides, first seed 4: KeyError: 1"
    ]


# ---------------------------------------------------------------------------- verdicts


def says(rows, word):
    return [line for line in verdicts(groups_of(rows)) if word in line]


def test_a_collision_in_crossing_is_missed():
    good = [row(OURS, seed) for seed in range(4)]
    assert says(good, "MISSED") == []
    assert len(says(good, ": met")) == 3
    bad = says([*good, row(OURS, 4, outcome="collision")], "MISSED")
    assert [line.split(": ")[1] for line in bad] == [
        "4 of 5 reached", "collisions in 1 of 5, none asked",
    ]  # fmt: skip


def test_a_ride_that_broke_off_counts_as_one_that_collides():
    lost = {"outcome": "error", "error": "KeyError: 1"}
    crossing = [row(OURS, s) for s in range(20)] + [row(OURS, 20, **lost)]
    distracted = [row(OURS, s, scene="distracted", **lost) for s in range(3)]
    bad = says([*crossing, *distracted], "MISSED")
    assert any("collisions in 0 of 21, 1 broke off, none asked" in line for line in bad)
    assert any("moving collisions in 0 of 3, 3 broke off" in line for line in bad)


def test_slower_than_asked_is_missed():
    (line,) = says([row(OURS, 0, time=14.1)], "MISSED")
    assert "1.41 × the ride alone" in line


def test_distracted_asks_for_few_and_slow_hits_and_fewer_than_everybody():
    scene = {"scene": "distracted"}
    ours = [row(OURS, s, **scene) for s in range(49)] + [
        row(OURS, 49, outcome="collision", **scene)
    ]
    dwa = [row("dwa", s, outcome="collision" if s < 9 else "reached", **scene) for s in range(50)]
    found = verdicts(groups_of([*ours, *dwa]))
    assert any("moving collisions in 1 of 50" in line and line.endswith(": met") for line in found)
    assert any("fastest at 0.40 m/s" in line and "MISSED" in line for line in found)
    assert not any("dwa collides" in line for line in found)
    apf = [row("apf", s, **scene) for s in range(50)]
    assert any(
        "apf collides in 0.0 % of the rides: MISSED" in line
        for line in verdicts(groups_of([*ours, *apf]))
    )


def test_blind_people_are_judged_together():
    scene = {"scene": "crossing, blind"}
    ours = [row(OURS, s, time=12.0, **scene) for s in range(20)]
    dwa = [row("dwa", s, time=10.0, **scene) for s in range(20)]
    hit = [row("apf", s, time=9.0, outcome="collision", **scene) for s in range(20)]
    lines = says([*ours, *dwa, *hit], "people blind")
    assert [line.rsplit(": ")[-1] for line in lines] == ["met", "met", "MISSED"]
    assert "1.20 × that of dwa" in lines[-1]


def test_corridors_ask_for_no_touch_at_all():
    rows = [row(OURS, s, scene="corridor-2") for s in range(3)]
    assert len(says(rows, ": met")) == 1
    rows[1]["standing_contacts"] = 1
    assert len(says(rows, "MISSED")) == 1


def test_a_baseline_that_is_a_straw_man_is_named():
    gaps = [row("social_mpc", s, min_distance=0.4) for s in range(3)]
    hits = [row("mpc_dcbf", s, scene="aggressive", outcome="collision") for s in range(2)]
    assert len(says([*gaps, *hits], "MISSED")) == 2


# ---------------------------------------------------------------------------- as a bench


def test_an_interrupt_keeps_whole_comparisons(monkeypatch, tmp_path):
    def ridden(task):
        if task.seed == 2:
            raise KeyboardInterrupt
        return Result(row(seed=task.seed, **dict(task.columns)))

    monkeypatch.setattr(rides, "ride_row", ridden)
    chosen = rides.on(planners="ss_mpc_dcbf,path_follower", scenes="crossing")
    done = run_tasks(chosen, chosen.tasks(range(4)), tmp_path, workers=1)
    assert [(each.row["planner"], each.row["seed"]) for each in done] == [
        (OURS, 0), ("path_follower", 0), (OURS, 1), ("path_follower", 1),
    ]  # fmt: skip
    assert all(isinstance(each, Result) for each in done)
    assert chosen.report(done, tmp_path).sheets


@pytest.mark.slow
def test_a_small_sweep(tmp_path):
    chosen = rides.on(planners="ss_mpc_dcbf,path_follower", scenes="aggressive", true_people=True)
    done = run_tasks(chosen, chosen.tasks(range(1)), tmp_path, workers=1)
    ours, blind = (each.row for each in done)
    assert ours["outcome"] == "reached"
    assert ours["people_from"] == "simulation"
    assert 1.0 <= ours["time"] / ours["time_alone"] < 1.4
    assert blind["outcome"] == "collision"  # it sees nobody, and nobody sees it
    assert blind["collision_speed"] > 0.5
    again = rides.on(planners="ss_mpc_dcbf", scenes="aggressive", true_people=True)
    (same,) = again.work(again.tasks(range(1))[0], tmp_path)
    timing = set(ride_task.TIMINGS)
    assert all(identical(each, same.row[key]) for key, each in ours.items() if key not in timing)
