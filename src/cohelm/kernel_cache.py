"""Cache of compiled kernels: its folder, and when an entry is valid.

numba caches compiled functions beside their source. Its own rules have gaps, which this module
closes by numba's extension point for cache locators and a subclass of its index files:

- numba validates an entry by the function's file alone, although constants and functions from
  other files are compiled into it. Here the stamp of a kernel covers all that it uses.
- A damaged file, or one that names a class which no longer exists, ends the program. Here such an
  entry is compiled again.
- Two processes that compile at once can exchange each other's data files. Here the name of a data
  file is a hash of its key.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import hashlib
import os
import shutil
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any, NamedTuple

from cohelm.folders import user_folder
from cohelm.numba_setup import MANIFEST, manifest, this_cpu

FOLDER = "NUMBA_CACHE_DIR"
"""Environment variable of numba."""
SOURCE = Path(__file__).parent
KERNELS = 380
"""Number of kernels that a ride with the default parts needs, roughly."""
_SAMPLE = 30
"""Number of kernels from which the time left is estimated."""
_CLOCK = 0.05
"""Delay of the clock that stamps files, s."""


_refusals: list[str] = []


class KernelCacheWarning(UserWarning):
    """Compiled code cannot be kept."""


class Place(NamedTuple):
    """Folder of the cache."""

    folder: Path
    note: str = ""
    """Sentence if it is not the folder that one would expect."""
    lasts: bool = True
    """False: it is deleted when the process ends."""


@functools.cache
def place() -> Place:
    """Root of the cache: the first of these that can be written to.

    ``NUMBA_CACHE_DIR``, the package itself, the user's cache folder, a temporary folder. The
    kernels of a wheel are copied along. If none can be written to, it is the package, which keeps
    nothing.
    """
    chosen, refused = os.environ.get(FOLDER), []
    if chosen:
        if _is_writable(Path(chosen)):
            return Place(Path(chosen) / "cohelm")
        refused.append(f"{chosen} ({FOLDER})")
    if _is_writable(SOURCE):
        return Place(SOURCE, _note(refused, SOURCE) if chosen else "")
    refused.append(str(SOURCE))
    user = user_folder("XDG_CACHE_HOME", ".cache")
    if user is not None and _is_writable(user):
        folder = user / hashlib.sha256(os.fsencode(SOURCE)).hexdigest()[:16]
        return Place(_with_kernels_of_wheel(folder), _note(refused, folder))
    refused.append(str(user or "~/.cache (no home folder)"))
    try:
        temporary = Path(tempfile.mkdtemp(prefix="cohelm-"))
    except OSError:
        return Place(SOURCE, _note(refused, None), lasts=False)
    atexit.register(shutil.rmtree, temporary, ignore_errors=True)
    folder = _with_kernels_of_wheel(temporary / "cohelm")
    return Place(folder, _note(refused, folder), lasts=False)


def _note(refused: list[str], folder: Path | None) -> str:
    result = f"goes to {folder}" if folder else "is not kept"
    return f"cannot write to {', '.join(refused)}: compiled code {result}"


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _with_kernels_of_wheel(folder: Path) -> Path:
    """Copy the kernels of a wheel to a cache folder, once for each version of it."""
    try:
        text = (SOURCE / MANIFEST).read_bytes()
    except OSError:
        return folder
    folder = folder.with_name(f"{folder.name}-{hashlib.sha256(text).hexdigest()[:8]}")
    if folder.is_dir():
        return folder
    copy = folder
    try:
        copy = Path(tempfile.mkdtemp(dir=folder.parent))
        for file in (SOURCE / MANIFEST, *SOURCE.rglob("*.nb[ci]")):
            target = copy / file.relative_to(SOURCE)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)
        copy.rename(folder)
    except OSError:  # another process was faster, or the disk is full
        shutil.rmtree(copy, ignore_errors=True)
    return folder


def is_complete() -> bool:
    """Check that :func:`mark_complete` was called with the present :func:`state`."""
    try:
        return (place().folder / MANIFEST).read_text(encoding="utf-8") == state()
    except OSError:
        return False


def mark_complete(compiled: str) -> None:
    """Note that every kernel is in the cache that a ride needs, in this :func:`state`."""
    place().folder.mkdir(parents=True, exist_ok=True)
    (place().folder / MANIFEST).write_text(compiled, encoding="utf-8")


def state() -> str:
    """Return the manifest for which this process compiles, and a hash of all code."""
    hashed = hashlib.sha256()
    for file in sorted(SOURCE.rglob("*.py")):
        hashed.update(str(file.relative_to(SOURCE)).encode() + file.read_bytes())
    return manifest(this_cpu()) + hashed.hexdigest() + "\n"


def unsaved() -> str:
    """Reason why a kernel of this process could not be saved; empty: all were."""
    return _refusals[0] if _refusals else ""


def is_filled(package: str = "control") -> bool:
    """Check that kernels of a package are cached; by default some of the local planner.

    Kernels that have changed since, or that another numba compiled, are not detected.
    """
    return any((place().folder / package).rglob("*.nbi"))


def share() -> float:
    """Number of kernels in the cache, as a share of those that a ride may need; may exceed 1."""
    return len(_stamps()) / KERNELS


def _stamps() -> list[float]:
    return [file.stat().st_mtime for file in place().folder.rglob("*.nbi")]


class CompileProgress:
    """Progress of whatever processes compile, by the files of the cache."""

    def __init__(self) -> None:
        self._began = time.time()
        self._before, self._first = len(_stamps()), 0.0

    @property
    def seconds(self) -> float:
        """Time since the beginning, s."""
        return time.time() - self._began

    @property
    def kernels(self) -> int:
        """Number of kernels compiled since the beginning."""
        return sum(each >= self._began - _CLOCK for each in _stamps())

    def estimate(self) -> tuple[float, float | None]:
        """Share of all kernels that is there, 0…0.99, and the time left, s; None: not known yet."""
        known = len(_stamps())
        new = known - self._before
        self._first = self._first if new and self._first else self.seconds
        spent = self.seconds - self._first
        left = spent * max(KERNELS - known, 1) / new if new > _SAMPLE else None
        return min(known / KERNELS, 0.99), left


class KernelLocator:
    """numba's cache locator for kernels of cohelm; all other functions get numba's own.

    Args:
        py_func: The function to be compiled.
        py_file: Its source file.
    """

    def __init__(self, py_func: Any, py_file: str) -> None:
        self._py_file = py_file  # numba's warnings name it
        self._function = py_func

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Any:
        """Return a locator, or None where numba has none either."""
        from numba.core import caching  # noqa: PLC0415 # loaded already, by numba itself

        if Path(py_file).is_relative_to(SOURCE):
            _install_index_files(caching)
            return cls(py_func, py_file)
        own: Any = caching.CacheImpl._locator_classes
        found = (each.from_function(py_func, py_file) for each in own)
        return next((each for each in found if each is not None), None)

    def ensure_cache_path(self) -> None:
        """Create the folder; if that fails, saving says so."""
        with contextlib.suppress(OSError):
            Path(self.get_cache_path()).mkdir(parents=True, exist_ok=True)

    def get_cache_path(self) -> str:
        """Folder of the cached file."""
        return str(place().folder / Path(self._py_file).parent.relative_to(SOURCE) / "__pycache__")

    def get_source_stamp(self) -> Stamp:
        """Stamp that changes with anything that is compiled into the function."""
        return Stamp(self._function, _content(self._py_file))

    def get_disambiguator(self) -> str:
        """Line, which separates functions of the same name in one file."""
        return str(self._function.__code__.co_firstlineno)


class Stamp:
    """Fingerprint of a kernel, computed when it is needed: by then its module is complete.

    Pickled, it becomes a string. Equal to a string that is the same fingerprint.
    """

    def __init__(self, function: Any, source: bytes) -> None:
        self._function, self._source = function, source

    @functools.cached_property
    def text(self) -> str:
        """The fingerprint, with the source file as it was imported."""
        return hashlib.sha256(self._source + fingerprint(self._function).encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        return self.text == (other.text if isinstance(other, Stamp) else other)

    def __hash__(self) -> int:
        return hash(self.text)

    def __reduce__(self) -> tuple[type[str], tuple[str]]:
        return str, (self.text,)


def fingerprint(function: Any) -> str:
    """Hash of a function's code, of its constants, and of all kernels that it calls."""
    hashed = hashlib.sha256()
    _add_function(hashed.update, function, [])
    return hashed.hexdigest()


