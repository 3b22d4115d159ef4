"""The scenes, measures and report of the global experiment."""

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt, label

from cohelm import plugins
from cohelm.benchmarks.bench import Result, SweepState, run_tasks
from cohelm.benchmarks.paper import global_planners as paper_global
from cohelm.benchmarks.paper import global_report as paper_global_report
from cohelm.benchmarks.paper.global_planners import (
    CLICK_DEVIATION,
    LANE,
    MARGIN,
    WALL,
    office,
    on_the_left,
    taut,
)
from cohelm.errors import ConfigError
from cohelm.evaluation.report.statistics import bootstrap_mean
from cohelm.geometry import arc_length
from cohelm.maps import distance_field
from cohelm.planning import RouteProblem


@pytest.fixture(scope="module")
def scenes(chair):
    return [office(seed, chair) for seed in range(10)]


# ---------------------------------------------------------------------------- scenes


def test_a_seed_is_a_scene(chair, scenes):
    again = office(3, chair)
    assert np.array_equal(again.grid.data, scenes[3].grid.data)
    assert np.array_equal(again.click, scenes[3].click)
    assert len({scene.grid.shape for scene in scenes}) > 1


def test_the_rider_has_room_in_every_heading(chair, scenes):
    for scene in scenes:
        assert distance_field(scene.grid).at(scene.desired).min() >= chair.circumscribed_radius
        assert np.allclose(scene.desired[[0, -1]], [scene.start, scene.goal])
        assert 12.0 < arc_length(scene.desired)[-1] < 16.0  # the paper's are about 13.6 m


def test_the_desired_way_is_smooth(scenes):
    for scene in scenes:
        step = np.diff(scene.desired, axis=0)
        turns = np.diff(np.unwrap(np.arctan2(step[:, 1], step[:, 0])))
        assert np.abs(turns).max() < 0.05  # rad over 5 cm: no curve tighter than a metre


def test_the_left_is_open_and_the_right_is_cluttered(scenes):
    for scene in scenes:
        parts, count, block = things(scene)
        left, right = (round(x / scene.grid.resolution) for x in block[:2, 0])
        assert not parts[:, :left].any()
        assert len(np.unique(parts[:, right + 1 :])) == count  # all but the block, and the floor


def things(scene):
    """(labels of what stands in the room, the walls left out; how many; corners of the largest)."""
    inside = scene.grid.data > 50
    frame = int(WALL / scene.grid.resolution)
    inside[:frame] = inside[-frame:] = False
    inside[:, :frame] = inside[:, -frame:] = False
    parts, count = label(inside)
    block = np.argwhere(parts == np.bincount(parts[parts > 0]).argmax())
    (low_y, low_x), (high_y, high_x) = (
        block.min(axis=0) * scene.grid.resolution,
        (block.max(axis=0) + 1) * scene.grid.resolution,
    )
    corners = [[low_x, low_y], [high_x, low_y], [high_x, high_y], [low_x, high_y]]
    return parts, count, np.array(corners)


def test_clutter_leaves_its_lane_everywhere(scenes):
    for scene in scenes:
        parts, count, _ = things(scene)
        assert LANE[0] <= scene.lane <= LANE[1]
        assert count >= 5  # the block and some clutter
        for part in range(1, count + 1):
            away = distance_transform_edt(parts != part) * scene.grid.resolution
            # The outline is looked up in cells, so a cell at either end may be missing.
            others = (parts != part) & (parts > 0)
            assert away[others].min() > scene.lane - 3 * scene.grid.resolution


def test_the_way_on_the_right_is_the_shorter_one_by_the_margin(scenes):
    for scene in scenes:
        *_, block = things(scene)
        left, right = (taut(scene.start, scene.goal, block, side) for side in (-1, 1))
        assert MARGIN[0] <= scene.margin <= MARGIN[1]
        # Each of the block's edges lies half a cell from what was drawn at most.
        assert left - right == pytest.approx(scene.margin, abs=2 * scene.grid.resolution)
        assert block[0, 0] < scene.desired[:, 0].max() < block[1, 0] + scene.grid.resolution


