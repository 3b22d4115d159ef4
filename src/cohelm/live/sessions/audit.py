"""Audit log of who did what and when: one JSON object a line, append-only.

It outlives the sessions: deleting them is itself an entry. Its size is bounded: a full file is
renamed with a number, and the oldest of :data:`FILES` is removed; an entry counts what was lost.
"""

from __future__ import annotations

import json
import logging
import os
import queue
import threading
import time
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, Protocol

from cohelm.config import Model
from cohelm.errors import StoreError
from cohelm.live.sessions.files import own_folder, unwritable

AuditEvent = Literal[
    "drive_started", "drive_closed", "signed_in", "sign_in_rejected", "signed_out", "connected",
    "disconnected", "control_taken", "control_released", "stop_pressed", "resumed",
    "limits_changed", "limits_rejected", "rider_settings_changed", "mode_changed", "pace_changed",
    "goal_changed", "simulation_changed", "simulation_restarted", "navigator_lost", "rejected",
    "sessions_deleted", "session_exported", "entries_dropped",
]  # fmt: skip
"""Stable names of events."""
LARGEST = 1_000_000
"""Maximum size of one file, bytes."""
FILES = 10
"""Number of files, the present one included: 10 MB."""
WAITING = 10_000
"""Maximum number of entries that wait for the disk; further ones are counted as lost."""
_log = logging.getLogger(__name__)


_RATE_LIMITED = frozenset(
    {"connected", "disconnected", "control_taken", "control_released", "stop_pressed", "resumed",
     "mode_changed", "pace_changed", "goal_changed", "simulation_changed", "rejected",
     "sign_in_rejected"}
)  # fmt: skip
"""Events that a driver can cause as often as they like …"""
AT_ONCE = 2000.0
"""… of which this many of a kind are accepted at once …"""
LASTING = 0.1
"""… and this many a second in the long run: they must not displace the therapist's entries."""


class LogEvent(Protocol):
    """Adds an entry to the audit log."""

    def __call__(self, actor: str, event: AuditEvent, **details: Any) -> None:
        """See :meth:`AuditLog.log_event`."""
        ...


class AuditEntry(Model):
    """Entry of the audit log."""

    time: str
    """ISO 8601, UTC."""
    actor: str
    """Connection, ``therapist``, or ``chair``."""
    event: AuditEvent
    details: Mapping[str, Any] = {}
    """Limits before and after, a mode, an address."""


class AuditLog:
    """Audit log in a folder; :meth:`log_event` never waits for the disk, in any thread.

    Args:
        folder: Created where it is missing.

    Raises:
        StoreError: The folder cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self.file = own_folder(folder) / "audit.jsonl"
        self._lock = threading.Lock()
        self._error = ""
        self._lost = 0
        self._allowance: dict[str, tuple[float, float]] = {}
        self._waiting: queue.Queue[AuditEntry | None] = queue.Queue(WAITING)
        self._append([])
        self._writer = threading.Thread(target=self._write, name="audit", daemon=True)
        self._writer.start()

    def log_event(self, actor: str, event: AuditEvent, **details: Any) -> None:
        """Add an entry with the present time.

        Args:
            actor: See :attr:`AuditEntry.actor`.
            event: See :data:`AuditEvent`.
            details: JSON values; others are stored as text.
        """
        if event in _RATE_LIMITED and not self._accepts(event):
            return
        entry = AuditEntry(time=_now(), actor=actor, event=event, details=details)
        try:
            self._waiting.put_nowait(entry)
        except queue.Full:
            with self._lock:
                self._lost += 1

    def _accepts(self, event: AuditEvent) -> bool:
        """Check the rate limit of an event; beyond it the event is counted as lost."""
        now = time.monotonic()
        with self._lock:
            left, at = self._allowance.get(event, (AT_ONCE, now))
            left = min(AT_ONCE, left + LASTING * (now - at))
            self._allowance[event] = (left - 1.0 if left >= 1.0 else left, now)
            self._lost += left < 1.0
            return left >= 1.0

    def entries(self, most: int = 1000) -> tuple[AuditEntry, ...]:
        """Return the newest entries, newest first; damaged lines are skipped."""
        self.settle()
        out: list[AuditEntry] = []
        for file in (self.file, *(self._file(k) for k in range(1, FILES))):
            if len(out) >= most or not file.is_file():
                break
            out += _read(file, most - len(out))
        return tuple(out)

    def settle(self) -> None:
        """Wait until all entries so far are on disk, or have failed."""
        self._waiting.join()

    def close(self) -> None:
        """Write the waiting entries and close."""
        if self._writer.is_alive():
            self._waiting.put(None)
            self._writer.join()

    @property
    def error(self) -> str:
        """Reason why the last entries could not be written; empty where they are."""
        return self._error

    def _write(self) -> None:
        """Write all waiting entries at once, in the writer thread."""
        going = True
        while going:
            batch = [self._waiting.get()]
            while not self._waiting.empty():
                batch.append(self._waiting.get_nowait())
            going = batch[-1] is not None
            try:
                self._append([each for each in batch if each is not None])
                self._error = ""
            except StoreError as fault:
                if not self._error:  # once, not at every attempt
                    _log.error("the audit log cannot be written: %s", fault)
                self._error = str(fault)
                with self._lock:
                    self._lost += sum(each is not None for each in batch)
            finally:
                for _ in batch:
                    self._waiting.task_done()

    def _append(self, entries: list[AuditEntry]) -> None:
        with self._lock:
            if self._lost and entries:
                entries = [_dropped(self._lost), *entries]
            lines = _lines(entries)
            try:
                if self.file.is_file() and self.file.stat().st_size + len(lines) > LARGEST:
                    gone = self._rotate()
                    lines = (_lines([_dropped(gone)]) if gone else b"") + lines
                self._put(lines)
            except OSError as cause:
                raise unwritable(self.file, cause) from None
            self._lost = 0 if entries else self._lost

    def _put(self, lines: bytes) -> None:
        """Append lines; after an incomplete line, of a crash or a full disk, begin a new one."""
        handle = os.open(self.file, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o600)
        try:
            size = os.fstat(handle).st_size
            if lines and size and os.pread(handle, 1, size - 1) != b"\n":
                lines = b"\n" + lines
            while lines:
                lines = lines[os.write(handle, lines) :]
            os.fsync(handle)
        finally:
            os.close(handle)

    def _rotate(self) -> int:
        """Rotate the files and return the number of entries that were removed."""
        oldest = self._file(FILES - 1)
        gone = len(oldest.read_bytes().splitlines()) if oldest.is_file() else 0
        for k in range(FILES - 1, 0, -1):
            if self._file(k - 1).is_file():
                self._file(k - 1).replace(self._file(k))
        return gone

    def _file(self, number: int) -> Path:
        return self.file if number == 0 else self.file.with_name(f"audit.{number}.jsonl")


def _dropped(count: int) -> AuditEntry:
    return AuditEntry(time=_now(), actor="chair", event="entries_dropped", details={"count": count})


def _lines(entries: list[AuditEntry]) -> bytes:
    """One line for each entry; values that JSON cannot hold become text."""
    return "".join(f"{each.model_dump_json(fallback=str)}\n" for each in entries).encode()


def _read(file: Path, most: int) -> list[AuditEntry]:
    """Return the last ``most`` entries of a file, the last first."""
    out: list[AuditEntry] = []
    for line in reversed(file.read_text(encoding="utf-8", errors="replace").splitlines()):
        if len(out) == most:
            break
        try:
            out.append(AuditEntry.model_validate(json.loads(line)))
        except ValueError:
            continue
    return out


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
