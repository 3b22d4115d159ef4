"""Where compiled code is kept: numba refuses to work where it can write nowhere."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from pathlib import Path

VARIABLE = "NUMBA_CACHE_DIR"
COMPILING = "compiling for this machine, once; it takes a minute or more"


def place() -> None:
    """Name a folder that lasts as long as this command where no lasting one can be written.

    numba itself looks beside the source, then in the user's cache folder. To be called before numba
    is imported.
    """
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
    if VARIABLE in os.environ or _takes_files(Path(__file__).parents[1]) or _takes_files(cache):
        return
    folder = tempfile.mkdtemp(prefix="cohelm-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ[VARIABLE] = folder


def is_there() -> bool:
    """Whether the local planner's inner loop has been compiled for this machine before.

    Where it has not, a ride begins with a minute or more of compiling. Code that has changed since,
    or another numba, is not noticed.
    """
    own = Path(__file__).parents[1] / "control"
    kept = os.environ.get(VARIABLE)
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()) / "numba"
    places = [Path(kept)] if kept else [own, home]
    return any(next(place.rglob("quadratic.*.nbi"), None) is not None for place in places)


def _takes_files(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
