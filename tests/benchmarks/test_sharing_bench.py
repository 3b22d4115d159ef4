"""The study of sharing: pairs, tables and options."""

import json
import math

import numpy as np
import pytest

from cohelm.benchmarks.bench import Result
from cohelm.benchmarks.claims import AGREES, CONTRADICTS, UNCLEAR
from cohelm.benchmarks.rides import report, sharing
from cohelm.benchmarks.rides.modes import MODES
from cohelm.benchmarks.rides.sharing_families import FAMILIES, REAL_HANDS, SPLIT
from cohelm.benchmarks.rides.sharing_report import (
    CROSSED_HYPOTHESES,
    EVERY,
    HYPOTHESES,
    gain_notes,
    sharing_report,
)
from cohelm.errors import ConfigError
from cohelm.evaluation.report.rides import Rides
from cohelm.scenarios.build import build_scenario


def columns(ride):
    return dict(ride.columns)


def test_every_seed_has_every_scene_rider_and_mode():
    tasks = sharing.create().tasks(range(2))
    scenes = [each for family in FAMILIES.values() for each in family.scenes]
    assert len(tasks) == 2 * len(scenes)
    assert [columns(task[0])["scene"] for task in tasks] == 2 * scenes
    for task in tasks:
        assert len(task) == len({columns(each)["rider"] for each in task}) * len(MODES)
    hands = sharing.create(families="hands", modes="manual").tasks(range(1))
    assert [len(task) for task in hands] == [2, 2, 1]


def test_riders_take_seeds_in_turn():
    whole, turns = sharing.create().tasks(range(4)), sharing.create(rotate=True).tasks(range(4))
    # Four seeds have four riders of a scene once each, and the same world as without turns.
    ridden = [(columns(each)["scene"], columns(each)["rider"]) for task in turns for each in task]
    for family in FAMILIES.values():
        for scene, riders in family.scenes.items():
            for rider in riders:
                assert ridden.count((scene, rider)) == len(MODES) * 4 // len(riders)
    for all_riders, one in zip(whole, turns, strict=True):
        assert len(one) == len(MODES)
        assert set(one) <= set(all_riders)


def test_the_crossed_study_has_the_split_families_with_difficult_hands():
    tasks = sharing.create(crossed=True, rotate=True).tasks(range(5))
    ridden = {(columns(task[0])["family"], columns(task[0])["rider"]) for task in tasks}
    assert ridden == {(family, hand) for family in SPLIT for hand in REAL_HANDS}
    with pytest.raises(ConfigError, match="no family is called 'hands'"):
        sharing.create(crossed=True, families="hands")


def test_rides_of_one_scene_and_seed_differ_in_rider_and_mode_alone():
    for task in sharing.create().tasks(range(1)):
        own = ("mode=", "rider.use=")
        worlds = {tuple(s for s in ride.settings if not s.startswith(own)) for ride in task}
        assert len(worlds) == 1
        assert {ride.seed for ride in task} == {0}
        for ride in task:
            alone = columns(ride)["mode"] == "autonomous"
            rider = "none" if alone else columns(ride)["rider"]
            assert f"rider.use={rider}" in ride.settings


@pytest.mark.parametrize("name", ["glass-bench", "new-goal", "people-cross"])
def test_all_modes_meet_the_same_world(name):
    tasks = sharing.create().tasks(range(3, 4))
    task = next(each for each in tasks if columns(each[0])["scene"] == name)
    setups = [build_scenario(ride.load(), ride.seed) for ride in task[: len(MODES)]]
    first = setups[0]
    for each in setups[1:]:
        assert np.array_equal(each.start, first.start)
        assert np.array_equal(each.world.grid.data, first.world.grid.data)
        assert np.array_equal(each.world.crowd.position, first.world.crowd.position)
        assert np.array_equal(each.world.rider_route, first.world.rider_route)
        assert np.array_equal(each.arrival, first.arrival)
    other = next(t for t in sharing.create().tasks(range(4, 5)) if columns(t[0])["scene"] == name)
    assert not np.array_equal(build_scenario(other[0].load(), 4).start, first.start)


def test_equal_rides_are_ridden_once(monkeypatch, tmp_path):
    ridden = []

    def row(ride, **_):
        ridden.append(ride)
        return Result({**dict(ride.columns), "seed": ride.seed})

    monkeypatch.setattr(sharing, "ride_row", row)
    bench = sharing.create(families="goal")
    task = bench.tasks(range(1))[0]
    rows = [each.row for each in bench.work(task, tmp_path)]
    assert len(ridden) == 4 * 4 + 1
    assert {each["as_wanted"] for each in rows} == {0.0}
    assert [(r["rider"], r["mode"]) for r in rows] == [
        (columns(ride)["rider"], columns(ride)["mode"]) for ride in task
    ]


# ---------------------------------------------------------------------------- report


