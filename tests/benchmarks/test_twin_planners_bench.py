"""Orders of planners on both platforms: equal rides, and Kendall's τ by hand."""

import pytest

from cohelm.benchmarks.rides import twin_planners
from cohelm.benchmarks.rides.twin import PLATFORMS
from cohelm.errors import ConfigError, PluginError
from cohelm.evaluation.sweeps.tasks import Result


def rows(times, outcomes=None):
    """Two seeds of each planner; ``times`` are (planar, twin) of each."""
    out = []
    for planner, both in times.items():
        for platform, time in zip(PLATFORMS, both, strict=True):
            for seed in range(2):
                outcome = (outcomes or {}).get((planner, platform), "reached")
                out.append(
                    Result(
                        {
                            "scene": "crossing",
                            "planner": planner,
                            "platform": platform,
                            "seed": seed,
                            "outcome": outcome,
                            "time": time if outcome == "reached" else "",
                            "min_distance": time / 100.0,
                            "jerk_rms": 1.0,
                        }
                    )
                )
    return out


def report(*given, tmp_path):
    return twin_planners.create().report(rows(*given), tmp_path)


def test_the_platforms_ride_the_same():
    for task in twin_planners.create(planners="dwa,teb").tasks(range(1)):
        rides = [(dict(each.columns), each.settings[1:], each.seed) for each in task]
        for planar, twin in zip(rides[::2], rides[1::2], strict=True):
            assert planar[1:] == twin[1:]
            assert [each[0]["platform"] for each in (planar, twin)] == list(PLATFORMS)
            assert planar[0]["planner"] == twin[0]["planner"]


def test_one_exchange_among_four_leaves_two_thirds(tmp_path):
    """Six pairs, one of them discordant: τ = (5 − 1) / 6."""
    times = {"a": (10.0, 10.0), "b": (11.0, 12.0), "c": (12.0, 11.0), "d": (13.0, 13.0)}
    found = report(times, tmp_path=tmp_path)
    assert found.summary["tau"]["time"] == pytest.approx(4.0 / 6.0)
    assert found.summary["tau"][twin_planners.ORDER] == pytest.approx(4.0 / 6.0)
    assert found.summary["tau_of_halves"]["time"] == pytest.approx(1.0)
    assert "b 2 → 3, c 3 → 2" in found.sheets[1].rows[1][-1]
    assert found.notes[0].endswith("2 of 4 planners change place: b, c")


def test_arrivals_come_before_time(tmp_path):
    lost = {("a", "twin"): "stopped"}
    found = report({"a": (10.0, 10.0), "b": (11.0, 11.0)}, lost, tmp_path=tmp_path)
    assert found.summary["places"] == {"planar": {"a": 1, "b": 2}, "twin": {"a": 2, "b": 1}}
    assert found.summary["tau"][twin_planners.ORDER] == pytest.approx(-1.0)


def test_a_measure_that_is_equal_for_all_has_no_order(tmp_path):
    found = report({"a": (10.0, 10.0), "b": (11.0, 11.0)}, tmp_path=tmp_path)
    assert found.sheets[1].rows[-2][:2] == ("jerk", "nan")


def test_unknown_names_are_refused():
    with pytest.raises(PluginError):
        twin_planners.create(planners="dwb")
    with pytest.raises(ConfigError):
        twin_planners.create(settings=("platform.use=twin",))
