"""Faults and lost chairs: pairs, tables, options, and hazards for every kind."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from cohelm.benchmarks.bench import Result
from cohelm.benchmarks.lost import lost_report, roc
from cohelm.benchmarks.rides import faults
from cohelm.benchmarks.rides.fault_report import HAZARDS, fault_report
from cohelm.errors import ConfigError
from cohelm.evaluation import run
from cohelm.messages import Reason
from cohelm.simulation import FAULT_KINDS


def test_every_kind_has_a_hazard():
    assert set(HAZARDS) == set(FAULT_KINDS)


def test_rides_of_one_scene_mode_and_seed_differ_in_the_fault_alone():
    tasks = faults.create(kinds="scan_frozen,pose_drift:0.05", unwatched=True).tasks(range(1))
    rides = [ride for task in tasks for ride in task]
    # two scenes and modes, with and without the monitor: no fault, a frozen scan, a drift
    assert len(rides) == 2 * 2 * 2 * 3
    own = ("faults=", "health.")
    worlds = {(r.scenario, tuple(s for s in r.settings if not s.startswith(own))) for r in rides}
    assert len(worlds) == 4
    drift = next(r for r in rides if dict(r.columns)["fault"] == "pose_drift")
    assert drift.load().faults[0].size == 0.05


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"kinds": "scan_frozn"}, "did you mean 'scan_frozen'"),
        ({"kinds": "scan_frozen:x"}, "not a number"),
        ({"kinds": "scan_frozen:1"}, "has no magnitude"),
        ({"kinds": "scan_glass:2"}, r"must lie in \[0, 1\] share"),
        ({"modes": "flying"}, "no mode"),
        ({"settings": ["time_limit=3"]}, "is set by"),
    ],
)
def test_wrong_options_are_refused(options, message):
    with pytest.raises(ConfigError, match=message):
        faults.create(**options)


def row(fault, seed, *, monitor="on", delay=math.nan, contact=0.0, alarms=0, into=0.0):
    return Result(
        {
            **{"scene": "crossing", "mode": "autonomous", "fault": fault, "magnitude": "nan"},
            **{"monitor": monitor, "seed": seed, "error": "", "duration": 36.0, "alarms": alarms},
            **{"noticed": float(math.isfinite(delay)), "delay": delay, "noticed_by": "scan_frozen"},
            **{"stop_time": 1.0, "stop_distance": 0.4, "contact_speed": contact},
            **{"onset": 3.0, "walked_into": into, "largest_step": 0.04},
        }
    )


def test_contacts_of_the_sound_ride_are_not_caused_by_the_fault(tmp_path):
    results = [
        *(row("none", seed, contact=0.8 * (seed == 1), alarms=1) for seed in range(2)),
        *(row("scan_frozen", seed, delay=0.1 + seed, contact=0.5) for seed in range(2)),
        *(row("scan_frozen", seed, monitor="off", contact=0.7) for seed in range(2)),
    ]
    report = fault_report(results, tmp_path)
    figures = report.summary["cases"]["scan_frozen nan"]
    expected = {"rides": 2, "noticed": 1.0, "delay": 0.6, "contact_speed": 0.5}
    assert figures == pytest.approx(expected)
    # 2 alarms in 2 × 36 s
    assert any("100.0 an hour" in note for note in report.notes)
    assert any("although detectable" in note for note in report.notes)
    table = (tmp_path / "hazards.md").read_text()
    assert "| 2 of 2 | 0.60 | scan_frozen | 1 of 2 → 1 of 2 | 0.50 |" in table


def test_rides_that_decide_nothing_are_neither_missed_nor_detected(tmp_path):
    undecided, early = row("scan_frozen", 2, into=1.0), row("scan_frozen", 3)
    early.row["duration"] = 1.5
    results = [row("none", 0), row("scan_frozen", 0, delay=0.1), row("scan_frozen", 1)]
    report = fault_report([*results, undecided, early], tmp_path)
    figures = report.summary["cases"]["scan_frozen nan"]
    assert figures["noticed"] == 0.5
    assert figures["rides"] == 3
    assert any(note.startswith("1 ended before the fault was noticed") for note in report.notes)


def test_a_chair_that_was_not_carried_is_not_missed(tmp_path):
    carried, stayed = row("kidnapped", 0), row("kidnapped", 1)
    carried.row["largest_step"] = 1.0
    report = fault_report([row("none", 0), carried, stayed], tmp_path)
    assert report.summary["cases"]["kidnapped nan"]["noticed"] == 0.0
    report = fault_report([row("none", 0), row("kidnapped", 2, delay=0.2), stayed], tmp_path)
    assert report.summary["cases"]["kidnapped nan"]["noticed"] == 1.0


def test_a_fault_may_be_undetectable_at_some_magnitudes(tmp_path):
    """Contacts at these break no promise, and the table says so."""
    results = [row("none", 0), row("scan_free_sector", 0, contact=0.7)]
    for magnitude, broken in (("20", False), ("90", True)):
        results[1].row["magnitude"] = magnitude
        report = fault_report(results, tmp_path)
        assert any("although detectable" in note for note in report.notes) is broken
    assert "not reliably detectable at 20, 45" in (tmp_path / "hazards.md").read_text()


def finding(reason, *, stops):
    """Tick of a chair with one finding."""
    health = SimpleNamespace(
        findings=(SimpleNamespace(reason=reason),), stop=reason if stops else None
    )
    return SimpleNamespace(health=health, decision=SimpleNamespace(reason=reason))


def truth(time, speed, *, into=False):
    twist, hit = np.array([speed, 0.0, 0.0]), np.array([into])
    return SimpleNamespace(time=time, twist=twist, hit_standing=hit)


def test_a_ride_ends_when_the_chair_has_stood_for_a_finding_or_is_walked_into():
    watch = faults.FaultWatch(1.0)
    stop, slow = (finding(Reason.LOST, stops=each) for each in (True, False))
    assert not watch.see(slow, truth(1.0, 0.0))
    assert not watch.see(stop, truth(2.0, 0.3))
    assert not any(watch.see(stop, truth(2.5 + t, 0.0)) for t in (0.0, 1.0, 2.9))
    assert not watch.see(slow, truth(5.45, 0.0))  # interrupted
    assert not watch.see(stop, truth(5.5, 0.0))
    assert watch.see(stop, truth(5.5 + faults.STOOD, 0.0))
    assert faults.FaultWatch(1.0).see(slow, truth(0.5, 0.0, into=True))


@pytest.mark.parametrize("kind", ["none", "kidnapped:3", "command_delayed:0.3", "scan_frozen"])
def test_a_ride_from_the_onset_equals_one_from_the_start(kind):
    """Also as the second one that leaves the same beginning."""
    bench = faults.create(kinds=f"pose_frozen,{kind}" if kind != "none" else "pose_frozen")
    ((none, *_, last),) = [
        [ride for ride in task if dict(ride.columns)["mode"] == "stop_only"]
        for task in bench.tasks(range(1))[1:2]
    ]
    task = none if kind == "none" else last
    start, scenario = faults.FaultStart(0.4), load_with_onset(task)
    start.drive(load_with_onset(last), 0)
    branched = start.drive(scenario, 0)
    alone = run(scenario, 0, faults.FaultWatch(0.4).see)
    for name in ("pose", "twist", "command", "stick", "people", "time"):
        np.testing.assert_array_equal(getattr(branched, name), getattr(alone, name))
    assert branched.outcome is alone.outcome


def load_with_onset(task):
    """Scenario of a task whose fault begins at 0.4 s, for two seconds."""
    scenario = task.load(("time_limit=2.4",))
    faulted = tuple(each.model_copy(update={"at": 0.4}) for each in scenario.faults)
    return scenario.model_copy(update={"faults": faulted})


def drive(carried, contradiction, found=math.nan):
    time = np.arange(0.0, 8.05, 0.1)
    level = np.where(time > 5.0, contradiction, 0.02)
    series = np.column_stack([time, level, np.zeros((len(time), 3))])
    columns = {"floor": "a", "seed": 0, "people": 0, "carried": float(carried), "distance": 2.0}
    return Result(
        {**columns, "at": 5.0, "duration": 8.0, "found": found, "error": ""}, {"series": series}
    )


def test_the_curve_counts_detections_in_time_and_alarms_per_hour(tmp_path):
    results = [drive(True, 0.4, found=5.3), drive(False, 0.2, found=6.0), drive(True, 0.1)]
    curve = roc([r.row for r in results], [r.arrays["series"] for r in results])
    low = next(p for p in curve if p.threshold > 0.2)  # contradiction of about 0.1
    assert low.detected == 1.0
    assert low.alarms == pytest.approx(3600.0 / (5.0 + 8.0 + 5.0))
    assert next(p for p in curve if p.threshold > 1.05).alarms == 0.0
    assert curve[-1].detected == 0.0
    summary = lost_report(results, tmp_path).summary
    assert summary["detected_1m"] == 0.5
    assert summary["false"] == ["a 0"]
