"""Sweeps: the same results whoever does the tasks, in any order, however often it was cut short."""

import csv
import errno
import json
import math
import os
import subprocess
import sys

import numpy as np
import pytest

from cohelm.errors import ConfigError
from cohelm.evaluation.sweeps import executors, ride_task
from cohelm.evaluation.sweeps import ledger as ledgers
from cohelm.evaluation.sweeps.executors import RETRIES, WorkersFailed, in_processes, serially
from cohelm.evaluation.sweeps.ledger import Header, Ledger, is_begun, read_records
from cohelm.evaluation.sweeps.ride_task import RideTask
from cohelm.evaluation.sweeps.sweep import run_tasks, sweep, write_rows
from cohelm.evaluation.sweeps.tasks import Done, Fault, Progress, Result

HEADER = Header("toy", {"takes": "0.0"}, {"cohelm": "1", "cohelm/a.py": "f00"})


@pytest.fixture
def toy(toys):
    import toy_bench

    return toy_bench


def kept(bench, folder, count=6, *, executor=serially, resume=False, header=HEADER):
    folder.mkdir(exist_ok=True)
    with Ledger(folder, header, resume=resume) as ledger:
        return sweep(bench, bench.tasks(range(count)), folder, executor=executor, ledger=ledger)


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
    one, other = kept(toy.on(), there), kept(toy.on(), back, executor=backwards)
    assert plain(one.results) == plain(other.results)
    assert (there / "rows.csv").read_bytes() == (back / "rows.csv").read_bytes()
    assert one.whole
    assert not one.faults


def test_processes_give_what_one_gives_though_one_of_them_dies(toy, tmp_path):
    bench = toy.on([(1, "exits once"), (2, "raises")], tmp_path)
    done = kept(bench, tmp_path / "many", 6, executor=in_processes(2))
    assert {i: each.error for i, each in done.faults.items()} == {2: "ZeroDivisionError: no task 2"}
    assert "toy_bench.py" in done.faults[2].traceback
    serial = kept(toy.on(), tmp_path / "one", 6).results
    assert plain(done.results) == plain([each for each in serial if each.row["seed"] != 2])


@pytest.mark.slow
def test_a_task_that_ends_every_process_is_tried_three_times_and_harms_no_other(toy, tmp_path):
    marks = tmp_path / "marks"
    marks.mkdir()
    fails = ((1, "exits"), (3, "exits once"), (5, "killed"))
    done = kept(toy.on(fails, marks), tmp_path / "many", 7, executor=in_processes(2))
    assert done.whole
    assert {i: each.error for i, each in done.faults.items()} == {
        1: f"its process died, {1 + RETRIES} times (exit status 3)",
        5: f"its process died, {1 + RETRIES} times (killed by SIGKILL)",
    }
    begun = [len(list(marks.glob(f"{seed}-*"))) for seed in range(7)]
    assert begun == [1, 1 + RETRIES, 1, 2, 1, 1 + RETRIES, 1]
    serial = kept(toy.on(), tmp_path / "one", 7).results
    fine = [each for each in serial if each.row["seed"] not in {1, 5}]
    assert plain(done.results) == plain(fine)


@pytest.mark.slow
def test_processes_that_do_not_start_are_told(toy, tmp_path):
    with pytest.raises(WorkersFailed, match=r"before their first task.*exit status 7"):
        kept(toy.NoStart(), tmp_path, executor=in_processes(2))
    assert is_begun(tmp_path) is False


def test_without_a_ledger_a_failure_is_raised(toy, tmp_path):
    assert len(run_tasks(toy.on(), toy.on().tasks(range(2)), tmp_path, workers=1)) == 4
    with pytest.raises(RuntimeError, match="task 1: ZeroDivisionError"):
        run_tasks(toy.on([(1, "raises")]), toy.on().tasks(range(2)), tmp_path, workers=1)


def test_a_ride_whose_process_died_is_a_row(tmp_path):
    def dying(work, folder, tasks):
        yield from (Done(index, (), Fault("its process died")) for index, _ in tasks)

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
    assert list(done.faults) == [0, 1]


@pytest.mark.parametrize("executor", [serially, in_processes(1)])
def test_a_task_that_leaves_the_program_ends_itself_alone(toy, tmp_path, executor):
    done = kept(toy.on([(1, "leaves")]), tmp_path, 3, executor=executor)
    assert {i: each.error for i, each in done.faults.items()} == {1: "SystemExit: 4"}
    assert done.whole
    assert len(done.results) == 4


