"""The benchmark of both simulations: equal rides, and a report that counts."""

import pytest

from cohelm.benchmarks.rides import twin
from cohelm.errors import ConfigError
from cohelm.evaluation.sweeps.tasks import Result


def row(platform, outcome, seed=0, **more):
    given = {"scene": "crossing", "platform": platform, "seed": seed, "outcome": outcome}
    return Result(
        {**given, "min_distance": 0.2, "time": 10.0, "jerk_rms": 1.0, "force": 0.0, **more}
    )


def test_only_the_platform_differs_within_a_task():
    for task in twin.create().tasks(range(2)):
        assert [dict(each.columns)["platform"] for each in task] == list(twin.PLATFORMS)
        assert len({(each.scenario, each.seed, each.settings[1:]) for each in task}) == 1


def test_collisions_count_as_fast_above_the_limit_only(tmp_path):
    rows = [
        row("planar", "reached"),
        row("twin", "collision", collision_speed=0.15),
        row("planar", "reached", seed=1),
        row("twin", "collision", seed=1, collision_speed=0.25),
    ]
    report = twin.create(scenes="crossing").report(rows, tmp_path)
    assert report.summary["twin"]["fast_collisions"] == 1
    assert report.summary["twin"]["reached"] == 0
    assert len(report.sheets[1].rows) == 2
    assert all("MISSED" in note for note in report.notes)


def test_the_hardest_contact_comes_first_with_its_limit(tmp_path):
    hard = {"energy": 1.0, "part": "shank", "chair_speed": 0.4}
    rows = [row("twin", "reached", force=100.0, **hard)]
    rows += [row("twin", "reached", seed=1, force=300.0, **hard)]
    lines = twin.create(scenes="crossing").report(rows, tmp_path).sheets[2].rows
    assert [line[3] for line in lines] == ["300", "100"]
    assert lines[0][4:8] == ("260", "1.00", "0.56", "0.40")


def test_the_platform_is_the_benchmarks_own():
    with pytest.raises(ConfigError):
        twin.create(settings=("platform.use=twin",))
