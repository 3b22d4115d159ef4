"""Compilation before a ride: the command, and the notice where a ride begins with it."""

import numba
import pytest

from cohelm import kernel_cache
from cohelm.cli import compile_kernels, progress
from cohelm.live import compilation


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


def test_kernels_are_counted_as_they_are_compiled():
    numbers = []
    with compilation.Compilations(numbers.append).listening() as compiled:

        @numba.njit
        def inner(x):
            return x + 1

        @numba.njit
        def outer(x):
            return inner(x)

        inner.py_func.__module__ = outer.py_func.__module__ = "cohelm.somewhere"
        outer(1)
    assert numbers == [1, 2]
    assert compiled.number == 2
    assert compiled.seconds > 0.0


def test_progress_is_printed_where_there_is_no_terminal(monkeypatch, capsys):
    monkeypatch.setattr(compile_kernels, "INTERVAL", 0.0)
    with compile_kernels._Progress() as shown:
        shown.enter("world")
        shown.count(63)
    assert "compiling 63 of about" in capsys.readouterr().err
