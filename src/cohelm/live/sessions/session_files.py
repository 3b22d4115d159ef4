"""Files of sessions: names, reading, and removal of leftovers."""

from __future__ import annotations

import contextlib
import itertools
import logging
import re
import shutil
import time
from collections.abc import Iterable, Iterator, Set
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeVar

from cohelm.config import Model
from cohelm.errors import StoreError
from cohelm.live.sessions.files import write_atomically
from cohelm.live.sessions.records import RideLog, RideSummary, SessionInfo
from cohelm.platforms import is_simulated
from cohelm.scenarios.build import RideSetup

SESSION = re.compile(r"[0-9]{8}-[0-9]{6}(-[0-9]+)?")
"""Pattern of a session's id; nothing else becomes part of a path."""
RIDE = re.compile(r"([0-9]{8}-[0-9]{6}(?:-[0-9]+)?)-r[0-9]+")
"""Pattern of a ride's id; nothing else becomes part of a path."""
RIDERS = "riders"
"""Name of the folder of the riders in the data folder."""
DELETED = ".deleted-"
"""Prefix of the folder of a session that is being deleted."""
_DELETED = re.compile(rf"{re.escape(DELETED)}[0-9]+-{SESSION.pattern}")
_LEFTOVER = re.compile(r"\.probe|\..+\.[a-z0-9_]{8}")
"""Names of files that a killed program leaves in the folder of a session."""
_log = logging.getLogger(__name__)
_T = TypeVar("_T", bound=Model)
_DAY = 86_400.0


def session_sort_key(session: str) -> tuple[str, int]:
    """Return the time and the number in the id of a session."""
    return session[:15], int(session[16:] or 1)


def session_of(ride: str) -> str:
    """Return the id of the session that a ride belongs to."""
    return ride.rpartition("-r")[0]


def create_session(root: Path, used: Set[str], info: SessionInfo) -> SessionInfo:
    """Create the folder of a new session, named by the local time, and store its properties.

    Args:
        root: Folder of all sessions.
        used: Ids not to be used again: of deleted sessions, whose last ride may still be written.
        info: Properties without an id.

    Returns:
        The properties with the id.

    Raises:
        StoreError: The session cannot be written; no folder is left.
    """
    folder = _new_folder(root, used)
    opened = info.model_copy(update={"id": folder.name})
    try:
        write_atomically(folder / "session.json", as_json(opened))
    except StoreError:
        remove_empty_session(folder)
        raise
    return opened


def _new_folder(root: Path, used: Set[str]) -> Path:
    stamp = datetime.now(UTC).astimezone().strftime("%Y%m%d-%H%M%S")
    for number in itertools.count(1):
        id_ = stamp if number == 1 else f"{stamp}-{number}"
        if id_ in used:
            continue
        try:
            (root / id_).mkdir(mode=0o700)
        except FileExistsError:
            continue
        except OSError as cause:
            raise StoreError(f"cannot be created ({cause.strerror})", file=root) from None
        return root / id_
    raise AssertionError  # the numbers do not end


def mark_deleted(folders: Iterable[Path]) -> None:
    """Rename the folders of sessions, so that no later call finds them.

    Raises:
        StoreError: One cannot be renamed.
    """
    number = time.time_ns()  # a unique name for each deletion
    for folder in folders:
        try:
            folder.rename(folder.with_name(f"{DELETED}{number}-{folder.name}"))
        except OSError as cause:
            raise not_deleted(folder, cause) from None


def remove_deleted(root: Path) -> None:
    """Remove all folders that were marked as deleted, also by earlier runs.

    Raises:
        StoreError: One cannot be removed.
    """
    for folder in _deleted(root):
        _remove(folder)


def rides_in(folder: Path) -> Iterator[RideSummary]:
    """Yield the rides of a session, the oldest first; one whose record is damaged says so."""
    files = [f for f in folder.glob("*.json") if RIDE.fullmatch(f.stem)]
    for file in sorted(files, key=lambda f: int(f.stem.rpartition("-r")[2])):
        try:
            yield read(RideSummary, file)
        except StoreError as error:
            _log.error("sessions: a ride is damaged: %s", error)
            yield unknown_ride(file.stem, f"The record of this ride ({file.name}) cannot be read.")