@functools.cache
def _content(file: str) -> bytes:
    """Hash of a source file, at the first kernel that is defined in it."""
    return hashlib.sha256(Path(file).read_bytes()).digest()


def _add_function(add: Any, function: Any, seen: list[Any]) -> None:
    if function in seen:  # recursion, or a helper that is called twice
        add(b"%d" % seen.index(function))
        return
    seen.append(function)
    names = _add_code(add, function.__code__)
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    for each in (*(function.__defaults__ or ()), *cells):
        _add_value(add, each, names, seen)
    for name in names:
        if name in function.__globals__:
            add(name.encode())
            _add_value(add, function.__globals__[name], names, seen)


def _add_code(add: Any, code: Any) -> list[str]:
    """Add bytecode and constants; returns the global names and attributes in them."""
    names = list(code.co_names)
    add(code.co_code)
    for constant in code.co_consts:
        if hasattr(constant, "co_code"):
            names += _add_code(add, constant)
        else:
            add(repr(constant).encode())
    return sorted(set(names))


def _add_value(add: Any, value: Any, names: list[str], seen: list[Any]) -> None:
    """Add a value that numba compiles into a function as a constant."""
    own = getattr(value, "__module__", "") or ""
    if hasattr(value, "py_func"):  # another kernel, with the options it is compiled with
        add(repr(sorted(value.targetoptions.items(), key=str)).encode())
        _add_function(add, value.py_func, seen)
    elif isinstance(value, type):
        add(f"{own}.{value.__qualname__} {getattr(value, '_fields', '')}".encode())
    elif hasattr(value, "tobytes"):
        add(f"{value.dtype}{value.shape}".encode() + value.tobytes())
    elif isinstance(value, tuple):
        for each in value:
            _add_value(add, each, names, seen)
    elif isinstance(value, int | float | str | bytes | None):
        add(repr(value).encode())
    elif hasattr(value, "__path__") or hasattr(value, "__spec__"):
        _add_module(add, value, names, seen)
    else:  # a function of numpy or Python
        add(f"{own}.{getattr(value, '__qualname__', type(value).__qualname__)}".encode())


