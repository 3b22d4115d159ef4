"""The benchmark of rides: what is ridden, what a row says, what the report makes of the rows."""

import json
import math
import shlex

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.benchmarks import study
from cohelm.benchmarks.bench import Result, run_tasks
from cohelm.benchmarks.claims import MET, MISSED, OURS, verdict_notes
from cohelm.benchmarks.ride_claims import few_rides, judge
from cohelm.benchmarks.rides import report, rides
from cohelm.benchmarks.rides.cases import (
    OWN_SETTINGS,
    TURNS,
    contender_of,
    installed,
    scene_of,
    scenes_of,
    turn_settings,
)
from cohelm.benchmarks.study import common, ride_of, scenario_of
from cohelm.benchmarks.tables import groups_of, paired_differences, signed_text
from cohelm.errors import ConfigError, PluginError, ScenarioError
from cohelm.evaluation import Outcome
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.statistics import Estimate, bootstrap_median, wilson_share
from cohelm.evaluation.sweeps import ride_row, ride_task
from cohelm.evaluation.sweeps.ride_task import collision_speed, ride_figures

PLAIN = contender_of("ss_mpc_dcbf")


# ---------------------------------------------------------------------------- scenes


def length(points):
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def test_the_turn_of_distracted_is_swept_over_twenty_moments():
    moments = []
    for seed in range(20):
        (way,) = scenario_of((scene_of("distracted"), PLAIN), seed).people.pedestrians
        *before, end, after = way.points
        assert end == (7.5, 5.8)
        assert after == (7.5, 13.0)
        moments.append(length(np.array([*before, end])) / 1.1)
    assert np.allclose(np.array(moments) - 7.2 / 1.1, TURNS, atol=0.01)
    assert np.allclose(np.diff(TURNS), 0.2)


def test_the_sweep_comes_round_again_and_is_of_that_scene_alone():
    rides_of = (scene_of("distracted"), PLAIN)
    assert scenario_of(rides_of, 3).people == scenario_of(rides_of, 23).people
    assert scene_of("crossing").drawn is None


def test_blind_people_do_not_see_and_true_people_are_given():
    scenario = scenario_of((scene_of("crossing", blind=True, true_people=True), PLAIN), 0)
    assert not scenario.people.see_robot
    assert scenario.tracker["use"] == "given"


def test_who_is_blind_anyway_is_not_ridden_twice():
    scenes = scenes_of(["crossing", "aggressive"], blind=False, both=True, true_people=False)
    assert [s.label for s in scenes] == ["crossing", "crossing, blind", "aggressive"]


def test_who_walks_in_a_flow_or_a_group_can_be_blind_too():
    group = ("people.groups=[{points: [[7, 7]]}]", "people.pedestrians=[]")
    for name, settings in (("parallel-flow", ()), ("crossing", group)):
        (scene,) = scenes_of([name], blind=True, both=False, true_people=False, settings=settings)
        assert "people.see_robot=false" in scene.settings
        (again,) = scenes_of(
            [name], blind=True, both=False, true_people=False,
            settings=(*settings, "people.see_robot=false"),
        )  # fmt: skip
        assert again.settings == ()


def test_the_gate_does_not_save_who_is_blind_to_people():
    follower = contender_of("path_follower")
    assert not scenario_of((scene_of("crossing"), follower), 0).gate.separation
    assert scenario_of((scene_of("crossing"), PLAIN), 0).gate.separation


def test_a_setting_of_the_scenario_wins_over_the_scene():
    blind, given = scene_of("crossing", blind=True), common(["people.see_robot=true"])
    assert scenario_of((blind, *given, PLAIN), 0).people.see_robot


def test_a_row_can_be_ridden_again():
    slow = contender_of("slow", "ss_mpc_dcbf", ("local_planner.iterations=1",))
    words = shlex.split(ride_of((scene_of("distracted"), slow), 4).replay)
    assert words[:5] == ["cohelm", "run", "distracted", "--seed", "4"]
    assert words[6::2] == [
        *turn_settings(4), "local_planner.use=ss_mpc_dcbf", "local_planner.iterations=1",
    ]  # fmt: skip


