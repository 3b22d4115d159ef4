"""The order of files in a folder."""

from __future__ import annotations

import re
from pathlib import Path


def natural(file: Path) -> list[tuple[int, str]]:
    """A key that sorts names as people do: 2 before 10."""
    parts = re.split(r"([0-9]+)", file.name)
    return [(int(part), "") if k % 2 else (-1, part) for k, part in enumerate(parts)]
