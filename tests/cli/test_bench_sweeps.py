"""``cohelm bench``: folders that have results, going on, what failed and what was killed."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from cohelm.cli import bench, progress
from cohelm.cli.bench import BenchRequest
from cohelm.cli.bench_commands import BENCHES, command_of
from cohelm.errors import ConfigError
from cohelm.evaluation.sweeps.store import read_records
from cohelm.evaluation.sweeps.tasks import SweepState

COMMON = ("--seeds", "--first", "--workers", "--out", "--resume", "--overwrite", "--cluster")


def run(folder, name="toy", **changes):
    return bench.bench(name, "toy_bench", BenchRequest(out=folder, **changes))


def summary(folder):
    return json.loads((folder / "summary.json").read_text())


def without_rows_of_time(folder):
    return {k: v for k, v in summary(folder).items() if k != "versions"}


@pytest.mark.parametrize("name", BENCHES)
def test_every_benchmark_has_the_common_options(name):
    known = {option for each in command_of(name, *BENCHES[name]).params for option in each.opts}
    assert set(COMMON) <= known


def test_results_are_neither_mixed_nor_lost_in_silence(toys, tmp_path, capsys):
    assert run(tmp_path, seeds=3) == 0
    before = {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
    with pytest.raises(ConfigError, match=r"has results; --resume .* --overwrite"):
        run(tmp_path, seeds=3)
    with pytest.raises(ConfigError, match="other options"):
        run(tmp_path, seeds=4, resume=True, options={"takes": 0.001})
    with pytest.raises(ConfigError, match="'cohelm bench toy'"):
        run(tmp_path, name="rides", resume=True)
    with pytest.raises(ConfigError, match="--resume: cannot be combined"):
        run(tmp_path, resume=True, overwrite=True)
    assert before == {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
    (tmp_path / "mine.txt").write_text("stays")
    assert run(tmp_path, seeds=2, overwrite=True) == 0
    assert len(summary(tmp_path)["rows"]) == 4
    assert (tmp_path / "mine.txt").exists()


def test_a_first_run_may_say_resume_and_a_later_one_ask_for_more(toys, tmp_path, capsys):
    assert run(tmp_path / "part", seeds=2, resume=True) == 0
    assert run(tmp_path / "part", seeds=5, resume=True) == 0
    assert run(tmp_path / "whole", seeds=5) == 0
    assert without_rows_of_time(tmp_path / "part") == without_rows_of_time(tmp_path / "whole")


def test_what_failed_is_told_and_the_rest_reported(toys, tmp_path, capsys):
    assert run(tmp_path, options={"fails": [(1, "raises"), (4, "raises")]}) == 1
    out = capsys.readouterr().out
    assert "FAILED: 1 of 6 tasks, first task 1: ZeroDivisionError: no task 1" in out
    found = summary(tmp_path)
    assert found["complete"]
    assert [each["task"] for each in found["failures"]] == [1, 4]
    assert "in work" in found["failures"][0]["traceback"]
    assert len(found["rows"]) == 8


def test_where_everything_failed_there_is_no_report(toys, tmp_path, capsys):
    assert run(tmp_path, seeds=1, options={"fails": [(0, "raises")]}) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "FAILED: 1 of 1 tasks" in captured.err


def test_a_report_that_nothing_comes_of_leaves_the_rows(toys, tmp_path, capsys, monkeypatch):
    import toy_bench

    def report(self, results, folder):
        raise ZeroDivisionError("too few")

    monkeypatch.setattr(toy_bench.Toy, "report", report)
    assert run(tmp_path, options={"fails": [(1, "raises")]}) == 1
    assert "too few results for a report" in capsys.readouterr().err
    assert len(read_records(tmp_path)) == 6
    with pytest.raises(ZeroDivisionError):  # of the whole it is a fault of ours
        run(tmp_path / "whole")


def test_progress_is_lines_where_there_is_no_terminal(monkeypatch, capsys):
    monkeypatch.setattr(progress, "LINE_INTERVAL", -1.0)
    with progress.SweepProgress("toy") as bar:
        bar(SweepState(0, 100, 0.0))
        bar(SweepState(10, 100, 20.0, failed=2))
        bar(SweepState(10, 10_000, 20.0))
    assert capsys.readouterr().err.splitlines() == [
        "toy: 0 of 100, compiling and simulating …",
        "toy: 10 of 100, about 3 min left, 2 failed",
        "toy: 10 of 10000, about 5.5 h left",
    ]


# ---------------------------------------------------------------------------- killed


COMMAND = """
import sys, pathlib
from cohelm.cli import bench
given = dict(out=pathlib.Path(sys.argv[1]), seeds=40, workers=int(sys.argv[2]),
             cluster=sys.argv[3] or None, resume=True, options={"takes": 0.05})