def test_a_taut_line_is_measured_by_hand():
    # 3-4-5 on the left twice and 2 m along the side; straight along the right side.
    block = np.array([[0.0, 4.0], [3.0, 4.0], [3.0, 6.0], [0.0, 6.0]])
    start, goal = np.array([3.0, 0.0]), np.array([3.0, 10.0])
    assert taut(start, goal, block, -1) == pytest.approx(12.0)
    assert taut(start, goal, block, 1) == pytest.approx(10.0)
    assert on_the_left(np.array([start, [-1.0, 5.0], goal]), block)
    assert not on_the_left(np.array([start, goal]), block)


@pytest.mark.slow
def test_clicks_scatter_as_said(chair):
    away = []
    for seed in range(40):
        scene = office(seed, chair)
        along = arc_length(scene.desired)
        away.append(
            scene.click - [np.interp(along[-1] / 2, along, axis) for axis in scene.desired.T]
        )
    # σ of 80 numbers is known to σ/√160 = 8 %; four times that.
    assert np.std(away) == pytest.approx(CLICK_DEVIATION, rel=0.32)


# ---------------------------------------------------------------------------- measures


def test_tracks_are_compared_at_the_same_times():
    # Both go along x, one at 1 m/s to 4 m, one at 2 m/s to 4 m: apart by t, then by 4 − t.
    slow = np.array([[0.0, 0.0, 0.0], [4.0, 4.0, 0.0]])
    fast = np.array([[0.0, 0.0, 0.0], [2.0, 4.0, 0.0]])
    error = paper_global.synchronised_error(slow, fast)
    assert error[-1] == pytest.approx([4.0, 0.0])
    assert error[:, 1].max() == pytest.approx(2.0)
    assert error[:, 1].mean() == pytest.approx(1.0, abs=0.02)
    assert paper_global.synchronised_error(slow, slow)[:, 1].max() == 0.0


def test_a_drawn_line_is_followed_from_where_one_is(chair, scenes):
    line = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0]])
    problem = RouteProblem(
        grid=scenes[0].grid, robot=chair, start=np.array([1.2, 0.1]), goal=line[-1]
    )
    route = paper_global.DrawnPath(line).plan(problem)
    assert route.points.tolist() == [[1.2, 0.1], [2.0, 0.0], [2.0, 2.0]]
    assert route.length == pytest.approx(2.0 + np.hypot(0.8, 0.1))


def test_a_command_replays_a_row():
    spec = paper_global.METHODS["upf_rayleigh"]
    ridden = paper_global.RiddenMethod("upf_rayleigh", spec, ("goal=[1, 2]",))
    assert paper_global._replay("scenes/3.yaml", ridden) == (
        "cohelm run scenes/3.yaml --method upf --set global_planner.preference.density=rayleigh"
        " --set 'goal=[1, 2]'"
    )


def test_bootstrap_intervals():
    values = np.array([1.0, 2.0, 3.0, np.nan])
    each = bootstrap_mean(values)
    assert (each.mean, each.count) == (2.0, 3)
    assert 1.0 <= each.low < 2.0 < each.high <= 3.0
    assert bootstrap_mean(values).low == each.low
    assert f"{each:.1f}".startswith("2.0 [")
    # Of many values the interval is that of the normal distribution, ±1.96 σ/√n.
    many = np.random.default_rng(0).normal(size=2000)
    assert bootstrap_mean(many).high - bootstrap_mean(many).low == pytest.approx(
        2 * 1.96 / np.sqrt(2000), rel=0.1
    )
    assert f"{bootstrap_mean(np.array([np.nan])):.2f}" == "–"


# ---------------------------------------------------------------------------- report


def result(seed, method, nearest, outcome="reached"):
    row = {"seed": seed, "method": method, "outcome": outcome, "left": method != "astar"}
    row |= dict.fromkeys(paper_global_report.MEASURES, 1.0)
    return Result(row={**row, "nearest_error": nearest, "length": 10.0 + nearest})