def row(mode, seed, *, wanted=1.0, family="unseen", scene="glass-box", rider="ideal", **changes):
    return {
        "family": family, "scene": scene, "rider": rider, "mode": mode, "seed": seed,
        "outcome": "reached" if wanted else "stopped", "time": 20.0 if wanted else math.nan,
        "as_wanted": wanted, "places_missed": 0, "avoided_floor": 0.0,
        "collision_speed": math.nan, "collision_speed_wall": math.nan,
        "collisions_person": 0, "collisions_wall": 0, "standing_contacts": 0,
        "rider_effort": 5.0, "disagreement": 0.1, "intervention_share": 0.2,
        "people_source": "tracker", "error": "", "replay": f"cohelm run {scene} --seed {seed}",
        **changes,
    }  # fmt: skip


def results(shares, count=10, **changes):
    """Rides of each mode, of which a number arrives as wanted."""
    return [
        Result(row(mode, seed, wanted=float(seed < arrived), **changes))
        for mode, arrived in shares.items()
        for seed in range(count)
    ]


@pytest.mark.parametrize(
    ("shared", "alone", "verdict"), [(9, 1, AGREES), (1, 9, CONTRADICTS), (5, 5, UNCLEAR)]
)
def test_a_hypothesis_is_judged_by_paired_arrivals(tmp_path, monkeypatch, shared, alone, verdict):
    monkeypatch.setattr(report, "write_results", lambda *_, **__: ())
    found = sharing_report(results({"shared": shared, "autonomous": alone}), tmp_path, "title")
    assert [each["result"] for each in found.summary["verdicts"]] == [verdict]


def test_shared_is_better_than_both_only_where_both_intervals_are_above_zero(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "write_results", lambda *_, **__: ())
    rows = results({"shared": 9, "manual": 2, "autonomous": 1}, rider="tremor")
    rows += results({"shared": 5, "manual": 9, "autonomous": 0}, rider="noisy", family="way")
    found = sharing_report(rows, tmp_path, "title", CROSSED_HYPOTHESES)
    sheet = next(each for each in found.sheets if each.title.startswith("shared better"))
    both = {row[:2]: row for row in sheet.rows}
    assert both["unseen", "tremor"][-1] == "yes"
    assert both["unseen", "tremor"][2:6] == ("9 of 10", "2 of 10", "1 of 10", "+70.0 [40.0, 100.0]")
    assert both["way", "noisy"][-1] == "no"
    assert both[EVERY, "all hands"][-1] == "open"
    assert ("unseen", "noisy") not in both
    judged = {each["claim"]: each["result"] for each in found.summary["verdicts"]}
    assert len(found.summary["verdicts"]) == 6, judged


def test_where_shared_loses_is_said(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "write_results", lambda *_, **__: ())
    found = sharing_report(results({"manual": 9, "shared": 2, "autonomous": 2}), tmp_path, "title")
    lost = [each for each in found.notes if "loses" in each]
    assert len(lost) == 1
    assert lost[0].startswith("shared loses to manual in glass-box: 2 of 10, manual 9 of 10, -70.0")
    assert "chance" not in lost[0]
    rides = {
        "glass-box": {"shared": Rides([row("shared", 0)]), "manual": Rides([row("manual", 0)])}
    }
    assert gain_notes(rides) == ("shared loses to no other mode in any scene",)


def test_collisions_are_counted_by_speed_and_standing_contacts_apart(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "write_results", lambda *_, **__: ())
    rows = [
        row("manual", i, wanted=0.0, outcome="collision", collisions_wall=1, collision_speed_wall=v)
        for i, v in enumerate((0.1, 0.2, 0.4, 0.7))
    ]
    rows += [row("manual", 4, standing_contacts=1), row("manual", 5, wanted=0.0, avoided_floor=1.0)]
    rows += [row("manual", 6, wanted=0.0, places_missed=2)]
    found = sharing_report([Result(each) for each in rows], tmp_path, "title")
    sheet = next(each for each in found.sheets if each.title.startswith("collisions by speed"))
    assert sheet.rows == (("unseen", "manual", "7", "2", "1", "1", "1", "1", "1"),)


def test_the_tables_are_those_of_all_families(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "write_results", lambda *_, **__: ())
    every = [
        each
        for family, definition in FAMILIES.items()
        for scene, riders in definition.scenes.items()
        for each in results(dict.fromkeys(MODES, 2), 3, family=family, scene=scene, rider=riders[0])
    ]
    found = sharing_report(every, tmp_path, "title")
    assert set(found.summary["families"]) == set(FAMILIES)
    assert len(found.summary["verdicts"]) == len(HYPOTHESES)
    counts = next(each for each in found.sheets if each.title.startswith("arrived"))
    assert counts.rows[0] == ("unseen", "glass-box", "ideal", *["2 of 3"] * len(MODES))
    assert json.loads(json.dumps(found.summary, default=str))


# ---------------------------------------------------------------------------- options


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"families": "unsen"}, "no family is called 'unsen'.*unseen"),
        ({"families": ""}, "names nothing"),
        ({"modes": "share"}, "no mode is called 'share'.*shared"),
        ({"settings": ["rider.use=ideal"]}, "is set by the families"),
        ({"settings": ["mode=shared"]}, "is set by --modes"),
        ({"settings": ["start=[1, 1, 0]"]}, "is set by the seed"),
    ],
)
def test_wrong_options_are_refused_before_a_ride(options, message):
    with pytest.raises(ConfigError, match=message):
        sharing.create(**options)