# ---------------------------------------------------------------------------- options


def test_ours_comes_first_and_no_rivals_last():
    names = installed()
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
        rides.create(**options)


def test_tasks_keep_the_planners_of_a_seed_together():
    chosen = rides.create(planners="ss_mpc_dcbf, path_follower", scenes="crossing,aggressive")
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
    assert collision_speed(ride) == 0.5
    row = ride_figures(ride)
    assert row["outcome"] == "collision"
    assert row["collisions_person"] == 1
    assert math.isnan(row["time"])


def test_without_a_touch_there_is_no_speed_of_one(made_ride):
    assert math.isnan(collision_speed(made_ride(np.zeros((3, 3)))))


def test_a_ride_that_breaks_off_is_a_row(monkeypatch, made_ride):
    def run(scenario, seed, on_tick=None):
        if seed == 1:
            raise ZeroDivisionError("no way\nat all")
        return made_ride(np.zeros((2, 3)))

    monkeypatch.setattr(ride_task, "run", run)
    ride_task._time_empty_floor.cache_clear()
    good, bad = (ride_row(ride_of((scene_of("crossing"), PLAIN), seed)).row for seed in (0, 1))
    assert (bad["outcome"], bad["error"]) == ("error", "ZeroDivisionError: no way")
    assert list(good) == list(bad)
    ride_task._time_empty_floor.cache_clear()


def test_the_ride_alone_is_the_same_scene_with_nobody(monkeypatch, made_ride):
    asked = []

    def run(scenario, seed, on_tick=None):
        asked.append((scenario.people.count, seed))
        return made_ride([[0, 0, 0], [5, 0, 0], [10, 0, 0]])

    monkeypatch.setattr(ride_task, "run", run)
    ride_task._time_empty_floor.cache_clear()
    rows = [ride_row(ride_of((scene_of("crossing"), PLAIN), seed)).row for seed in (3, 4)]
    assert [row["time_empty_floor"] for row in rows] == [1.0, 1.0]  # two steps of 0.5 s
    assert asked == [(None, 3), (0, 0), (None, 4)]  # alone once
    ride_task._time_empty_floor.cache_clear()


# ---------------------------------------------------------------------------- report


def row(planner, seed, *, scene="crossing", outcome="reached", time=12.0, **changes):
    hit = outcome == "collision"
    return {
        "scene": scene,
        "planner": planner,
        "seed": seed,
        "outcome": outcome,
        "time": time if outcome == "reached" else math.nan,
        "time_empty_floor": 10.0,
        "collision_speed": 0.4 if hit else math.nan,
        "min_distance": 0.0 if hit else 0.5,
        "collisions_person": int(hit),
        "collisions_wall": 0,
        "standing_contacts": 0,
        "proxemics_intimate": 0.1,
        "stalled_time": 0.2,
        "path_length": 10.0,
        "solve_median_ms": 1.0,
        "solve_p99_ms": 2.0,
        "people_source": "tracker",
        "error": "",
        **changes,
    }


def test_a_median_and_a_share_have_intervals():
    assert bootstrap_median(np.array([1.0, 2.0, 9.0])).mean == 2.0
    none = wilson_share(np.zeros(100, dtype=bool))
    assert (none.mean, none.low) == (0.0, 0.0)
    # Wilson: z² / (n + z²) = 3.8416 / 103.8416
    assert none.high == pytest.approx(0.03699, abs=1e-4)
    assert wilson_share(np.zeros(0, dtype=bool)).count == 0


@pytest.fixture
def no_page(monkeypatch):
    """The HTML page is tested elsewhere."""
    monkeypatch.setattr(report, "write_results", lambda *given, **named: ())


def made_of(rows, folder):
    return report.ride_report([Result(each) for each in rows], folder, rides.SPEC)


