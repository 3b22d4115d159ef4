"""The cache of compiled kernels: when an entry is used, and what is compiled again."""

import errno
import os
import pickle
import pwd
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from numba import njit
from numba.core import caching

from cohelm import kernel_cache, numba_setup
from cohelm.errors import ConfigError
from cohelm.geometry import nearest_on_polyline
from cohelm.kernel_cache import KernelLocator, Stamp, fingerprint
from cohelm.live.sessions.records import default_folder

LIMIT = 2.0
TABLE = np.array([1.0, 2.0])


@njit
def inner(x):
    return x + LIMIT


@njit
def other(x):
    return x - LIMIT


@njit(fastmath=True)
def inner_fast(x):
    return x + LIMIT


def outer(x):
    return inner(x) + TABLE[0]


def looping(x):
    return looping(x - 1) if x > 0 else 0


def changed(monkeypatch, name, value):
    before = fingerprint(outer)
    monkeypatch.setitem(outer.__globals__, name, value)
    return fingerprint(outer) != before


def test_a_fingerprint_stays_the_same():
    assert fingerprint(outer) == fingerprint(outer)


@pytest.mark.parametrize(
    ("name", "value"),
    [("LIMIT", 3.0), ("TABLE", np.array([1.0, 3.0])), ("inner", other), ("inner", inner_fast)],
)
def test_a_fingerprint_covers_constants_and_called_kernels(monkeypatch, name, value):
    assert changed(monkeypatch, name, value)


def test_a_fingerprint_ignores_what_is_not_used(monkeypatch):
    assert not changed(monkeypatch, "other", inner)


def test_a_recursive_kernel_has_a_fingerprint():
    assert fingerprint(looping) != fingerprint(outer)


def test_a_stamp_becomes_a_string():
    stamp = Stamp(outer, b"source")
    text = pickle.loads(pickle.dumps(stamp))
    assert text == stamp
    assert text != Stamp(outer, b"another source")


@pytest.fixture
def files(tmp_path):
    kernel_cache._install_index_files(caching)
    return lambda stamp="1": caching.IndexDataCacheFile(str(tmp_path), "f-1.py311", stamp)


def test_an_entry_is_found_again(files):
    files().save("key", "code")
    assert files().load("key") == "code"
    assert files().load("another key") is None


def test_an_entry_with_another_stamp_is_not_used_and_removed(files, tmp_path):
    files().save("key", "old")
    assert files("2").load("key") is None
    files("2").save("key", "new")
    assert files("2").load("key") == "new"
    assert len(list(tmp_path.glob("*.nbc"))) == 1


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("content", [b"", b"\x80", b"ccohelm.no_module\nClass\n."])
def test_a_damaged_entry_is_as_good_as_none(files, tmp_path, suffix, content):
    files().save("key", "code")
    for file in tmp_path.glob(f"*.{suffix}"):
        kept = file.read_bytes()
        version = kept[: kept.index(b".", 12) + 1] if suffix == "nbi" and content else b""
        file.write_bytes(version + content)
    assert files().load("key") is None
    files().save("key", "again")
    assert files().load("key") == "again"


def test_processes_that_save_at_once_do_not_exchange_their_code(files):
    one, two = files(), files()
    index = one._load_index()
    one.save("a", "code of a")
    two._load_index = lambda: dict(index)  # read before the other one wrote
    two.save("b", "code of b")
    assert files().load("b") == "code of b"
    assert files().load("a") in {None, "code of a"}


def test_kernels_of_cohelm_use_this_cache_and_others_numbas_own(tmp_path):
    cache = nearest_on_polyline._cache
    assert isinstance(cache._impl.locator, KernelLocator)
    assert Path(cache.cache_path).is_relative_to(kernel_cache.place().folder)
    elsewhere = tmp_path / "elsewhere.py"
    elsewhere.touch()
    assert not isinstance(KernelLocator.from_function(outer, str(elsewhere)), KernelLocator)


@pytest.fixture
def fresh_place():
    kernel_cache.place.cache_clear()
    yield kernel_cache.place
    kernel_cache.place.cache_clear()


def test_the_cache_lies_where_it_can_be_written(monkeypatch, tmp_path, fresh_place):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv(kernel_cache.FOLDER, str(tmp_path / "chosen"))
    assert fresh_place() == kernel_cache.Place(tmp_path / "chosen" / "cohelm")

    fresh_place.cache_clear()
    monkeypatch.delenv(kernel_cache.FOLDER)
    assert fresh_place().folder == kernel_cache.SOURCE

    fresh_place.cache_clear()
    user = tmp_path / "cohelm"
    user.mkdir()
    monkeypatch.setattr(kernel_cache, "_is_writable", lambda folder: folder == user)
    assert fresh_place().folder.parent == user
    assert str(kernel_cache.SOURCE) in fresh_place().note

    fresh_place.cache_clear()
    monkeypatch.setattr(kernel_cache, "_is_writable", lambda folder: False)
    assert not fresh_place().lasts
    assert os.access(fresh_place().folder.parent, os.W_OK)


