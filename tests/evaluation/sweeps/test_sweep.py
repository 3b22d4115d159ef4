"""Sweeps: equal results with any executor, in any order, and after any interruption."""

import contextlib
import csv
import json
import math
import os
import sqlite3
import subprocess
import sys

import numpy as np
import pytest

from cohelm.errors import ConfigError
from cohelm.evaluation.sweeps import executors, ride_task
from cohelm.evaluation.sweeps.executors import RETRIES, WorkersFailed, in_processes, serially
from cohelm.evaluation.sweeps.identity import task_keys
from cohelm.evaluation.sweeps.ride_task import RideTask
from cohelm.evaluation.sweeps.store import STORE, SweepHeader, SweepStore, is_begun, read_records
from cohelm.evaluation.sweeps.sweep import run_tasks, sweep, write_rows
from cohelm.evaluation.sweeps.tasks import CompletedTask, Result, SweepState, TaskError

HEADER = SweepHeader("toy", {"takes": "0.0"}, {"cohelm": "1", "cohelm/a.py": "f00"})


@pytest.fixture
def toy(toys):
    import toy_bench

    return toy_bench


def kept(bench, folder, count=6, *, executor=serially, resume=False, header=HEADER):
    folder.mkdir(exist_ok=True)
    with SweepStore(folder, header, resume=resume) as store:
        return sweep(bench, bench.tasks(range(count)), folder, executor=executor, store=store)


def plain(results):
    """Rows and arrays as text: NaN is then equal to NaN."""
    return [
        (json.dumps(dict(each.row)), {k: v.tolist() for k, v in each.arrays.items()})
        for each in results
    ]


# ---------------------------------------------------------------------------- order


def test_the_order_in_which_tasks_end_is_not_that_of_the_results(toy, tmp_path):
    def backwards(work, folder, tasks):
        yield from serially(work, folder, tasks[::-1])

    there, back = tmp_path / "there", tmp_path / "back"
    one, other = kept(toy.create(), there), kept(toy.create(), back, executor=backwards)
    assert plain(one.results) == plain(other.results)
    assert (there / "rows.csv").read_bytes() == (back / "rows.csv").read_bytes()
    assert one.is_complete
    assert not one.errors


@pytest.mark.slow
def test_processes_give_what_one_gives_though_one_of_them_dies(toy, tmp_path):
    bench = toy.create([(1, "exits once"), (2, "raises")], tmp_path)
    done = kept(bench, tmp_path / "many", 6, executor=in_processes(2))
    assert {i: each.error for i, each in done.errors.items()} == {2: "ZeroDivisionError: no task 2"}
    assert "toy_bench.py" in done.errors[2].traceback
    serial = kept(toy.create(), tmp_path / "one", 6).results
    assert plain(done.results) == plain([each for each in serial if each.row["seed"] != 2])


@pytest.mark.slow
def test_a_task_that_ends_every_process_is_tried_three_times_and_harms_no_other(toy, tmp_path):
    marks = tmp_path / "marks"
    marks.mkdir()
    fails = ((1, "exits"), (3, "exits once"), (5, "killed"))
    done = kept(toy.create(fails, marks), tmp_path / "many", 7, executor=in_processes(2))
    assert done.is_complete
    assert {i: each.error for i, each in done.errors.items()} == {
        1: f"its process died, {1 + RETRIES} times (exit status 3)",
        5: f"its process died, {1 + RETRIES} times (killed by SIGKILL)",
    }
    begun = [len(list(marks.glob(f"{seed}-*"))) for seed in range(7)]
    assert begun == [1, 1 + RETRIES, 1, 2, 1, 1 + RETRIES, 1]
    serial = kept(toy.create(), tmp_path / "one", 7).results
    fine = [each for each in serial if each.row["seed"] not in {1, 5}]
    assert plain(done.results) == plain(fine)


@pytest.mark.slow
def test_processes_that_do_not_start_are_told(toy, tmp_path):
    with pytest.raises(WorkersFailed, match=r"before their first task.*exit status 7"):
        kept(toy.NoStart(), tmp_path, executor=in_processes(2))
    assert is_begun(tmp_path) is False


def test_without_a_ledger_a_failure_is_raised(toy, tmp_path):
    assert len(run_tasks(toy.create(), toy.create().tasks(range(2)), tmp_path, workers=1)) == 4
    with pytest.raises(RuntimeError, match="task 1: ZeroDivisionError"):
        run_tasks(toy.create([(1, "raises")]), toy.create().tasks(range(2)), tmp_path, workers=1)


