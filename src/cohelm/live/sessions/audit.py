"""Audit log of who did what and when, append-only.

It outlives the sessions: deleting them is itself an entry. It keeps the newest
:data:`MAX_ENTRIES`; an entry counts the loss.
"""

from __future__ import annotations

import contextlib
import logging
import queue
import threading
import time
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, Protocol

from cohelm.config import Model
from cohelm.errors import StoreError
from cohelm.live.sessions.database import Database

AuditEvent = Literal[
    "drive_started", "drive_closed", "signed_in", "sign_in_rejected", "signed_out", "connected",
    "disconnected", "control_taken", "control_released", "stop_pressed", "resumed",
    "limits_changed", "limits_rejected", "rider_settings_changed", "mode_changed", "pace_changed",
    "goal_changed", "simulation_changed", "simulation_restarted", "navigator_lost", "rejected",
    "edges_allowed", "storey_changed", "sessions_deleted", "session_exported", "rider_created",
    "rider_changed", "rider_chosen", "rider_exported", "rider_deleted", "response_reset",
    "entries_dropped",
]  # fmt: skip
"""Stable names of events."""
MAX_ENTRIES = 100_000
"""Number of entries that are kept: some 10 MB."""
MAX_QUEUED_ENTRIES = 10_000
"""Maximum number of entries that wait for the disk; further ones are counted as lost."""
RETRY_PERIOD = 5.0
"""Time between two attempts to write after a failure, s."""
_log = logging.getLogger(__name__)


_RATE_LIMITED = frozenset(
    {"connected", "disconnected", "control_taken", "control_released", "stop_pressed", "resumed",
     "mode_changed", "pace_changed", "goal_changed", "simulation_changed", "rejected",
     "sign_in_rejected"}
)  # fmt: skip
"""Events that a driver can cause at any rate; they must not displace the therapist's entries."""
BURST = 2000.0
"""Number of rate-limited events of one kind that are accepted at once."""
REFILL_RATE = 0.1
"""Number of rate-limited events of one kind that are accepted in the long run, 1/s."""


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
    """Audit log in a data folder; :meth:`log_event` never waits for the disk, in any thread.

    Args:
        folder: Created if it is missing.

    Raises:
        StoreError: The folder cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self._database = Database(folder)
        self._lock = threading.Lock()
        self._error = ""
        self._dropped_count = 0
        self._token_buckets: dict[str, tuple[float, float]] = {}
        """Tokens, and the time at which they were counted, s, by event."""
        self._queue: queue.Queue[AuditEntry | None] = queue.Queue(MAX_QUEUED_ENTRIES)
        self._append([])
        self._writer = threading.Thread(target=self._write, name="audit", daemon=True)
        self._writer.start()

    def log_event(self, actor: str, event: AuditEvent, **details: Any) -> None:
        """Add an entry with the current time.

        Args:
            actor: See :attr:`AuditEntry.actor`.
            event: See :data:`AuditEvent`.
            details: JSON values; others are stored as text.
        """
        if event in _RATE_LIMITED and not self._accepts(event):
            return
        entry = AuditEntry(time=_now(), actor=actor, event=event, details=details)
        try:
            self._queue.put_nowait(entry)
        except queue.Full:
            with self._lock:
                self._dropped_count += 1

    def _accepts(self, event: AuditEvent) -> bool:
        """Check the rate limit of an event; beyond it the event is counted as lost."""
        now = time.monotonic()
        with self._lock:
            tokens, at = self._token_buckets.get(event, (BURST, now))
            tokens = min(BURST, tokens + REFILL_RATE * (now - at))
            self._token_buckets[event] = (tokens - 1.0 if tokens >= 1.0 else tokens, now)
            self._dropped_count += tokens < 1.0
            return tokens >= 1.0

    def entries(self, most: int = 1000) -> tuple[AuditEntry, ...]:
        """Return the newest entries, newest first; damaged ones are skipped."""
        self.wait_until_idle()
        out = []
        query = "SELECT entry FROM audit ORDER BY number DESC LIMIT ?"
        for (text,) in self._database.rows(query, most):
            with contextlib.suppress(ValueError):
                out.append(AuditEntry.model_validate_json(text))
        return tuple(out)

    def wait_until_idle(self) -> None:
        """Wait until all entries so far are on disk, or have failed."""
        self._queue.join()

    def close(self) -> None:
        """Write the waiting entries and close."""
        if self._writer.is_alive():
            self._queue.put(None)
            self._writer.join()

    @property
    def error(self) -> str:
        """Reason why the last entries could not be written; empty if they were."""
        return self._error

    def _write(self) -> None:
        """Write all waiting entries at once, in the writer thread."""
        open_ = True
        while open_:
            batch = self._next_entries()
            open_ = not batch or batch[-1] is not None
            try:
                self._append([each for each in batch if each is not None])
                self._error = ""
            except StoreError as error:
                if not self._error:  # once, not at every attempt
                    _log.error("the audit log cannot be written: %s", error)
                self._error = error.problem
                with self._lock:
                    self._dropped_count += sum(each is not None for each in batch)
            finally:
                for _ in batch:
                    self._queue.task_done()

    def _next_entries(self) -> list[AuditEntry | None]:
        """Wait for entries; none after ``RETRY_PERIOD`` if the count of lost ones is to be written.

        So that the error ends once there is space, and not only with the next event.
        """
        try:
            batch = [self._queue.get(timeout=RETRY_PERIOD if self._error else None)]
        except queue.Empty:
            return []
        while not self._queue.empty():
            batch.append(self._queue.get_nowait())
        return batch

    def _append(self, entries: list[AuditEntry]) -> None:
        with self._lock:
            dropped = self._dropped_count
        with self._database.transaction() as database:
            (size,) = database.execute("SELECT COUNT(*) FROM audit").fetchone()
            excess = size + len(entries) + bool(dropped) - MAX_ENTRIES
            if excess > 0:  # a tenth at once, so that few entries count the loss
                excess = min(excess + MAX_ENTRIES // 10, size)
                database.execute(
                    "DELETE FROM audit WHERE number IN "
                    "(SELECT number FROM audit ORDER BY number LIMIT ?)",
                    (excess,),
                )
            lost = dropped + max(excess, 0)
            if lost:
                counted = AuditEntry(
                    time=_now(), actor="chair", event="entries_dropped", details={"count": lost}
                )
                entries = [counted, *entries]
            # Values that JSON cannot hold become text.
            database.executemany(
                "INSERT INTO audit (entry) VALUES (?)",
                [(each.model_dump_json(fallback=str),) for each in entries],
            )
        with self._lock:
            self._dropped_count -= dropped


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