def _add_module(add: Any, module: Any, names: list[str], seen: list[Any]) -> None:
    """Add what a function may use of a module of cohelm; numba's version covers other modules."""
    add(module.__name__.encode())
    for name in names if module.__name__.startswith("cohelm.") else ():
        if hasattr(module, name):
            _add_value(add, getattr(module, name), names, seen)


def _refuse(folder: str, error: OSError) -> None:
    """Warn, once in a process, that compiled code is not kept."""
    if not _refusals:
        _refusals.append(f"cannot write to {folder} ({error.strerror or error})")
        warnings.warn(
            f"{_refusals[0]}: compiled code is not kept, and every start compiles again",
            KernelCacheWarning,
            stacklevel=2,
        )


def _install_index_files(caching: Any) -> None:
    """Replace numba's class of index files, once."""
    base = caching.IndexDataCacheFile
    if base.__module__ == __name__:
        return

    class KernelFiles(base):  # type: ignore[misc,valid-type]  # untyped, and found at run time
        """Index and data files of one function that may be damaged, and shared by processes."""

        def save(self, key: Any, data: Any) -> None:
            """Save data first, so that no index names a file that does not exist.

            A kernel that cannot be saved, as on a full disk, is still used by this process.
            """
            try:
                self._save(key, data)
            except OSError as error:
                _refuse(self._cache_path, error)

        def _save(self, key: Any, data: Any) -> None:
            overloads = self._load_index()
            text = f"{getattr(self._source_stamp, 'text', self._source_stamp)!r} {key!r}"
            number = int.from_bytes(hashlib.sha256(text.encode()).digest()[:6])
            overloads[key] = name = self._data_name(number)
            self._save_data(name, data)
            self._save_index(overloads)
            self._remove_outdated(set(overloads.values()))

        def _remove_outdated(self, kept: set[str]) -> None:
            place = Path(self._cache_path)
            for file in place.glob(self._index_name.removesuffix("nbi") + "*.nbc"):
                if file.name not in kept:
                    file.unlink(missing_ok=True)

        def _load_index(self) -> Any:
            try:
                return super()._load_index()
            except Exception:  # damaged, or made by other code: as if there were none
                return {}

        def _load_data(self, name: str) -> Any:
            try:
                return super()._load_data(name)
            except Exception as error:  # numba takes an OSError for a missing file
                raise OSError(f"{name} is damaged: {error}") from error

    caching.IndexDataCacheFile = KernelFiles
