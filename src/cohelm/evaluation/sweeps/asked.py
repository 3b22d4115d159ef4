"""How much a sweep was to do, kept beside its results: who reads a part knows that it is one."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

ASKED = "asked.json"


@dataclass(frozen=True)
class Asked:
    """How much was asked for when a sweep was begun, or gone on with, last."""

    tasks: int
    rides: int
    """In the tasks, where they are of rides."""


def write_asked(asked: Asked, folder: Path) -> None:
    """Keep it in the folder, in place of what was asked for before.

    Raises:
        OSError: if it cannot be written.
    """
    beside = folder / f"{ASKED}.part"
    try:
        beside.write_text(json.dumps(asdict(asked)) + "\n", encoding="utf-8")
        beside.replace(folder / ASKED)
    finally:
        beside.unlink(missing_ok=True)


def read_asked(folder: Path) -> Asked | None:
    """What was asked for last; None where nothing says it that can be read."""
    try:
        said = json.loads((folder / ASKED).read_text(encoding="utf-8"))
        return Asked(tasks=int(said["tasks"]), rides=int(said["rides"]))
    except (OSError, ValueError, LookupError, TypeError):
        return None
