"""``cohelm bench destinations``: its rides, its scores, and a tiny run."""

import numpy as np
import pytest

from cohelm.benchmarks import destinations
from cohelm.benchmarks.destinations import Beliefs, draw_goal, drive, places_floor, score
from cohelm.errors import ConfigError


def test_a_tiny_run_reports_itself(tmp_path):
    bench = destinations.create("hospital")
    results = [row for task in bench.tasks(range(2)) for row in bench.work(task, tmp_path)]
    assert len(results) == 6
    assert {result.row["goals"] for result in results} == {"uniform", "habits", "elsewhere"}
    report = bench.report(results, tmp_path)
    assert [sheet.title for sheet in report.sheets] == [
        "hospital, 38 places: right place",
        "hospital, 38 places: certainty and offers",
    ]


def test_equal_tasks_give_equal_rows(tmp_path):
    bench = destinations.create("hospital", "uniform")
    (task,) = bench.tasks(range(7, 8))
    first, second = (bench.work(task, tmp_path)[0].row for _ in range(2))
    assert {k: str(v) for k, v in first.items()} == {k: str(v) for k, v in second.items()}


def test_a_floor_that_is_too_small_for_a_ride_is_reported(tmp_path):
    bench = destinations.create("ward", "uniform")
    assert [row for task in bench.tasks(range(2)) for row in bench.work(task, tmp_path)] == []
    assert "ward: no two places are 8 m apart" in bench.report([], tmp_path).notes


def test_riders_arrive_and_keep_off_walls():
    floor = places_floor("hospital")
    goal = draw_goal(floor, "uniform", 3)
    track = drive(floor, goal, "tremor", 3)
    assert track.arrived
    assert floor.walls.at(track.poses[:, :2]).min() > 0.2


def test_what_does_not_exist_is_named(monkeypatch):
    monkeypatch.delenv("COHELM_DATA", raising=False)
    with pytest.raises(ConfigError, match="COHELM_DATA is not set"):
        destinations.create("utexas_gdc_3ne")
    with pytest.raises(ConfigError, match="no kind of destination"):
        destinations.create("hospital", "nowhere")
    with pytest.raises(ConfigError, match="betta"):
        destinations.create("hospital", settings=["inference.betta=1"])
    assert destinations.create().floors == ("hospital",)


def test_a_floor_without_names_gets_places(data):
    floor = places_floor("utexas_gdc_3ne")
    points = np.array([place.point for place in floor.places])
    assert len(points) == 24
    cost = np.array([floor.fields.at(point) for point in points])
    assert cost.max() < 1e5
    assert (cost + 1e9 * np.eye(24)).min() > 1.0


def test_scores_of_a_ride_that_is_known():
    belief = np.array([[0.5, 0.5], [0.85, 0.15], [0.4, 0.6], [0.05, 0.95]])
    cost = np.array([[4.0, 8.0], [4.0, 6.0], [4.0, 4.0], [4.0, 2.0]])
    along = Beliefs(belief=belief, cost=cost, offered=((), (0,), (0, 1), (1,)))
    row = score(along, 1, 1.5)
    assert [row[f"top1_{share}"] for share in (25, 50, 75)] == [0.0, 1.0, 1.0]
    assert [row[f"nearest_top1_{share}"] for share in (25, 50, 75)] == [0.0, 1.0, 1.0]
    assert (row["wrong_0.8"], row["wrong_0.9"]) == (1.0, 0.0)
    assert (row["certain"], row["certain_metres_left"], row["new_offers"]) == (1.0, 2.0, 2.0)
    assert score(along, -1, 1.5)["wrong_0.9"] == 1.0
