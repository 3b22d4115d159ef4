"""Circuits of the SWADAPT trials: legs, driving in reverse, counting, and the report."""

import dataclasses
import math

import numpy as np
import pytest
from tests.made_rides import made_ride

from cohelm.benchmarks.bench import Result
from cohelm.benchmarks.claims import MET, MISSED
from cohelm.benchmarks.rides import report, swadapt
from cohelm.errors import ConfigError
from cohelm.evaluation import Outcome
from cohelm.evaluation.episode.episode import Episode
from cohelm.scenarios.build import build_scenario
from cohelm.scenarios.scenario import load_scenario


def test_ten_hands_ride_three_circuits_in_four_modes():
    tasks = swadapt.create().tasks(range(1))
    assert len(tasks) == 3 * 10
    assert [dict(ride.columns)["mode"] for ride in tasks[0]] == [
        "manual", "stop_only", "assisted", "shared",
    ]  # fmt: skip
    with pytest.raises(ConfigError, match="is set by the seed"):
        swadapt.create(settings=("start=[1, 1, 0]",))


def test_a_chair_that_gets_nowhere_is_set_to_every_stop(monkeypatch):
    monkeypatch.setattr(swadapt, "LEG_TIME", 0.5)
    ride = swadapt.ride_circuit(load_scenario("swadapt-2", ["mode=manual"]), 0)
    assert ride.outcome is Outcome.STOPPED
    assert ride.time[-1] == pytest.approx(1.05)  # two legs of 0.5 s, eleven ticks each
    np.testing.assert_allclose(ride.pose[11, :2], [11.4, 3.6])
    assert swadapt.circuit_columns(ride)["collisions"] == 0


def test_a_rider_drives_out_of_the_lift_in_reverse():
    scenario = load_scenario("swadapt-3", ["mode=manual"])
    changes = {"start": (7.6, 5.6, 90.0), "goal": (7.6, 3.2), "rider_plan": None, "time_limit": 4.0}
    setup = build_scenario(scenario.model_copy(update=changes), 0)
    rider = swadapt.Backwards(setup.world.rider)
    ride = Episode(dataclasses.replace(setup, world=dataclasses.replace(setup.world, rider=rider)))
    found = ride.run()
    assert found.outcome is Outcome.TIMEOUT  # at 0.24 m/s and less
    assert found.stick[-1, 0] < -0.5
    assert found.pose[-1, 1] < 5.2
    assert abs(found.pose[-1, 2] - math.pi / 2) < 0.1


def test_a_ride_goes_on_a_metre_before_the_collision_and_clear_of_walls():
    pose = np.column_stack([0.25 * np.arange(12), np.zeros((12, 2))])
    gaps = np.full(12, 1.0)
    gaps[-6:] = 0.02
    hit = np.arange(12) == 11
    ride = made_ride(pose, gap_wall=gaps, hit_wall=hit, outcome=Outcome.COLLISION)
    np.testing.assert_allclose(swadapt.before_collision(ride), pose[5])
    start = made_ride(pose[:3], gap_wall=np.zeros(3))
    np.testing.assert_allclose(swadapt.before_collision(start), pose[0])
    both = swadapt.joined([ride, ride, made_ride(pose)], Outcome.REACHED)
    assert len(both.time) == 36
    assert swadapt.circuit_columns(both) == {"collisions": 2, "time": 35 * 0.5}


def row(mode, seed, collisions, time, scene="swadapt-3"):
    return Result({
        "scene": scene, "rider": "tremor", "mode": mode, "seed": seed, "collisions": collisions,
        "outcome": "reached" if math.isfinite(time) else "stopped", "time": time,
        "collisions_wall": collisions, "collisions_person": 0,
        "people_source": "tracker", "error": "", "replay": "",
    })  # fmt: skip


def test_collisions_and_time_are_compared_with_manual_on_equal_seeds(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "write_results", lambda *_, **__: ())
    rows = [row("manual", 0, 4, 100.0), row("manual", 1, 6, 80.0), row("manual", 2, 0, math.nan)]
    rows += [row("assisted", 0, 1, 104.0), row("assisted", 1, 0, math.nan)]
    rows += [row("assisted", 2, 0, 70.0), row("shared", 0, 1, 130.0)]
    found = swadapt.circuits_report(rows, tmp_path)
    lines = {line[:3]: line[3:] for line in found.sheets[0].rows}
    # 1 of the 10 collisions of seeds 0 to 2; 104 s against 100 s where both completed
    assert lines["swadapt-3", "all hands", "assisted"] == (
        "2 of 3", "0.33", "-90.00", "33.33", "87.00", "4.00",
    )  # fmt: skip
    assert lines["swadapt-3", "tremor", "shared"][1:3] == ("1.00", "-75.00")
    assert [v["result"] for v in found.summary["verdicts"]] == [MET, MISSED]
    assert any("7.3 and 1.33" in note for note in found.notes)