if __name__ == "__main__":
    sys.exit(bench.bench("toy", "toy_bench", bench.BenchRequest(**given)))
"""


@pytest.fixture
def command(toys, tmp_path):
    """Begins the sweep of a toy as a command of its own, in a group of its own."""
    (tmp_path / "run.py").write_text(COMMAND)
    begun = []

    def _command(folder, workers=1, cluster=""):
        folder.mkdir(exist_ok=True)
        words = [sys.executable, tmp_path / "run.py", folder, workers, cluster]
        process = subprocess.Popen(
            [str(each) for each in words],
            env={**os.environ, "PYTHONPATH": os.pathsep.join([str(toys), *sys.path])},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        begun.append(process)
        return process

    yield _command
    for each in begun:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(each.pid, signal.SIGKILL)
        each.communicate()


def stored(folder):
    try:
        return len(read_records(folder))
    except ConfigError:  # it has not begun
        return 0


def wait_for(folder, count, process):
    until = time.monotonic() + 300.0
    while stored(folder) < count:
        assert process.poll() is None
        assert time.monotonic() < until
        time.sleep(0.02)


def is_alone(process):
    """Whether nobody of the group is left within a minute of its end."""
    for _ in range(600):
        try:
            os.killpg(process.pid, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


@pytest.mark.slow
def test_a_sweep_that_is_killed_and_gone_on_with_gives_the_same(command, tmp_path, capsys):
    killed = command(tmp_path / "part")
    wait_for(tmp_path / "part", 5, killed)
    killed.kill()
    killed.wait()
    assert 5 <= len(read_records(tmp_path / "part")) < 40
    options = {"takes": 0.05}
    assert run(tmp_path / "part", seeds=40, resume=True, options=options) == 0
    assert run(tmp_path / "whole", seeds=40, options=options) == 0
    assert without_rows_of_time(tmp_path / "part") == without_rows_of_time(tmp_path / "whole")
    rows = [(tmp_path / name / "rows.csv").read_bytes() for name in ("part", "whole")]
    assert rows[0] == rows[1]


@pytest.mark.slow
@pytest.mark.parametrize(("workers", "cluster"), [(1, ""), (2, ""), (2, "local")])
def test_an_interrupt_leaves_what_is_done_and_no_process(command, tmp_path, workers, cluster):
    folder = tmp_path / "out"
    process = command(folder, workers, cluster)
    wait_for(folder, 5, process)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: everyone hears it
    out, err = process.communicate(timeout=300.0)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    found = summary(folder)
    assert not found["complete"]
    done, total = found["tasks"]["done"], found["tasks"]["total"]
    assert f"interrupted after {done} of {total} tasks" in out
    assert len(read_records(folder)) == done < total
    assert len(found["rows"]) == 2 * len(read_records(folder))
    assert is_alone(process)


@pytest.mark.slow
@pytest.mark.parametrize(("workers", "cluster"), [(2, ""), (2, "local")])
def test_processes_of_a_sweep_that_was_killed_end(command, tmp_path, workers, cluster):
    folder = tmp_path / "out"
    process = command(folder, workers, cluster)
    wait_for(folder, 5, process)
    process.kill()
    process.wait()
    assert is_alone(process)
    assert len(read_records(folder)) >= 5