def test_kernels_of_a_wheel_are_copied_where_the_package_is_read_only(
    monkeypatch, tmp_path, fresh_place
):
    package, user = tmp_path / "package", tmp_path / "cohelm"
    (package / "maps").mkdir(parents=True)
    (package / "maps" / "f.nbi").write_bytes(b"index")
    (package / numba_setup.MANIFEST).write_text("made for this machine")
    user.mkdir()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv(kernel_cache.FOLDER, raising=False)
    monkeypatch.setattr(kernel_cache, "SOURCE", package)
    monkeypatch.setattr(kernel_cache, "_is_writable", lambda folder: folder == user)
    assert (fresh_place().folder / "maps" / "f.nbi").read_bytes() == b"index"
    fresh_place.cache_clear()
    assert kernel_cache.is_filled("maps")


@pytest.mark.parametrize(
    ("made_for", "is_v3", "matches"),
    [(None, True, False), ("python 2, …", True, False), ("", True, True), ("", False, False)],
)
def test_kernels_of_a_wheel_are_used_only_where_they_match(
    monkeypatch, tmp_path, made_for, is_v3, matches
):
    manifest = tmp_path / numba_setup.MANIFEST
    if made_for is not None:
        manifest.write_text(made_for or numba_setup.manifest(numba_setup.CPU))
    monkeypatch.setattr(numba_setup, "__file__", str(tmp_path / "numba_setup.py"))
    monkeypatch.setattr(numba_setup, "_is_v3", lambda: is_v3)
    assert numba_setup.has_matching_kernels() == matches


def test_a_cache_is_complete_for_this_code_and_cpu(monkeypatch, tmp_path):
    monkeypatch.setattr(kernel_cache, "place", lambda: kernel_cache.Place(tmp_path / "cohelm"))
    assert not kernel_cache.is_complete()
    kernel_cache.mark_complete(kernel_cache.state())
    assert kernel_cache.is_complete()
    monkeypatch.setenv(numba_setup.CPU_NAME, "another")
    assert not kernel_cache.is_complete()


def test_importing_cohelm_loads_no_large_library():
    code = "import cohelm, sys; print(*{'numba', 'numpy', 'pydantic'}.intersection(sys.modules))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).split() == []


@pytest.fixture
def homeless(monkeypatch):
    """A process without HOME, of a user id that the password file does not know."""
    for name in ("HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME", kernel_cache.FOLDER):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(pwd, "getpwuid", lambda uid: {}[uid])


def test_without_a_home_folder_the_cache_is_temporary(monkeypatch, fresh_place, homeless):
    monkeypatch.setattr(kernel_cache, "_is_writable", lambda folder: False)
    assert not fresh_place().lasts
    assert "no home folder" in fresh_place().note


def test_without_any_folder_nothing_is_kept(monkeypatch, fresh_place, homeless):
    monkeypatch.setattr(kernel_cache, "_is_writable", lambda folder: False)
    monkeypatch.setattr(tempfile, "mkdtemp", refuse)
    assert not fresh_place().lasts
    assert "compiled code is not kept" in fresh_place().note


def test_without_a_home_folder_files_of_sessions_name_a_remedy(homeless):
    with pytest.raises(ConfigError, match="set HOME or XDG_DATA_HOME"):
        default_folder()


def refuse(*_, **__):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize("step", ["_save_data", "_save_index", "_remove_outdated", "_load_index"])
def test_a_kernel_that_cannot_be_saved_is_used_and_told_once(files, monkeypatch, step):
    monkeypatch.setattr(kernel_cache, "_refusals", [])
    full = files()
    monkeypatch.setattr(full, step, refuse)
    with pytest.warns(kernel_cache.KernelCacheWarning, match="No space left") as told:
        _ = [full.save(key, "code") for key in ("key", "another key")]
    assert len(told) == 1
    assert "No space left" in kernel_cache.unsaved()
    assert files().load("key") in {None, "code"}


def test_kernels_of_a_wheel_are_done_without_on_a_full_disk(monkeypatch, tmp_path):
    (tmp_path / numba_setup.MANIFEST).write_text("made for this machine")
    monkeypatch.setattr(kernel_cache, "SOURCE", tmp_path)
    monkeypatch.setattr(shutil, "copyfile", refuse)
    user = tmp_path / "user"
    user.mkdir()
    kernel_cache._with_kernels_of_wheel(user / "kernels")
    assert list(user.iterdir()) == []
