"""``cohelm bench``: every benchmark is a command, and leaves what it found in a folder."""

import csv
import dataclasses
import importlib
import json
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from rich.console import Console

from cohelm.benchmarks.bench import BenchReport, Result, Sheet, split_names
from cohelm.cli import bench
from cohelm.cli.bench_commands import BENCHES
from cohelm.cli.report import fitted_table
from cohelm.errors import ConfigError
from cohelm.evaluation.sweeps import RideTask


def count(seeds):
    return [(seed,) for seed in seeds]


def work(task, folder):
    return [Result(row={"seed": task[0], "square": float(task[0] ** 2), "nothing": np.nan})]


def report(results, folder):
    total = sum(each.row["square"] for each in results)
    sheet = Sheet(title="sum", columns=("of", "is"), rows=(("squares", f"{total:g}"),))
    return BenchReport(sheets=(sheet,), notes=("that is all",), summary={"total": total})


@pytest.fixture
def squares(monkeypatch):
    made = SimpleNamespace(
        TITLE="Squares", SEEDS=4, WORKERS=1, tasks=count, work=work, report=report
    )
    module = ModuleType("squares")
    module.create = lambda: made
    monkeypatch.setitem(sys.modules, "squares", module)
    return made


def asked(**changes):
    return bench.BenchRequest(
        **{"seeds": None, "out": None, "workers": None, "json": False, **changes}
    )


def test_help_lists_every_benchmark(cohelm):
    code, out, _ = cohelm("bench", "--help")
    assert code == 0
    assert [name for name in BENCHES if name not in out] == []


@pytest.mark.parametrize("name", BENCHES)
def test_every_benchmark_is_one(name, request):
    if name in {"barn", "crowdnav", "crowds", "lost", "socnav1"}:
        request.getfixturevalue("data")
    module, _, function = BENCHES[name][0].partition(":")
    found = getattr(importlib.import_module(module), function or "create")()
    assert dataclasses.is_dataclass(found)
    assert found.TITLE
    assert found.SEEDS >= 1
    assert found.WORKERS is None or found.WORKERS >= 1
    assert len(found.tasks(range(1))) >= 1
    assert callable(found.work)
    assert callable(found.report)


@pytest.mark.parametrize("name", sorted(set(BENCHES) - {"lost", "simulation", "socnav1"}))
def test_a_setting_that_does_not_exist_is_refused_in_one_line(cohelm, name, tmp_path):
    code, out, err = cohelm("bench", name, "--set", "nonsense.of.all=1", "--out", tmp_path)
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert "No such option" not in err


