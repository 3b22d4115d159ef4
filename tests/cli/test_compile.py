"""Compilation before a ride: the command, and the notice where a ride begins with it."""

import os
import subprocess
import sys

import pytest

from cohelm import kernel_cache
from cohelm.cli import compile_kernels, progress
from cohelm.live import compilation

COMMAND = [sys.executable, "-m", "cohelm"]


@pytest.fixture
def cache(monkeypatch, tmp_path):
    monkeypatch.setattr(kernel_cache, "place", lambda: kernel_cache.Place(tmp_path))
    return tmp_path


def test_code_is_there_once_its_cache_is(cache):
    assert not kernel_cache.is_filled()
    (cache / "control" / "__pycache__").mkdir(parents=True)
    (cache / "control" / "__pycache__" / "qp._solve-94.py311.nbi").write_bytes(b"")
    assert kernel_cache.is_filled()


def test_compiling_is_said_where_there_is_no_terminal_to_show_it(cache, capsys):
    with progress.RideProgress("a ride", 1.0, shown=True):
        pass
    assert progress.COMPILING in capsys.readouterr().err


@pytest.mark.usefixtures("cache")
def test_who_wants_quiet_has_it(capsys):
    with progress.RideProgress("a ride", 1.0, shown=False):
        pass
    assert capsys.readouterr().err == ""


def parts():
    yield "floor"
    yield "world"


@pytest.fixture
def quick(cache, monkeypatch):
    monkeypatch.setattr(compilation, "compile_kernels", parts)
    return cache


def test_compiling_ends_with_the_number_and_the_folder(quick, cohelm):
    code, out, err = cohelm("compile")
    assert (code, err) == (0, "")
    assert out == f"nothing to compile, 0 s; cache: {quick}\n"
    code, out, _ = cohelm("compile")
    assert (code, out) == (0, f"nothing to compile; cache: {quick}\n")


def test_compiling_again_after_a_change(quick, cohelm, monkeypatch):
    cohelm("compile")
    monkeypatch.setenv("NUMBA_CPU_NAME", "another")
    assert "0 s" in cohelm("compile")[1]


def test_another_folder_than_expected_is_named(quick, cohelm, monkeypatch):
    note = "cannot write to the package: compiled code goes elsewhere"
    monkeypatch.setattr(kernel_cache, "place", lambda: kernel_cache.Place(quick, note))
    assert cohelm("compile")[2].strip() == note


def test_nothing_is_compiled_for_a_folder_that_does_not_last(quick, cohelm, monkeypatch):
    place = kernel_cache.Place(quick, "cannot write to A, B: compiled code goes to C", lasts=False)
    monkeypatch.setattr(kernel_cache, "place", lambda: place)
    code, out, err = cohelm("compile")
    assert (code, out) == (2, "")
    assert "NUMBA_CACHE_DIR" in err


def test_progress_counts_kernels_where_there_is_no_terminal(monkeypatch, cache, capsys):
    monkeypatch.setattr(compile_kernels, "INTERVAL", 0.0)
    (cache / "old.nbi").touch()
    os.utime(cache / "old.nbi", (0, 0))
    counted = kernel_cache.CompileProgress()
    with compile_kernels.CompileBar(counted) as shown:
        for k in range(kernel_cache.KERNELS // 2 - 1):
            (cache / f"{k}.nbi").touch()
        shown.enter("world")
    assert counted.kernels == kernel_cache.KERNELS // 2 - 1
    said = capsys.readouterr().err
    assert "50 % (world)" in said
    assert "left" in said


@pytest.mark.slow
def test_a_ride_compiles_nothing_after_compiling(tmp_path):
    script = f"""
import numba.core.event as event
from cohelm.cli.app import status
{{}}
with event.install_recorder("numba:compile") as recorder:
    assert status(["run", "{compilation.RIDE}", "--quiet"]) == 0
names = {{{{each.data["dispatcher"].py_func.__name__ for _, each in recorder.buffer}}}}
print(len(names), sorted(names))
"""
    env = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    compiled = subprocess.run([*COMMAND, "compile"], env=env, check=True, capture_output=True)
    assert b"compiled " in compiled.stdout
    # one signature each, but for small helpers that are called with more than one type
    copies = [
        len(list(index.parent.glob(f"{index.stem}.*.nbc"))) for index in tmp_path.rglob("*.nbi")
    ]
    assert len(copies) > 300
    assert sum(copies) - len(copies) <= 20
    ride = [sys.executable, "-c", script.format("")]
    done = subprocess.run(ride, env=env, check=True, capture_output=True, text=True)
    number = int(done.stdout.splitlines()[-1].split()[0])
    assert number <= 5, done.stdout