def test_the_table_shows_the_rows(tmp_path, no_page):
    rows = [row(OURS, seed, time=11.0 + seed) for seed in range(3)]
    rows += [row("dwa", 0), row("dwa", 1, outcome="collision"), row("dwa", 2, outcome="timeout")]
    rows[0]["standing_contacts"] = 1
    made = made_of(rows, tmp_path)
    table = made.sheets[0]
    by_measure = dict(zip(("planner", "rides", *rides.SPEC.measures), table.rows[0], strict=True))
    assert len(table.columns) == len(table.rows[0])
    assert by_measure["reached"].startswith("100 ")
    assert by_measure["time"].startswith("12.0")
    assert by_measure["time_ratio"].startswith("1.20 ")
    assert by_measure["standing_contact"].startswith("33 ")
    by_measure = dict(zip(("planner", "rides", *rides.SPEC.measures), table.rows[1], strict=True))
    assert by_measure["person_collision"].startswith("33 ")
    assert by_measure["collision_speed"] == "0.40"
    assert (tmp_path / "rides.png").stat().st_size > 0
    assert made.summary["scenes"]["crossing"]["dwa"]["person_collision"]["value"] == pytest.approx(
        1 / 3
    )
    json.dumps(made.summary)


def test_differences_are_taken_on_the_seeds_that_both_rode():
    ours = Rides([row(OURS, seed, time=10.0) for seed in (0, 1, 2)])
    other = Rides([row("dwa", seed, time=10.0 + seed) for seed in (2, 1, 5)])
    assert paired_differences(other, ours, "time").tolist() == [2.0, 1.0]
    assert paired_differences(other, ours, "reached").tolist() == [0.0, 0.0]
    difference = Estimate(mean=0.012, low=-0.0, high=0.02, count=9)
    assert signed_text(difference, "reached") == "+1.2 [0.0, 2.0]"


def test_a_fault_is_named_once_with_its_number_of_rides(tmp_path, no_page):
    rows = [row(OURS, 0)] + [row("dwa", s, outcome="error", error="KeyError: 1") for s in (7, 4)]
    notes = made_of(rows, tmp_path).notes
    assert [note for note in notes if "KeyError" in note] == [
        "dwa ended by an error in 2 rides, first seed 4: KeyError: 1"
    ]


# ---------------------------------------------------------------------------- verdicts


def verdicts(rows, result):
    return [each for each in judge(rides.CLAIMS, groups_of(rows)) if each.result == result]


def test_a_collision_in_crossing_is_missed():
    good = [row(OURS, seed) for seed in range(4)]
    assert verdicts(good, MISSED) == []
    assert len(verdicts(good, MET)) == 3
    bad = verdicts([*good, row(OURS, 4, outcome="collision")], MISSED)
    assert [(each.claim, each.found, each.required) for each in bad] == [
        ("goal reached", "4 of 5", "all"),
        ("collisions", "1 of 5", "none"),
    ]
    assert verdict_notes(bad)[0] == "claims: 2 MISSED"


def test_a_ride_that_broke_off_counts_as_a_collision():
    lost = {"outcome": "error", "error": "KeyError: 1"}
    crossing = [row(OURS, s) for s in range(20)] + [row(OURS, 20, **lost)]
    distracted = [row(OURS, s, scene="distracted", **lost) for s in range(3)]
    bad = {each.subject: each.found for each in verdicts([*crossing, *distracted], MISSED)
           if "collisions" in each.claim}  # fmt: skip
    assert bad[f"crossing, {OURS}"] == "0 of 21, 1 ended by an error"
    assert bad[f"distracted, {OURS}"] == "0 of 3, 3 ended by an error"


def test_slower_than_required_is_missed():
    (verdict,) = verdicts([row(OURS, 0, time=14.1)], MISSED)
    assert (verdict.claim, verdict.found) == ("median time ratio to empty floor", "1.41")