_FIRST_PROCESS = """
import signal
from multiprocessing import resource_tracker
from cohelm.evaluation.processes import without_interrupts
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
    whole = kept(toy.on(), tmp_path / "whole")
    part = kept(toy.on(), tmp_path / "part", executor=interrupted_after(count))
    assert (part.done, part.whole) == (count, False) if count < 6 else (6, True)
    again = kept(toy.on(), tmp_path / "part", resume=True)
    assert plain(again.results) == plain(whole.results)
    rows = [(tmp_path / name / "rows.csv").read_bytes() for name in ("whole", "part")]
    assert rows[0] == rows[1]


def test_only_what_is_missing_is_done_and_what_failed_is_tried_again(toy, tmp_path):
    marks = tmp_path / "marks"
    marks.mkdir()
    bench = toy.on([(1, "raises")], marks)
    assert list(kept(bench, tmp_path / "out", 3).faults) == [1]
    assert list(kept(bench, tmp_path / "out", 5, resume=True).faults) == [1]
    begun = [len(list(marks.glob(f"{seed}-*"))) for seed in range(5)]
    assert begun == [1, 2, 1, 1, 1]


def test_tasks_that_are_asked_for_twice_are_done_twice(toy, tmp_path):
    class Twice(toy.Toy):
        def tasks(self, seeds):
            return 2 * super().tasks(seeds)

    assert len(kept(Twice(), tmp_path, 2).results) == 8
    assert len(read_records(tmp_path)) == 4


def test_wherever_a_record_is_cut_its_task_is_done_again(toy, tmp_path):
    whole = plain(kept(toy.on(), tmp_path, 3).results)
    file = tmp_path / ledgers.LEDGER
    content = file.read_bytes()
    last = content.rstrip(b"\n").rindex(b"\n") + 1
    for end in {*range(last, len(content), 37), last, last + 1, len(content) - 1}:
        file.write_bytes(content[:end])
        assert len(read_records(tmp_path)) == 2
        assert plain(kept(toy.on(), tmp_path, 3, resume=True).results) == whole
        assert len(file.read_bytes().splitlines()) == 4  # nothing of the cut line is left


def test_a_ledger_that_was_cut_before_its_first_line_ended_begins_anew(toy, tmp_path):
    kept(toy.on(), tmp_path, 1)
    file = tmp_path / ledgers.LEDGER
    file.write_bytes(file.read_bytes()[:20])
    assert len(kept(toy.on(), tmp_path, 1, resume=True).results) == 2


@pytest.mark.parametrize(
    "what", ["a byte", "zeros", "arrays", "no arrays", "other arrays", "compressed otherwise"]
)
def test_what_is_damaged_is_done_again(toy, tmp_path, what):
    whole = plain(kept(toy.on(), tmp_path, 3).results)
    file = tmp_path / ledgers.LEDGER
    lines = file.read_bytes().splitlines(keepends=True)
    if what == "a byte":
        lines[2] = lines[2].replace(b"task 1", b"task 7")
    elif what == "zeros":  # as a file system leaves them that lost its power
        lines[2] = bytes(len(lines[2]) - 1) + b"\n"
    else:
        _damage(next(iter((tmp_path / "arrays").glob("*.npz"))), what)
    file.write_bytes(b"".join(lines))
    assert len(read_records(tmp_path)) == 2
    assert plain(kept(toy.on(), tmp_path, 3, resume=True).results) == whole


def _damage(file, what):
    content = bytearray(file.read_bytes())
    match what:
        case "arrays":
            file.write_bytes(b"PK\x03\x04 no more")
        case "no arrays":
            file.unlink()
        case "other arrays":
            np.savez(file, **{"7/noise": np.ones(2)})
        case _:  # a method of compression that no zip file has
            content[content.rindex(b"PK\x01\x02") + 10] ^= 0xFF
            file.write_bytes(content)


def test_a_line_of_another_sweep_among_the_records_does_not_count(toy, tmp_path):
    whole = plain(kept(toy.on(), tmp_path, 3).results)
    file = tmp_path / ledgers.LEDGER
    lines = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(b"".join([*lines[:2], lines[0], b"\n", b"\xff\xfe no line\n", *lines[2:]]))
    assert len(read_records(tmp_path)) == 3
    assert plain(kept(toy.on(), tmp_path, 3, resume=True).results) == whole


@pytest.mark.parametrize(
    ("header", "says"),
    [
        (Header("rides", HEADER.options, HEADER.code), "of 'cohelm bench toy'"),
        (Header("toy", {"takes": "1.0"}, HEADER.code), r"other options \(takes 0.0 → 1.0\)"),
        (
            Header("toy", HEADER.options, {"cohelm": "2", "cohelm/a.py": "ba5"}),
            r"other code \(cohelm 1 → 2, cohelm/a.py\), and 1 of 4 tasks",
        ),
    ],
)
def test_the_folder_of_another_sweep_is_refused_and_stays(toy, tmp_path, header, says):
    kept(toy.on(), tmp_path, 3)
    before = (tmp_path / ledgers.LEDGER).read_bytes()
    with pytest.raises(ConfigError, match=says):
        kept(toy.on(), tmp_path, 4, resume=True, header=header)
    assert (tmp_path / ledgers.LEDGER).read_bytes() == before


def test_other_code_may_report_what_is_whole(toy, tmp_path):
    bench = toy.on([(1, "raises")])
    kept(bench, tmp_path, 3)
    newer = Header("toy", HEADER.options, {"cohelm": "2"})
    again = kept(bench, tmp_path, 3, resume=True, header=newer)
    assert (len(again.results), list(again.faults), again.whole) == (4, [1], True)


def test_results_of_which_nothing_tells_what_they_are_are_not_gone_on_with(tmp_path):
    (tmp_path / "rows.csv").write_text("a\n1\n")
    assert is_begun(tmp_path)
    with pytest.raises(ConfigError, match=r"no ledger.jsonl"):
        Ledger(tmp_path, HEADER, resume=True)


def test_two_do_not_write_the_same_folder(tmp_path):
    with (
        Ledger(tmp_path, HEADER),
        pytest.raises(ConfigError, match="another process"),
    ):
        Ledger(tmp_path, HEADER)
    with Ledger(tmp_path, HEADER):
        pass


def test_nobody_throws_away_what_another_is_writing(toy, tmp_path):
    with Ledger(tmp_path, HEADER) as ledger:
        ledger.add("k", [Result({"a": 1}, {"b": np.ones(2)})])
        with pytest.raises(ConfigError, match="another process"):
            Ledger(tmp_path, HEADER, overwrite=True)
        ledger.add("l", [])
    assert set(read_records(tmp_path)) == {"k", "l"}


def test_results_that_came_while_one_waited_are_not_lost(toy, tmp_path):
    """Between the first look at the folder and the ledger, a cluster may take seconds to start."""
    kept(toy.on(), tmp_path, 1)
    with pytest.raises(ConfigError, match="has results"):
        Ledger(tmp_path, HEADER)
    assert len(read_records(tmp_path)) == 1


def test_what_is_made_of_older_rows_does_not_outlive_them(toy, tmp_path):
    """A sweep may be killed before it writes its report; programs read the Parquet file first."""
    kept(toy.on(), tmp_path, 2)
    for name in ("episodes.parquet", "report.html", "ratings.csv"):
        (tmp_path / name).write_text("of older rows")
    kept(toy.on(), tmp_path, 2, resume=True)
    assert (tmp_path / "episodes.parquet").exists()  # nothing is new
    kept(toy.on(), tmp_path, 3, resume=True)
    assert not (tmp_path / "episodes.parquet").exists()
    with Ledger(tmp_path, HEADER, overwrite=True):
        names = {each.name for each in tmp_path.iterdir()}
    assert {"ratings.csv", "file-1.txt"} <= names
    assert not {"report.html", "rows.csv"} & names
    assert read_records(tmp_path) == {}
    assert not list((tmp_path / "arrays").iterdir())


# ---------------------------------------------------------------------------- writing


def test_a_full_disk_ends_it_and_keeps_what_was_written(toy, tmp_path, monkeypatch):
    write = os.write
    calls = []

    def full(stream, line):
        calls.append(line)
        if len(calls) == 4:  # the header, two tasks, half of the third
            write(stream, line[: len(line) // 2])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(stream, line)

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        with pytest.raises(ConfigError, match=r"No space left.*resume"):
            kept(toy.on(), tmp_path)
    assert (tmp_path / ledgers.LEDGER).read_bytes().endswith(b"\n")
    assert len(read_records(tmp_path)) == 2
    whole = kept(toy.on(), tmp_path / "whole").results
    assert plain(kept(toy.on(), tmp_path, resume=True).results) == plain(whole)


def test_a_disk_that_is_full_from_the_first_is_told(tmp_path, monkeypatch):
    def full(stream, line):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        with pytest.raises(ConfigError, match="No space left"):
            Ledger(tmp_path, HEADER)
    with Ledger(tmp_path, HEADER) as ledger:  # nobody holds its lock
        assert not ledger.records


def test_a_short_write_is_gone_on_with(toy, tmp_path, monkeypatch):
    write = os.write
    monkeypatch.setattr(os, "write", lambda stream, line: write(stream, line[:11]))
    kept(toy.on(), tmp_path, 2)
    assert len(read_records(tmp_path)) == 2


def test_a_row_that_no_file_holds_is_a_fault(toy, tmp_path):
    done = kept(toy.on([(1, "no row")]), tmp_path, 3)
    assert "words and numbers, not object" in done.faults[1].error
    assert len(done.results) == 4


def test_numbers_are_kept_to_the_last_bit(tmp_path):
    numbers = {"a": 0.1 + 0.2, "b": 5e-324, "c": math.nan, "d": -math.inf, "e": 2**60 + 1}
    arrays = {"x": np.array([math.nan, 1 / 3]), "none": np.empty((0, 8)), "on": np.array([True])}
    with Ledger(tmp_path, HEADER) as ledger:
        ledger.add("k", [Result(numbers, arrays), Result({"a": np.float32(0.1)})])
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
    assert Progress(done=40, total=100, seconds=20.0, before=30).left == 120.0
    assert math.isnan(Progress(done=30, total=100, seconds=20.0, before=30).left)


def test_an_interrupt_of_compiled_code_is_no_fault_of_the_ride(monkeypatch):
    def interrupted(scenario, seed):
        raise SystemError("returned a result with an exception set") from KeyboardInterrupt()

    monkeypatch.setattr(ride_task, "run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        ride_task.ride_row(RideTask((), "empty", (), 0))
