"""Who did what, and when: one JSON object a line, only ever appended to.

It outlives the sessions' data: deleting that is itself an entry. Its size is bounded: a full file
is set aside under a number, and the oldest of :data:`FILES` goes; an entry says how many went.
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
from typing import Any, Literal

from cohelm.config import Model
from cohelm.driving.files import own_folder, unwritable
from cohelm.errors import StoreError

What = Literal[
    "started", "closed", "signed_in", "sign_in_refused", "signed_out", "joined", "left",
    "took", "released", "stop", "resume", "limits", "limits_refused", "rider", "mode", "pace",
    "goal", "simulated", "restarted", "navigator_lost", "refused", "deleted", "exported",
    "dropped",
]  # fmt: skip
"""What happened; stable words."""
LARGEST = 1_000_000
"""Bytes of one file at most."""
FILES = 10
"""Files kept, the one that is written included: 10 MB."""
WAITING = 10_000
"""Entries that wait for the disk at most; what comes then is counted and said."""
_log = logging.getLogger(__name__)


_ANYBODYS = frozenset(
    {"joined", "left", "took", "released", "stop", "resume", "mode", "pace", "goal", "simulated",
     "refused", "sign_in_refused"}
)  # fmt: skip
"""What whoever may drive can cause as often as they like …"""
AT_ONCE = 2000.0
"""… of which so many of a kind are kept at once …"""
LASTING = 0.1
"""… and in the long run so many a second: what the therapist did is not flushed out by them."""


class Entry(Model):
    """One line."""

    at: str
    """ISO 8601, UTC."""
    who: str
    """A connection, ``therapist``, or ``chair``."""
    what: What
    said: Mapping[str, Any] = {}
    """What belongs to it: the limits before and after, a mode, an address."""


class Audit:
    """The log in a folder. :meth:`note` never waits for the disk, and may be called anywhere.

    Args:
        folder: where; made where it is missing.

    Raises:
        StoreError: if it cannot be written to.
    """

    def __init__(self, folder: Path) -> None:
        self.file = own_folder(folder) / "audit.jsonl"
        self._lock = threading.Lock()
        self._trouble = ""
        self._lost = 0
        self._room: dict[str, tuple[float, float]] = {}
        self._waiting: queue.Queue[Entry | None] = queue.Queue(WAITING)
        self._append([])
        self._writer = threading.Thread(target=self._write, name="audit", daemon=True)
        self._writer.start()

    def note(self, who: str, what: What, **said: Any) -> None:
        """One more entry, of now.

        Args:
            who: see :attr:`Entry.who`.
            what: see :data:`What`.
            said: what JSON can say.
        """
        if what in _ANYBODYS and not self._bears(what):
            return
        entry = Entry(at=_now(), who=who, what=what, said=said)
        try:
            self._waiting.put_nowait(entry)
        except queue.Full:
            with self._lock:
                self._lost += 1

    def _bears(self, what: What) -> bool:
        """Whether there is room for one more of this kind; else it is counted as lost."""
        now = time.monotonic()
        with self._lock:
            left, at = self._room.get(what, (AT_ONCE, now))
            left = min(AT_ONCE, left + LASTING * (now - at))
            self._room[what] = (left - 1.0 if left >= 1.0 else left, now)
            self._lost += left < 1.0
            return left >= 1.0

    def entries(self, most: int = 1000) -> tuple[Entry, ...]:
        """The newest, newest first; a line that is damaged is left out."""
        self.settle()
        out: list[Entry] = []
        for file in (self.file, *(self._aside(k) for k in range(1, FILES))):
            if len(out) >= most or not file.is_file():
                break
            out += _read(file, most - len(out))
        return tuple(out)

    def settle(self) -> None:
        """Wait until everything noted so far is on the disk, or could not be written."""
        self._waiting.join()

    def close(self) -> None:
        """Write what waits, and nothing more."""
        if self._writer.is_alive():
            self._waiting.put(None)
            self._writer.join()

    @property
    def trouble(self) -> str:
        """Why the last entries could not be written; empty: they are."""
        return self._trouble

    def _write(self) -> None:
        """Of the writer's thread: all that waits at once, then the disk."""
        going = True
        while going:
            batch = [self._waiting.get()]
            while not self._waiting.empty():
                batch.append(self._waiting.get_nowait())
            going = batch[-1] is not None
            try:
                self._append([each for each in batch if each is not None])
                self._trouble = ""
            except StoreError as fault:
                if not self._trouble:  # said once, and not at every try
                    _log.error("what is done is not logged: %s", fault)
                self._trouble = str(fault)
                with self._lock:
                    self._lost += sum(each is not None for each in batch)
            finally:
                for _ in batch:
                    self._waiting.task_done()

    def _append(self, entries: list[Entry]) -> None:
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
        """Append; where the last program or a full disk left half a line, on a line of its own."""
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
        """Make room; how many entries went for it."""
        oldest = self._aside(FILES - 1)
        gone = len(oldest.read_bytes().splitlines()) if oldest.is_file() else 0
        for k in range(FILES - 1, 0, -1):
            if self._aside(k - 1).is_file():
                self._aside(k - 1).replace(self._aside(k))
        return gone

    def _aside(self, number: int) -> Path:
        return self.file if number == 0 else self.file.with_name(f"audit.{number}.jsonl")


def _dropped(count: int) -> Entry:
    return Entry(at=_now(), who="chair", what="dropped", said={"count": count})


def _lines(entries: list[Entry]) -> bytes:
    """A line each; what JSON cannot say is said as text."""
    return "".join(f"{each.model_dump_json(fallback=str)}\n" for each in entries).encode()


def _read(file: Path, most: int) -> list[Entry]:
    """The last ``most`` of a file, the last first."""
    out: list[Entry] = []
    for line in reversed(file.read_text(encoding="utf-8", errors="replace").splitlines()):
        if len(out) == most:
            break
        try:
            out.append(Entry.model_validate(json.loads(line)))
        except ValueError:
            continue
    return out


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