def test_distracted_requires_few_and_slow_collisions_and_fewer_than_every_rival():
    scene = {"scene": "distracted"}
    ours = [row(OURS, s, **scene) for s in range(49)] + [
        row(OURS, 49, outcome="collision", **scene)
    ]
    dwa = [row("dwa", s, outcome="collision" if s < 9 else "reached", **scene) for s in range(50)]
    met = [f"{each.claim} {each.found}" for each in verdicts([*ours, *dwa], MET)]
    missed = [f"{each.claim} {each.found}" for each in verdicts([*ours, *dwa], MISSED)]
    assert any("1 of 50" in each for each in met)
    assert any("against others 2.0 %; best of the others 18.0 %" in each for each in met)
    assert any("0.40 m/s" in each for each in missed)
    apf = [row("apf", s, **scene) for s in range(50)]
    (beaten,) = [each for each in verdicts([*ours, *apf], MISSED)
                 if "against" in each.claim and each.required == "fewest"]  # fmt: skip
    assert (beaten.found, beaten.remark) == ("2.0 %; best of the others 0.0 %", "apf")


def test_scenes_with_blind_people_are_judged_together():
    scene = {"scene": "crossing, blind"}
    ours = [row(OURS, s, time=12.0, **scene) for s in range(20)]
    dwa = [row("dwa", s, time=10.0, **scene) for s in range(20)]
    hit = [row("apf", s, time=9.0, outcome="collision", **scene) for s in range(20)]
    rows = [*ours, *dwa, *hit]
    found = [e for e in judge(rides.CLAIMS, groups_of(rows)) if "blind people" in e.subject]
    assert [each.result for each in found] == [MET, MET, MISSED]
    assert found[-1].found == "1.20"
    assert "dwa" in found[-1].claim


def test_corridors_allow_no_contact_at_all():
    rows = [row(OURS, s, scene="corridor-2") for s in range(3)]
    assert len(verdicts(rows, MET)) == 2
    rows[1]["standing_contacts"] = 1
    assert len(verdicts(rows, MISSED)) == 1


def test_a_baseline_that_is_not_what_it_should_be_is_named():
    gaps = [row("social_mpc", s, min_distance=0.4) for s in range(3)]
    hits = [row("mpc_dcbf", s, scene="aggressive", outcome="collision") for s in range(2)]
    assert len(verdicts([*gaps, *hits], MISSED)) == 2


def test_few_rides_are_called_few():
    assert few_rides(groups_of([row(OURS, s) for s in range(20)])) == ()
    (warning,) = few_rides(groups_of([row(OURS, 0)]))
    assert warning.startswith("1 ride per case: too few")


# ---------------------------------------------------------------------------- as a bench


def test_an_interrupt_keeps_whole_comparisons(monkeypatch, tmp_path):
    def ridden(task, **_):
        if task.seed == 2:
            raise KeyboardInterrupt
        return Result(row(seed=task.seed, **dict(task.columns)))

    monkeypatch.setattr(study, "ride_row", ridden)
    chosen = rides.create(planners="ss_mpc_dcbf,path_follower", scenes="crossing")
    done = run_tasks(chosen, chosen.tasks(range(4)), tmp_path, workers=1)
    assert [(each.row["planner"], each.row["seed"]) for each in done] == [
        (OURS, 0), ("path_follower", 0), (OURS, 1), ("path_follower", 1),
    ]  # fmt: skip
    assert all(isinstance(each, Result) for each in done)
    assert chosen.report(done, tmp_path).sheets


@pytest.mark.slow
def test_a_small_sweep(tmp_path):
    chosen = rides.create(
        planners="ss_mpc_dcbf,path_follower", scenes="aggressive", true_people=True
    )
    done = run_tasks(chosen, chosen.tasks(range(1)), tmp_path, workers=1)
    ours, blind = (each.row for each in done)
    assert ours["outcome"] == "reached"
    assert ours["people_source"] == "simulation"
    assert 1.0 <= ours["time"] / ours["time_empty_floor"] < 1.4
    assert blind["outcome"] == "collision"  # it sees nobody, and nobody sees it
    assert blind["collision_speed"] > 0.5
    again = rides.create(planners="ss_mpc_dcbf", scenes="aggressive", true_people=True)
    (same,) = again.work(again.tasks(range(1))[0], tmp_path)
    timing = set(ride_task.TIMINGS)
    assert all(identical(each, same.row[key]) for key, each in ours.items() if key not in timing)
