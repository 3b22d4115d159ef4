"""Folder of compiled code: numba needs one that it can write to."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from pathlib import Path

VARIABLE = "NUMBA_CACHE_DIR"
COMPILING = "compiling for this machine, once; it takes a minute or more"


def choose_folder() -> None:
    """Set a temporary cache folder where numba could write to no lasting one.

    numba itself tries the folder of the source, then the user's cache folder. Call this before
    numba is imported.
    """
    if VARIABLE in os.environ or _writable(Path(__file__).parents[1]) or _writable(_cache()):
        return
    folder = tempfile.mkdtemp(prefix="cohelm-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ[VARIABLE] = folder


def is_compiled() -> bool:
    """Check that the local planner's inner loop was compiled for this machine before.

    If not, a ride begins with a minute or more of compilation. Code that has changed since, or
    another version of numba, is not detected.
    """
    own = Path(__file__).parents[1] / "control"
    chosen = os.environ.get(VARIABLE)
    folders = [Path(chosen)] if chosen else [own, _cache() / "numba"]
    return any(next(folder.rglob("qp.*.nbi"), None) is not None for folder in folders)


def _cache() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
