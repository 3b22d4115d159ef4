"""Whether code is compiled already: said before a ride that begins with a minute of compiling."""

import pytest

from cohelm import kernel_cache
from cohelm.cli import progress


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