def test_a_ride_whose_process_died_is_a_row(tmp_path):
    def dying(work, folder, tasks):
        yield from (CompletedTask(index, (), TaskError("its process died")) for index, _ in tasks)

    class Rides:
        def tasks(self, seeds):
            return [(RideTask((("planner", "dwa"),), "crossing", (), seed),) for seed in seeds]

        def work(self, task, folder):
            raise AssertionError

    done = kept(Rides(), tmp_path, 2, executor=dying)
    assert [(r.row["planner"], r.row["seed"], r.row["outcome"]) for r in done.results] == [
        ("dwa", 0, "error"), ("dwa", 1, "error"),
    ]  # fmt: skip
    assert {each.row["error"] for each in done.results} == {"its process died"}
    assert done.results[1].row["replay"] == "cohelm run crossing --seed 1"
    assert list(done.errors) == [0, 1]


@pytest.mark.parametrize("executor", [serially, in_processes(1)])
def test_a_task_that_leaves_the_program_ends_itself_alone(toy, tmp_path, executor):
    done = kept(toy.create([(1, "leaves")]), tmp_path, 3, executor=executor)
    assert {i: each.error for i, each in done.errors.items()} == {1: "SystemExit: 4"}
    assert done.is_complete
    assert len(done.results) == 4


_FIRST_PROCESS = """
import signal
from multiprocessing import resource_tracker
from cohelm.processes import without_interrupts
with without_interrupts():
    resource_tracker.getfd()  # as the first process of a program does before it begins
    assert signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())
assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())
"""


def test_the_first_process_of_a_program_hears_no_interrupt_either():
    path = os.pathsep.join(sys.path)
    subprocess.run(
        [sys.executable, "-c", _FIRST_PROCESS], check=True, env={**os.environ, "PYTHONPATH": path}
    )


@pytest.mark.parametrize(
    ("status", "says"),
    [(3, "exit status 3"), (-9, "killed by SIGKILL"), (-45, "killed by signal 45")],
)
def test_how_a_process_ended_is_said_of_every_signal(status, says):
    assert executors._end_of(status) == says


# ---------------------------------------------------------------------------- going on


def interrupted_after(count):
    def executor(work, folder, tasks):
        yield from serially(work, folder, tasks[:count])
        raise KeyboardInterrupt

    return executor


@pytest.mark.parametrize("count", [0, 1, 3, 6])
def test_a_sweep_that_went_on_is_one_that_was_never_cut_short(toy, tmp_path, count):
    whole = kept(toy.create(), tmp_path / "whole")
    part = kept(toy.create(), tmp_path / "part", executor=interrupted_after(count))
    assert (part.done, part.is_complete) == (count, False) if count < 6 else (6, True)
    again = kept(toy.create(), tmp_path / "part", resume=True)
    assert plain(again.results) == plain(whole.results)
    rows = [(tmp_path / name / "rows.csv").read_bytes() for name in ("whole", "part")]
    assert rows[0] == rows[1]


def test_only_what_is_missing_is_done_and_what_failed_is_tried_again(toy, tmp_path):
    marks = tmp_path / "marks"
    marks.mkdir()
    bench = toy.create([(1, "raises")], marks)
    assert list(kept(bench, tmp_path / "out", 3).errors) == [1]
    assert list(kept(bench, tmp_path / "out", 5, resume=True).errors) == [1]
    begun = [len(list(marks.glob(f"{seed}-*"))) for seed in range(5)]
    assert begun == [1, 2, 1, 1, 1]


def test_tasks_that_are_asked_for_twice_are_done_twice(toy, tmp_path):
    class Twice(toy.Toy):
        def tasks(self, seeds):
            return 2 * super().tasks(seeds)

    assert len(kept(Twice(), tmp_path, 2).results) == 8
    assert len(read_records(tmp_path)) == 4


def _changed(folder, statement, *values):
    with contextlib.closing(sqlite3.connect(folder / STORE)) as database, database:
        database.execute(statement, values)


_HALF = """
import os, sqlite3, sys
database = sqlite3.connect(sys.argv[1])
database.execute("PRAGMA cache_size = 1")  # pages of a transaction reach the disk before its end
database.execute("BEGIN")
for i in range(2000):
    database.execute("INSERT INTO task VALUES (?, '[]', ?, NULL, 'x')", (str(i), bytes(500)))
os._exit(9)
"""


def test_a_task_that_was_cut_short_while_it_was_written_is_done_again(toy, tmp_path):
    whole = plain(kept(toy.create(), tmp_path / "whole", 3).results)
    kept(toy.create(), tmp_path / "part", 2)
    ended = subprocess.run(
        [sys.executable, "-c", _HALF, tmp_path / "part" / STORE], check=False
    ).returncode
    assert ended == 9
    assert (tmp_path / "part" / f"{STORE}-journal").exists()
    again = kept(toy.create(), tmp_path / "part", 3, resume=True)
    assert plain(again.results) == whole
    assert len(read_records(tmp_path / "part")) == 3


