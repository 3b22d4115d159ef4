"""The package of examples/own_planner, installed beside cohelm, is an ordinary planner."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "examples" / "own_planner"
CHECK = """
from cohelm.benchmarks.rides.rides import installed
from cohelm.testing import check_local_planner
from own_planner import GiveWay

check_local_planner(GiveWay(GiveWay.Parameters()))
print(*installed())
"""


def run(folder, *words, **more):
    done = subprocess.run(
        [sys.executable, *words],
        cwd=folder,
        env={**os.environ, "COLUMNS": "200", "PYTHONIOENCODING": "utf-8", **more},
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """What to put before PYTHONPATH: a folder with the package and its entry point."""
    target = tmp_path_factory.mktemp("installed")
    quiet = ("--quiet", "--disable-pip-version-check", "--no-index", "--no-deps")
    install = ("-m", "pip", "install", *quiet, "--no-build-isolation", "--target", str(target))
    run(target, *install, str(PACKAGE))
    return os.pathsep.join(filter(None, (str(target), os.environ.get("PYTHONPATH"))))


def test_it_keeps_its_contract_and_is_among_those_that_every_bench_rides(path, tmp_path):
    said = run(tmp_path, "-W", "error", "-c", CHECK, PYTHONPATH=path)
    assert "give_way" in said.split()


@pytest.mark.slow
def test_it_has_its_row_in_a_bench(path, tmp_path):
    said = run(
        tmp_path,
        *("-c", "from cohelm.cli import main; main()", "bench", "rides", "--scenes", "empty"),
        *("--planners", "give_way", "--seeds", "1", "--workers", "1"),
        *("--set", "time_limit=20", "--out", str(tmp_path / "out")),
        PYTHONPATH=path,
    )
    row = next(line for line in said.splitlines() if "give_way" in line)
    assert "100" in row  # % reached
