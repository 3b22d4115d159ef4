"""Sweeps on Dask: the same results as in one process, also if workers die; error messages."""

import concurrent.futures
import json
import math
import os
import signal
import socket
import subprocess
import sys
import time

import pytest

from cohelm.arrays import identical
from cohelm.errors import ConfigError
from cohelm.evaluation.sweeps import dask_cluster
from cohelm.evaluation.sweeps.executors import WorkersFailed, serially
from cohelm.evaluation.sweeps.ride_task import TIMINGS
from cohelm.evaluation.sweeps.sweep import executor_for, sweep

pytest.importorskip("distributed")
quiet = pytest.mark.filterwarnings("default")  # those of the cluster's own processes and sockets


def plain(results):
    """Rows and arrays as text: NaN is then equal to NaN."""
    rows = (json.dumps(dict(r.row), default=lambda number: number.item()) for r in results)
    arrays = ({name: v.tolist() for name, v in r.arrays.items()} for r in results)
    return list(zip(rows, arrays, strict=True))


def on_cluster(bench, tasks, folder, *, where="local", watch=lambda progress: None):
    folder.mkdir()
    with executor_for(where, 2) as executor:
        return sweep(bench, tasks, folder, executor=executor, watch=watch)


@pytest.fixture
def toy(toys):
    import toy_bench

    return toy_bench


@pytest.mark.slow
@quiet
def test_a_worker_that_dies_loses_nothing_and_files_come_back(toy, tmp_path):
    tasks = toy.Toy().tasks(range(8))
    bench = toy.create([(1, "exits once"), (2, "raises")], tmp_path)
    done = on_cluster(bench, tasks, tmp_path / "dask")
    assert {i: each.error for i, each in done.errors.items()} == {2: "ZeroDivisionError: no task 2"}
    (tmp_path / "serial").mkdir()
    serial = sweep(toy.create(), tasks, tmp_path / "serial", executor=serially)
    assert plain(done.results) == plain([r for r in serial.results if r.row["seed"] != 2])
    assert (tmp_path / "dask" / "file-7.txt").read_text() == "task 7"


@quiet
@pytest.mark.slow
def test_a_task_that_ends_every_worker_is_a_fault(toy, tmp_path):
    done = on_cluster(toy.create([(1, "exits")]), toy.Toy().tasks(range(4)), tmp_path / "dask")
    assert {i: each.error for i, each in done.errors.items()} == {1: "its worker died, 3 times"}
    assert len(done.results) == 6


@quiet
def test_a_scheduler_that_is_not_there_is_told_within_seconds():
    with socket.socket() as taken:  # a port at which nobody answers
        taken.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        began = time.monotonic()
        with (
            pytest.raises(WorkersFailed, match=r"no Dask scheduler answers.*dask scheduler"),
            executor_for(address, 2),
        ):
            pass
        assert time.monotonic() - began < 60.0


def test_an_address_that_is_none_is_told():
    with pytest.raises(WorkersFailed, match="no Dask scheduler answers"), executor_for("here", 2):
        pass


def test_dask_is_an_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ConfigError, match=r"cohelm\[cluster\]"), executor_for("local", 2):
        pass


# ---------------------------------------------------------------------------- a scheduler of others


def start(*words, **changes):
    environment = {**os.environ, "DASK_DISTRIBUTED__WORKER__DAEMON": "True", **changes}
    paths = [*changes.get("PYTHONPATH", "").split(os.pathsep), *sys.path]
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, paths))  # the same code as here
    return subprocess.Popen(
        [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]],
        env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True,
    )  # fmt: skip


@pytest.fixture
def scheduler():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    process = start("dask_scheduler", "--port", str(port), "--host", "127.0.0.1", "--no-dashboard")
    yield f"tcp://127.0.0.1:{port}", process
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()


@pytest.fixture
def worker(scheduler):
    begun = []

    def _worker(**changes):
        words = ("--nthreads", "1", "--no-dashboard")
        begun.append(start("dask_worker", scheduler[0], *words, **changes))
        return begun[-1]

    yield _worker
    for each in begun:
        os.killpg(each.pid, signal.SIGKILL)
        each.wait()


