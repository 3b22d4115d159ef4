"""The files of sessions: what they are called, how they read, and which are left over."""

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

from cohelm.driving.records import RideRecord, SessionFacts
from cohelm.errors import StoreError

SESSION = re.compile(r"\d{8}-\d{6}(-\d+)?")
RIDE = re.compile(r"(\d{8}-\d{6}(?:-\d+)?)-r\d+")
"""What ids look like; nothing else becomes part of a path."""
DELETED = ".deleted-"
"""How the folder of a session that is being deleted begins."""
_log = logging.getLogger(__name__)
_T = TypeVar("_T", SessionFacts, RideRecord)
_DAY = 86_400.0


def age(session: str) -> tuple[str, int]:
    """By which sessions are in order."""
    return session[:15], int(session[16:] or 1)


def rides_in(folder: Path) -> Iterator[RideRecord]:
    """The rides of a session that can be read, the oldest first."""
    files = [f for f in folder.glob("*.json") if RIDE.fullmatch(f.stem)]
    for file in sorted(files, key=lambda f: int(f.stem.rpartition("-r")[2])):
        with contextlib.suppress(StoreError):
            yield read(RideRecord, file)


def read(kind: type[_T], file: Path) -> _T:
    """What a file holds.

    Raises:
        StoreError: if it is not there, or is damaged.
    """
    try:
        return kind.model_validate_json(file.read_bytes())
    except (OSError, ValueError):
        raise StoreError("does not read", file=file) from None


def as_json(model: SessionFacts | RideRecord) -> bytes:
    """What a file is to hold."""
    return model.model_dump_json(indent=1).encode() + b"\n"


def sweep(folder: Path) -> None:
    """Remove what a program that was killed left half done.

    What was being deleted goes at once, all else when it is a day old.
    """
    for deleted in folder.glob(f"{DELETED}*"):
        try:
            shutil.rmtree(deleted)
        except OSError as cause:
            _log.error("sessions: %s is not deleted (%s)", deleted, cause.strerror or cause)
    for pattern in ("*/*.rows", "*/*.task", "*/.*", "*/*.measures.*"):
        for file in folder.glob(pattern):
            whole = all(file.with_suffix(each).is_file() for each in (".rows", ".task", ".json"))
            if whole:
                continue  # it is measured now
            with contextlib.suppress(OSError):
                if clock.time() - file.stat().st_mtime > _DAY:
                    file.unlink()


def now_utc() -> str:
    """ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")
