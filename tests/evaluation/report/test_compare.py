"""Comparison of two result folders, and ratings."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from tests.evaluation.sweep_rows import result, sweep

from cohelm.benchmarks.bench import Result
from cohelm.cli.app import status
from cohelm.evaluation.report import Rides, read_rides, write_results
from cohelm.evaluation.report.compare import as_dict, compare
from cohelm.evaluation.sweeps.store import SweepHeader, SweepSize, SweepStore
from cohelm.evaluation.sweeps.sweep import write_rows

BY = ("scene", "planner")


def _folder(path, results):
    path.mkdir()
    write_rows([each.row for each in results], path / "rows.csv")
    return path


def _rides(results):
    return Rides([each.row for each in results], BY)


def test_equal_folders_differ_in_nothing(tmp_path, capsys):
    a, b = (_folder(tmp_path / name, sweep(8)) for name in "ab")
    assert status(["compare", str(a), str(b)]) == 0
    assert "no difference" in capsys.readouterr().out
    assert status(["compare", str(a), str(b), "--json", "--strict"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["regressions"], found["identical"], found["pairs"]) == (0, 48, 48)


def test_a_part_is_called_one(tmp_path, capsys):
    folders = [tmp_path / "a", tmp_path / "b"]
    for folder, many in zip(folders, (6, 4), strict=True):
        folder.mkdir()
        with SweepStore(folder, SweepHeader("rides", {}, {})) as store:
            store.set_size(SweepSize(tasks=6, rides=6))
        write_rows([result(seed=k).row for k in range(many)], folder / "rows.csv")
    paths = [str(folder) for folder in folders]
    assert status(["compare", *paths]) == 0
    said = capsys.readouterr().out
    assert said.startswith("B is a part: 4 of 6 rides")
    assert "A is a part" not in said
    assert status(["compare", *paths, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["parts"] == {"a": "", "b": "4 of 6 rides"}


def test_an_injected_regression_is_flagged(tmp_path, capsys):
    slower = [
        Result({**r.row, "time": r.row["time"] + 0.3 * (r.row["planner"] == "dwa")})
        for r in sweep(12)
    ]
    a, b = _folder(tmp_path / "a", sweep(12)), _folder(tmp_path / "b", slower)
    assert status(["compare", str(a), str(b), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    worse = [c for c in found["changes"] if c["verdict"] == "worse"]
    assert {(c["planner"], c["measure"]) for c in worse} == {("dwa", "time")}
    assert worse[0]["difference"] == pytest.approx(0.3, abs=1e-3)

    assert status(["compare", str(a), str(b)]) == 1
    assert "regression" in capsys.readouterr().out
    assert status(["compare", str(b), str(a)]) == 0  # the other way round it is better


def test_chance_alone_is_no_regression():
    """Other draws of the same rides: of twenty comparisons one or two may be called different."""
    before = _rides(sweep(15))
    found = [compare(before, _rides(sweep(15, rng_seed=k))) for k in range(1, 21)]
    assert sum(bool(each.regressions) for each in found) <= 3


def test_rides_that_ended_worse_are_named_and_strict_minds_them(tmp_path, capsys):
    results = sweep(6)
    hit = {**results[4].row, "outcome": "collision", "time": np.nan, "collisions_person": 1.0}
    a = _folder(tmp_path / "a", results)
    b = _folder(tmp_path / "b", [*results[:4], Result(hit), *results[5:]])
    assert status(["compare", str(a), str(b)]) == 0
    out = capsys.readouterr().out
    assert "ended worse: scene=aggressive; planner=dwa, seed 0: reached → collision" in out
    assert status(["compare", str(a), str(b), "--strict"]) == 1


def test_success_is_an_arrival_and_a_collision_instead_is_a_regression(tmp_path, capsys):
    """The worlds of BARN have outcomes of their own."""

    def folder(name, outcome):
        rows = [{"world": w, "planner": "dwa", "seed": 0, "outcome": outcome, "time": 9.0 + w}
                for w in range(8)]  # fmt: skip
        return _folder(tmp_path / name, [Result(row) for row in rows])

    a, b = folder("a", "success"), folder("b", "collision")
    assert read_rides(a).reached.all()
    assert status(["compare", str(a), str(b)]) == 1
    out = capsys.readouterr().out
    assert "regression" in out
    assert "success → collision" in out
    assert status(["compare", str(b), str(a), "--strict"]) == 0


def test_only_equal_seeds_are_compared():
    before, after = sweep(4), [r for r in sweep(6) if r.row["seed"] >= 2]
    found = compare(_rides(before), _rides(after))
    assert (found.pairs, found.only_before, found.only_after) == (12, 12, 12)


def test_what_has_no_number_is_left_out_without_a_warning():
    """The nearest person of a ride with nobody near is at infinity, in A as in B."""
    far, odd = {"min_distance": math.inf, "time": 10.0}, {"time_empty_floor": 0.0, "time": math.inf}
    results = [result(seed=k, **(odd if k % 2 else far)) for k in range(6)]
    found = compare(_rides(results), _rides(results))
    assert (found.pairs, found.identical, found.regressions) == (6, 6, ())
    assert _rides(results).column("time_ratio").tolist() == pytest.approx(
        [
            10.0 / r.row["time_empty_floor"] if r.row["time_empty_floor"] else math.nan
            for r in results
        ],
        nan_ok=True,
    )
    json.dumps(as_dict(found))


@pytest.mark.parametrize(
    ("change", "says"),
    [({"seed": 99}, "no ride in common"), ({"scene": "elsewhere"}, "no ride in common")],
)
def test_folders_without_a_common_ride_are_refused(tmp_path, capsys, change, says):
    a = _folder(tmp_path / "a", [result()])
    b = _folder(tmp_path / "b", [result(**change)])
    assert status(["compare", str(a), str(b)]) == 2
    assert says in capsys.readouterr().err


def test_unknown_measures_are_refused(tmp_path, capsys):
    a = _folder(tmp_path / "a", [result()])
    assert status(["compare", str(a), str(a), "--measures", "tme"]) == 2
    assert "tme" in capsys.readouterr().err


RATING = "ride,seed,config,rating,rater,note\n{}"


def test_a_rating_is_kept_with_its_ride(tmp_path):
    pytest.importorskip("pyarrow")
    write_results(sweep(2), tmp_path, panels=False)
    config = next(row["config"] for row in read_rides(tmp_path) if row["planner"] == "dwa")
    name = "scene=crossing; planner=dwa"
    lines = f"{name},1,{config},5,P01,\n{name},1,{config},2,P02,loud\n"
    (tmp_path / "ratings.csv").write_text(RATING.format(lines))
    write_results(sweep(2), tmp_path, panels=False)
    rated = [row for row in read_rides(tmp_path) if row["raters"]]
    assert [(r["scene"], r["planner"], r["seed"], r["rating"]) for r in rated] == [
        ("crossing", "dwa", 1, 3.5)
    ]
    assert "rides rated" in (tmp_path / "report.html").read_text(encoding="utf-8")
    write_results([result(config="other")], tmp_path, panels=False)  # the ride was changed
    assert not any(row["raters"] for row in read_rides(tmp_path))


@pytest.mark.parametrize("text", ["ride,seed\nx,1\n", RATING.format("a,0,c,6,,\n")])
def test_ratings_that_cannot_be_read_sink_no_report(tmp_path, text):
    (tmp_path / "ratings.csv").write_text(text)
    write_results([result()], tmp_path, panels=False)
    assert "no ratings" in (tmp_path / "report.html").read_text(encoding="utf-8")