@pytest.fixture
def patient(monkeypatch):
    monkeypatch.setattr(dask_cluster, "ANSWER", 60.0)  # a busy machine starts it slowly
    monkeypatch.setattr(dask_cluster, "FIRST_WORKER", 120.0)
    return dask_cluster


@quiet
@pytest.mark.slow
def test_a_scheduler_without_workers_is_told(scheduler, patient, monkeypatch):
    monkeypatch.setattr(patient, "FIRST_WORKER", 1.0)
    with pytest.raises(WorkersFailed, match="has no workers"), executor_for(scheduler[0], 2):
        pass


@quiet
@pytest.mark.slow
def test_workers_that_come_later_and_a_scheduler_that_goes(
    toy, toys, scheduler, worker, patient, tmp_path
):
    worker(PYTHONPATH=str(toys))

    def watch(progress):
        if progress.done == 1:
            worker(PYTHONPATH=str(toys))
        if progress.done == 6:
            os.killpg(scheduler[1].pid, signal.SIGKILL)

    bench = toy.create(takes=0.2)
    with pytest.raises(WorkersFailed, match=r"scheduler went away.*--resume"):
        on_cluster(bench, bench.tasks(range(400)), tmp_path / "o", where=scheduler[0], watch=watch)
    with (tmp_path / "o" / "rows.csv").open() as rows:
        assert len(list(rows)) >= 1 + 2 * 6


class Gone:
    """What is left of a client and its future whose scheduler has just died."""

    status, loop = "finished", None

    def nthreads(self):
        raise OSError("Connection reset by peer")

    def exception(self):
        return None

    def result(self):
        raise concurrent.futures.CancelledError


def test_a_scheduler_that_goes_between_two_questions_is_told(tmp_path):
    dask = dask_cluster._Dask(Gone(), None, "tcp://there")
    for ask in (dask._workers, lambda: dask._done(Gone(), 0, tmp_path)):
        with pytest.raises(WorkersFailed, match=r"tcp://there: the scheduler went away"):
            ask()


@quiet
@pytest.mark.slow
def test_a_worker_with_other_code_is_told(scheduler, worker, patient, toy, toys, tmp_path):
    patch = tmp_path / "sitecustomize.py"  # a worker that believes in another numpy
    patch.write_text(
        "import importlib.metadata as m\n"
        "true = m.version\n"
        "m.version = lambda name: '1.0' if name == 'daqp' else true(name)\n"
    )
    worker(PYTHONPATH=f"{tmp_path}:{toys}")
    with pytest.raises(WorkersFailed, match=r"runs other code \(daqp .* → 1.0\)"):
        on_cluster(toy.create(), toy.Toy().tasks(range(2)), tmp_path / "out", where=scheduler[0])


# ---------------------------------------------------------------------------- rides


def same_rides(one, other):
    for mine, theirs in zip(one, other, strict=True):
        assert set(mine.row) == set(theirs.row)
        for name, each in mine.row.items():
            assert name in TIMINGS or identical(each, theirs.row[name]), name
        assert identical(mine.arrays["series"], theirs.arrays["series"])


@quiet
@pytest.mark.slow
def test_thousands_of_rides_are_those_of_one_process_though_a_worker_is_killed(toys, tmp_path):
    """COHELM_RIDES says how many, 3000 where it does not."""
    import short_rides as bench

    count = int(os.environ.get("COHELM_RIDES", "3000"))
    killed = []

    def kill_one(progress):
        if progress.done == count // 3 and not killed:
            import psutil

            workers = [p for p in psutil.Process().children(recursive=True) if is_worker(p)]
            killed.append(workers[0].pid)
            os.kill(workers[0].pid, signal.SIGKILL)

    (tmp_path / "serial").mkdir()
    there = on_cluster(bench, bench.tasks(range(count)), tmp_path / "dask", watch=kill_one)
    assert killed
    assert (len(there.results), there.is_complete, there.errors) == (count, True, {})
    here = sweep(bench, bench.tasks(range(count)), tmp_path / "serial", executor=serially)
    assert {each.row["error"] for each in here.results} == {""}
    same_rides(here.results, there.results)
    assert not math.isnan(here.results[0].row["path_length"])


def is_worker(process):
    return "spawn_main" in " ".join(process.cmdline())