def test_a_store_without_a_sweep_begins_anew(toy, tmp_path):
    (tmp_path / STORE).write_bytes(b"")
    assert not is_begun(tmp_path)
    assert len(kept(toy.create(), tmp_path, 1, resume=True).results) == 2


@pytest.mark.parametrize("column", ["rows", "arrays", "digest"])
def test_a_damaged_task_is_done_again(toy, tmp_path, column):
    whole = plain(kept(toy.create(), tmp_path, 3).results)
    _changed(
        tmp_path,
        f"UPDATE task SET {column} = substr({column}, 1, length({column}) - 9) WHERE key = ?",
        task_keys(toy.create().tasks(range(3)))[1],
    )
    assert len(read_records(tmp_path)) == 2
    assert plain(kept(toy.create(), tmp_path, 3, resume=True).results) == whole


@pytest.mark.parametrize("content", [b"no database at all" * 99, b"SQLite format 3\0" + bytes(99)])
def test_a_file_that_is_no_store_is_refused_and_stays(toy, tmp_path, content):
    kept(toy.create(), tmp_path, 1)
    (tmp_path / STORE).write_bytes(content)
    assert is_begun(tmp_path)
    with pytest.raises(ConfigError, match="damaged"):
        kept(toy.create(), tmp_path, 1, resume=True)
    assert (tmp_path / STORE).read_bytes() == content


def test_a_store_of_another_version_is_refused(toy, tmp_path):
    kept(toy.create(), tmp_path, 1)
    _changed(tmp_path, "UPDATE sweep SET value = '1' WHERE name = 'format'")
    with pytest.raises(ConfigError, match="another version"):
        kept(toy.create(), tmp_path, 1, resume=True)


@pytest.mark.parametrize(
    ("header", "says"),
    [
        (SweepHeader("rides", HEADER.options, HEADER.code), "of 'cohelm bench toy'"),
        (SweepHeader("toy", {"takes": "1.0"}, HEADER.code), r"other options \(takes 0.0 → 1.0\)"),
        (
            SweepHeader("toy", HEADER.options, {"cohelm": "2", "cohelm/a.py": "ba5"}),
            r"other code \(cohelm 1 → 2, cohelm/a.py\), and 1 of 4 tasks",
        ),
    ],
)
def test_the_folder_of_another_sweep_is_refused_and_stays(toy, tmp_path, header, says):
    kept(toy.create(), tmp_path, 3)
    before = (tmp_path / STORE).read_bytes()
    with pytest.raises(ConfigError, match=says):
        kept(toy.create(), tmp_path, 4, resume=True, header=header)
    assert (tmp_path / STORE).read_bytes() == before


def test_other_code_may_report_what_is_whole(toy, tmp_path):
    bench = toy.create([(1, "raises")])
    kept(bench, tmp_path, 3)
    newer = SweepHeader("toy", HEADER.options, {"cohelm": "2"})
    again = kept(bench, tmp_path, 3, resume=True, header=newer)
    assert (len(again.results), list(again.errors), again.is_complete) == (4, [1], True)


def test_results_of_which_nothing_tells_what_they_are_are_not_gone_on_with(tmp_path):
    (tmp_path / "rows.csv").write_text("a\n1\n")
    assert is_begun(tmp_path)
    with pytest.raises(ConfigError, match=r"no sweep.sqlite"):
        SweepStore(tmp_path, HEADER, resume=True)


def test_two_do_not_write_the_same_folder(tmp_path):
    with (
        SweepStore(tmp_path, HEADER),
        pytest.raises(ConfigError, match="another process"),
    ):
        SweepStore(tmp_path, HEADER)
    with SweepStore(tmp_path, HEADER):
        pass


def test_nobody_throws_away_what_another_is_writing(toy, tmp_path):
    with SweepStore(tmp_path, HEADER) as store:
        store.add("k", [Result({"a": 1}, {"b": np.ones(2)})])
        with pytest.raises(ConfigError, match="another process"):
            SweepStore(tmp_path, HEADER, overwrite=True)
        store.add("l", [])
    assert set(read_records(tmp_path)) == {"k", "l"}


def test_results_that_came_while_one_waited_are_not_lost(toy, tmp_path):
    """Between the first look at the folder and the ledger, a cluster may take seconds to start."""
    kept(toy.create(), tmp_path, 1)
    with pytest.raises(ConfigError, match="has results"):
        SweepStore(tmp_path, HEADER)
    assert len(read_records(tmp_path)) == 1