def test_the_report_says_what_is_met_and_who_does_not_win(tmp_path):
    results = [
        result(seed, method, error + 0.01 * seed)
        for seed in range(4)
        for method, error in (("astar", 1.0), ("upf", 1.2), ("soft_via", 0.2))
    ]
    report = paper_global_report.global_report(results, [], tmp_path, ["iterative_astar"])
    notes = "\n".join(report.notes)
    assert "iterative_astar is not installed" in notes
    table, differences, claims = report.sheets
    assert ("soft_via", "mean nearest error, m", "0.21", "≤ 0.35", "met", "") in claims.rows
    found = {row[:3]: row[4] for row in claims.rows}
    claim = "nearest error minus that of astar, m"
    assert found["soft_via", claim, "-0.80 [-0.80, -0.80]"] == "met"
    assert found["upf", claim, "+0.20 [+0.20, +0.20]"] == "MISSED"
    assert found["upf", "mean nearest error, m", "1.21"] == "MISSED"
    assert "on the rider's side: astar 0 of 4, upf 4 of 4, soft_via 4 of 4" in notes
    assert "upf is worse than astar: error, nearest +0.20 m, length +0.20 m" in notes
    assert "soft_via is worse" not in notes
    assert "only 4 scenes: with fewer than 5" in notes
    assert "soft_via does not clearly differ from astar: error, same time, time" in notes
    assert [row[0] for row in table.rows[:3]] == ["astar", "upf", "soft_via"]
    assert table.rows[3] == ("paper: upf", "10", "33.90", "13.64", "1.10", "", "")
    assert [row[0] for row in differences.rows] == ["astar", "upf"]
    assert report.summary["measures"]["upf"]["nearest_error"]["count"] == 4


def test_what_found_no_way_is_left_out_of_the_means_and_said(tmp_path):
    results = [result(0, "astar", 1.0), result(1, "astar", np.nan, "no_path")]
    report = paper_global_report.global_report(results, [], tmp_path, [])
    assert "scene 1, astar: no_path" in report.notes
    assert report.sheets[0].rows[0][1] == "1"


# ---------------------------------------------------------------------------- running


class Counting:
    """A benchmark that counts."""

    def work(self, task, folder):
        if task[0] == 2:
            raise KeyboardInterrupt
        return [Result(row={"number": task[0], "half": task[0] / 2})]


def test_an_interrupt_leaves_what_is_done(tmp_path):
    seen = []
    results = run_tasks(
        Counting(), [(0,), (1,), (2,), (3,)], tmp_path, workers=1, watch=seen.append
    )
    assert [each.row["number"] for each in results] == [0, 1]
    assert (tmp_path / "rows.csv").read_text() == "number,half\n0,0\n1,0.5\n"
    assert [each.done for each in seen] == [0, 1, 2]


def test_the_time_left_is_in_proportion():
    assert SweepState(done=2, total=6, seconds=3.0).left == 6.0
    assert np.isnan(SweepState(done=0, total=6, seconds=3.0).left)


@pytest.mark.slow
def test_one_scene_from_end_to_end(tmp_path):
    rows = {each.row["method"]: each.row for each in paper_global.create().work((0,), tmp_path)}
    assert rows["desired"]["left"]
    assert rows["soft_via"]["left"]
    assert set(rows) == {paper_global_report.DESIRED, *paper_global.METHODS}
    assert all(row["outcome"] == "reached" for row in rows.values())
    assert rows["desired"]["nearest_error"] < 1e-9
    assert rows["soft_via"]["nearest_error"] < 0.5
    assert (tmp_path / "scenes" / "0.yaml").exists()


def test_rows_are_chosen_by_name_and_who_is_installed_beside_has_one(monkeypatch):
    assert paper_global.create("soft_via, astar_shortest").methods == ("soft_via", "astar_shortest")
    assert paper_global.create().methods == tuple(paper_global.METHODS)
    with pytest.raises(ConfigError, match=r"--planners.*did you mean 'soft_via'"):
        paper_global.create("softvia")
    there = plugins.names("global_planners")
    monkeypatch.setattr(plugins, "names", lambda group: (*there, "my_own"))
    assert paper_global.create().methods == (*paper_global.METHODS, "my_own")
    assert paper_global.create("my_own").methods == ("my_own",)
