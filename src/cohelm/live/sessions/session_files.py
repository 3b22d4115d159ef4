"""Files of sessions: names, reading, and removal of leftovers."""

from __future__ import annotations

import contextlib
import logging
import re
import shutil
import time as clock
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeVar

from cohelm.errors import StoreError
from cohelm.live.sessions.records import RideSummary, SessionInfo

SESSION = re.compile(r"\d{8}-\d{6}(-\d+)?")
"""Pattern of a session's id; nothing else becomes part of a path."""
RIDE = re.compile(r"(\d{8}-\d{6}(?:-\d+)?)-r\d+")
"""Pattern of a ride's id; nothing else becomes part of a path."""
DELETED = ".deleted-"
"""Prefix of the folder of a session that is being deleted."""
_log = logging.getLogger(__name__)
_T = TypeVar("_T", SessionInfo, RideSummary)
_DAY = 86_400.0


def session_sort_key(session: str) -> tuple[str, int]:
    """Return the time and the number in the id of a session."""
    return session[:15], int(session[16:] or 1)


def session_of(ride: str) -> str:
    """Return the id of the session that a ride belongs to."""
    return ride.rpartition("-r")[0]


def rides_in(folder: Path) -> Iterator[RideSummary]:
    """Yield the readable rides of a session, the oldest first; an unreadable one is logged."""
    files = [f for f in folder.glob("*.json") if RIDE.fullmatch(f.stem)]
    for file in sorted(files, key=lambda f: int(f.stem.rpartition("-r")[2])):
        try:
            yield read(RideSummary, file)
        except StoreError as error:
            _log.error("sessions: a ride is not shown: %s", error)


def read(kind: type[_T], file: Path) -> _T:
    """Read a file.

    Raises:
        StoreError: The file is missing or damaged.
    """
    try:
        return kind.model_validate_json(file.read_bytes())
    except (OSError, ValueError):
        raise StoreError("cannot be read", file=file) from None


def as_json(model: SessionInfo | RideSummary) -> bytes:
    """Return the content of a file."""
    return model.model_dump_json(indent=1).encode() + b"\n"


def sweep(folder: Path) -> None:
    """Remove files that a killed program left unfinished.

    Sessions being deleted are removed at once, other files when they are a day old.
    """
    for deleted in folder.glob(f"{DELETED}*"):
        try:
            shutil.rmtree(deleted)
        except OSError as cause:
            _log.error("sessions: %s cannot be deleted (%s)", deleted, cause.strerror or cause)
    for pattern in ("*/*.rows", "*/*.task", "*/.*", "*/*.measures.*"):
        for file in folder.glob(pattern):
            complete = all(file.with_suffix(each).is_file() for each in (".rows", ".task", ".json"))
            if complete:
                continue  # it will be measured now
            with contextlib.suppress(OSError):
                if clock.time() - file.stat().st_mtime > _DAY:
                    file.unlink()


def now_utc() -> str:
    """Return the current time, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")