def test_what_is_made_of_older_rows_does_not_outlive_them(toy, tmp_path):
    """A sweep may be killed before it writes its report; programs read the Parquet file first."""
    kept(toy.create(), tmp_path, 2)
    for name in ("episodes.parquet", "report.html", "ratings.csv"):
        (tmp_path / name).write_text("of older rows")
    kept(toy.create(), tmp_path, 2, resume=True)
    assert (tmp_path / "episodes.parquet").exists()  # nothing is new
    kept(toy.create(), tmp_path, 3, resume=True)
    assert not (tmp_path / "episodes.parquet").exists()
    with SweepStore(tmp_path, HEADER, overwrite=True):
        names = {each.name for each in tmp_path.iterdir()}
    assert {"ratings.csv", "file-1.txt"} <= names
    assert not {"report.html", "rows.csv"} & names
    assert read_records(tmp_path) == {}


# ---------------------------------------------------------------------------- writing


def test_a_full_disk_ends_it_and_keeps_what_was_written(toy, tmp_path, monkeypatch):
    def full(store, *arguments):
        if len(store.records) == 2:
            pages = store._database.execute("PRAGMA page_count").fetchone()[0]
            store._database.execute(f"PRAGMA max_page_count = {pages}")
            arguments = (arguments[0], [Result({"x": "x" * 100_000})])
        return add(store, *arguments)

    add = SweepStore.add
    with monkeypatch.context() as patch:
        patch.setattr(SweepStore, "add", full)
        with pytest.raises(ConfigError, match=r"full.*resume"):
            kept(toy.create(), tmp_path)
    assert len(read_records(tmp_path)) == 2
    whole = kept(toy.create(), tmp_path / "whole").results
    assert plain(kept(toy.create(), tmp_path, resume=True).results) == plain(whole)


def test_a_disk_that_is_full_from_the_first_is_told(tmp_path, monkeypatch):
    def full(*_, **__):
        raise sqlite3.OperationalError("database or disk is full")

    with monkeypatch.context() as patch:
        patch.setattr(sqlite3, "connect", full)
        with pytest.raises(ConfigError, match="disk is full"):
            SweepStore(tmp_path, HEADER)
    with SweepStore(tmp_path, HEADER) as store:  # its lock is free again
        assert not store.records


def test_a_row_that_no_file_holds_is_a_fault(toy, tmp_path):
    done = kept(toy.create([(1, "no row")]), tmp_path, 3)
    assert "text and numbers, not object" in done.errors[1].error
    assert len(done.results) == 4


def test_numbers_are_kept_to_the_last_bit(tmp_path):
    numbers = {"a": 0.1 + 0.2, "b": 5e-324, "c": math.nan, "d": -math.inf, "e": 2**60 + 1}
    arrays = {"x": np.array([math.nan, 1 / 3]), "none": np.empty((0, 8)), "on": np.array([True])}
    with SweepStore(tmp_path, HEADER) as store:
        store.add("k", [Result(numbers, arrays), Result({"a": np.float32(0.1)})])
    (first, second) = read_records(tmp_path)["k"].results
    assert json.dumps(first.row) == json.dumps(numbers)
    assert second.row["a"] == np.float32(0.1)
    assert second.arrays == {}
    for name, each in arrays.items():
        assert first.arrays[name].dtype == each.dtype
        np.testing.assert_array_equal(first.arrays[name], each)


def test_rows_have_the_columns_of_any(tmp_path):
    write_rows([{"a": 1.5, "b": math.nan}, {"c": "x"}], tmp_path / "rows.csv")
    with (tmp_path / "rows.csv").open() as file:
        assert list(csv.DictReader(file)) == [
            {"a": "1.5", "b": "", "c": ""}, {"a": "", "b": "", "c": "x"},
        ]  # fmt: skip


def test_the_time_left_counts_what_was_done_now():
    # 10 of 100 in 20 s, 30 were there before: 60 are left at 2 s
    assert SweepState(done=40, total=100, seconds=20.0, before=30).left == 120.0
    assert math.isnan(SweepState(done=30, total=100, seconds=20.0, before=30).left)


def test_an_interrupt_of_compiled_code_is_no_fault_of_the_ride(monkeypatch):
    def interrupted(scenario, seed, on_tick=None):
        raise SystemError("returned a result with an exception set") from KeyboardInterrupt()

    monkeypatch.setattr(ride_task, "run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        ride_task.ride_row(RideTask((), "empty", (), 0))
