"""Where the outside data lies: the folder that the environment's ``COHELM_DATA`` names."""

from __future__ import annotations

import os
from pathlib import Path

VARIABLE = "COHELM_DATA"


def outside_data() -> Path | None:
    """The folder; None where the variable is not set. It need not be there."""
    given = os.environ.get(VARIABLE, "")
    return Path(given) if given else None


def outside_file(*names: str) -> Path | None:
    """A file, or a folder, of the outside data; None where it is absent."""
    folder = outside_data()
    file = None if folder is None else folder.joinpath(*names)
    return file if file is not None and file.exists() else None