def unknown_ride(ride: str, error: str) -> RideSummary:
    """Return the summary of a ride of which only the id can be read."""
    return RideSummary(
        id=ride,
        session=session_of(ride),
        started=_started(ride),
        seed=0,
        destination="",
        outcome="cancelled",
        duration=0.0,
        length=0.0,
        error=error,
    )


def session_info(ride_setup: RideSetup, rider: str) -> SessionInfo:
    """Return the properties of a session that begins now and has no id so far."""
    return SessionInfo(
        id="",
        started=now_utc(),
        scene=ride_setup.scenario.name,
        robot=ride_setup.robot.name,
        simulation=is_simulated(ride_setup.scenario),
        rider=rider,
    )


def unknown_session(session: str) -> SessionInfo:
    """Return the properties of a session of which only the id can be read."""
    scene = "unknown (session.json cannot be read)"
    return SessionInfo(id=session, started=_started(session), scene=scene, robot="unknown")


def read(kind: type[_T], file: Path) -> _T:
    """Read a file.

    Raises:
        StoreError: The file is missing or damaged.
    """
    try:
        return kind.model_validate_json(file.read_bytes())
    except (OSError, ValueError):
        raise StoreError("cannot be read", file=file) from None


def as_json(model: Model) -> bytes:
    """Return the content of a file."""
    return model.model_dump_json(indent=1).encode() + b"\n"


def sweep(folder: Path) -> None:
    """Remove temporary files that a killed program left; logs of rides are never removed.

    Sessions being deleted and empty folders are removed at once, other files when they are a day
    old. The folder may hold files of others, as a home does: only own names are touched.
    """
    for deleted in _deleted(folder):
        try:
            _remove(deleted)
        except StoreError as error:
            _log.error("sessions: %s", error)
    sessions = [each for each in folder.glob("*") if SESSION.fullmatch(each.name)]
    for session in sessions:
        with contextlib.suppress(OSError):  # only an empty one can be removed
            session.rmdir()
    for own in [*sessions, folder / RIDERS]:
        for name in [*_names(own)]:
            if _LEFTOVER.fullmatch(name):
                with contextlib.suppress(OSError):
                    if time.time() - (own / name).stat().st_mtime > _DAY:
                        (own / name).unlink()


def _deleted(root: Path) -> list[Path]:
    """Folders of sessions that are being deleted."""
    return [each for each in root.glob(f"{DELETED}*") if _DELETED.fullmatch(each.name)]


def now_utc() -> str:
    """Return the current time, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def not_deleted(folder: Path, cause: OSError) -> StoreError:
    """Return the error for a folder that cannot be deleted."""
    return StoreError(f"cannot be deleted ({cause.strerror or cause})", file=folder)


def remove_file(file: Path) -> None:
    """Remove a file, if it exists.

    Raises:
        StoreError: It cannot be removed.
    """
    try:
        file.unlink(missing_ok=True)
    except OSError as cause:
        raise not_deleted(file, cause) from None


def remove_empty_session(folder: Path) -> None:
    """Remove the folder of a session without a ride."""
    if {*_names(folder)} <= {"session.json"}:
        shutil.rmtree(folder, ignore_errors=True)


def text_of_lost_rows(log: RideLog) -> str:
    """Return the error of a ride some rows of which could not be written; empty: none is lost."""
    if not log.lost_rows:
        return ""
    return f"{log.lost_rows} ticks of this ride, {log.lost_rows * log.step:.1f} s, are not stored."


def _names(folder: Path) -> Iterator[str]:
    """Yield the names of all files in a folder; none if it is missing."""
    with contextlib.suppress(OSError):
        yield from (file.name for file in folder.iterdir())


def _remove(folder: Path) -> None:
    try:
        shutil.rmtree(folder)
    except OSError as cause:
        raise not_deleted(folder, cause) from None


def _started(id_: str) -> str:
    """Time in an id, ISO 8601; that of 1970 if there was no such time."""
    try:
        begun = datetime.strptime(id_[:15], "%Y%m%d-%H%M%S").astimezone()
    except (ValueError, OverflowError):
        begun = datetime.fromtimestamp(0.0, UTC)
    return begun.isoformat(timespec="seconds")
