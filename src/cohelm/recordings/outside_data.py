"""Folder of external data, named by the environment variable ``COHELM_DATA``."""

from __future__ import annotations

import os
from pathlib import Path

VARIABLE = "COHELM_DATA"


def outside_data() -> Path | None:
    """The folder, which need not exist; None where the variable is not set."""
    given = os.environ.get(VARIABLE, "")
    return Path(given) if given else None


def outside_file(*names: str) -> Path | None:
    """A file or folder of the external data; None where it is missing."""
    folder = outside_data()
    file = None if folder is None else folder.joinpath(*names)
    return file if file is not None and file.exists() else None