def test_rows_summary_and_table(squares, tmp_path, capsys):
    assert bench.bench("squares", "squares", asked(out=tmp_path / "new")) == 0
    out = capsys.readouterr().out
    assert "14" in out
    assert "that is all" in out
    with (tmp_path / "new" / "rows.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["square"] for row in rows] == ["0", "1", "4", "9"]
    assert rows[0]["nothing"] == ""
    summary = json.loads((tmp_path / "new" / "summary.json").read_text())
    assert summary["total"] == 14
    assert summary["complete"] is True


def test_json_is_one_object(squares, tmp_path, capsys):
    bench.bench("squares", "squares", asked(out=tmp_path, seeds=2, json=True))
    out = capsys.readouterr().out
    assert out.count("\n") == 1
    assert [row["square"] for row in json.loads(out)["rows"]] == [0, 1]


def test_seeds_go_on_from_the_first(squares, tmp_path):
    bench.bench("squares", "squares", asked(out=tmp_path, seeds=2, first=7))
    rows = json.loads((tmp_path / "summary.json").read_text())["rows"]
    assert [row["seed"] for row in rows] == [7, 8]


def test_an_interrupted_benchmark_says_what_it_has(squares, tmp_path, capsys, monkeypatch):
    def interrupted(task, folder):
        if task[0] == 2:
            raise KeyboardInterrupt
        return work(task, folder)

    monkeypatch.setattr(squares, "work", interrupted)
    assert bench.bench("squares", "squares", asked(out=tmp_path)) == 130
    assert "interrupted" in capsys.readouterr().out
    assert json.loads((tmp_path / "summary.json").read_text())["complete"] is False


def test_a_folder_that_is_none(cohelm, tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    code, out, err = cohelm("bench", "paper-global", "--out", file)
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert "--out" in err


@pytest.mark.parametrize(
    "options", [("--seeds", "0"), ("--workers", "0"), ("--first", "-1"), ("--seeds", "many")]
)
def test_wrong_options(cohelm, options):
    code, out, err = cohelm("bench", "paper-global", *options)
    assert (code, out) == (2, "")
    assert options[0] in err


def test_a_name_that_is_there_twice_is_taken_once():
    assert split_names("apf, dwa,,apf", "--planners") == ("apf", "dwa")


def test_two_files_of_one_name_are_refused_before_anything_is_ridden(squares, tmp_path):
    def both(seeds):
        columns = (("scene", "mine"),)
        return [tuple(RideTask(columns, f"{d}/mine.yaml", (), s) for d in "ab") for s in seeds]

    squares.tasks = both
    with pytest.raises(ConfigError, match="two different rides are called 'mine', seed 0"):
        bench.bench("squares", "squares", asked(out=tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_no_word_of_a_heading_is_cut_in_two_where_there_is_room():
    columns = ("planner", "hit moving, %", "wall/still", "time, s", "tortuousness", "smoothness")
    row = ("ss_mpc_dcbf", "100 [99, 100]", "0 / 0", "13.2 [13.2, 13.2]", "1.02 [1, 2]", "0.44")
    sheet = Sheet(title="sum", columns=columns, rows=(row,))
    for width in (120, 88):
        with (console := Console(width=width)).capture() as drawn:
            console.print(fitted_table(sheet.title, sheet.columns, sheet.rows, width=width))
        head = drawn.get().split("┡")[0]
        assert [w for column in columns for w in column.split() if w not in head] == []


def test_a_table_that_has_room_is_no_wider_than_its_page():
    heads = ("reached, %", "collided, %", "m/s", "walked into", "time, s", "length, m")
    more = ("turning, rad", "effort", "agreement", "fights, %")
    cells = ("0 [0, 79]", "0 [0, 79]", "", "0", "–", "–", "–", "–", "–", "–")
    sheet = Sheet("all", ("mode", "rides", *heads, *more), (("shared", "1", *cells),))
    with (console := Console(width=120)).capture() as drawn:
        console.print(fitted_table(sheet.title, sheet.columns, sheet.rows, width=120))
    assert all(line.rstrip()[-1] in "┓┃┩│┘" for line in drawn.get().splitlines()[1:])


def test_cells_are_folded_evenly_where_not_all_have_room():
    cell = "0.389 [0.383, 0.399]; 0.166"
    sheet = Sheet("all", ("who", *"abcd"), (("ours", *[cell] * 4), ("paper", *["0"] * 4)))
    with (console := Console(width=90)).capture() as drawn:
        console.print(fitted_table(sheet.title, sheet.columns, sheet.rows, width=90))
    lines = [line for line in drawn.get().splitlines() if line.startswith("│")]
    assert len(lines) == 3  # two of ours, one of the paper's
    assert lines[0].count("0.389 [0.383,") == 4


def test_a_table_that_is_too_wide_becomes_a_block_for_each_row():
    claim = "ss_mpc_dcbf passes with a larger minimum distance than the plain MPC in every scene"
    columns = (
        "claim",
        "found",
        *(f"{scene}, 95 % interval" for scene in ("crossing", "aggressive")),
    )
    rows = ((claim, "agrees", "0.12 [0.02, 0.20]", ""), ("another", "no clear difference", "", "–"))
    with (console := Console(width=80)).capture() as drawn:
        console.print(fitted_table("claims", columns, rows, width=80))
    lines = drawn.get().splitlines()
    assert max(map(len, lines)) <= 80
    assert [word for word in claim.split() if word not in drawn.get()] == []
    assert any(line.split() == ["found", "no", "clear", "difference"] for line in lines)
