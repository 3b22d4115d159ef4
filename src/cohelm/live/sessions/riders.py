"""Riders in the database: name or number, notes, preset and goals.

A rider's id is random: names stand in their records and in exports, and in no path, log, session or
recording. A damaged record is listed as such, never replaced, and can be deleted like any rider.
"""

from __future__ import annotations

import secrets
import threading
import unicodedata
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field, model_validator

from cohelm.config import Model
from cohelm.errors import CohelmError, StoreError
from cohelm.live.messages import Limits, Pace, RiderSettings
from cohelm.live.sessions.database import Database
from cohelm.live.sessions.records import now_utc
from cohelm.messages import Mode

MAX_RIDERS = 500
"""Number of riders that are accepted."""


class RiderExists(CohelmError):
    """Another rider has this name; nothing was changed."""

    code: ClassVar[str] = "rider_exists"


def _text(text: str) -> str:
    """Remove characters that no screen shows; a break of the line stays."""
    kept = "".join(c for c in text if c == "\n" or unicodedata.category(c) not in {"Cc", "Cs"})
    return kept.strip()


def _line(text: str) -> str:
    return " ".join(_text(text.replace("\n", " ")).split())


def _not_empty(text: str) -> str:
    if not any(unicodedata.category(c)[0] not in "CZ" for c in text):  # nothing that is seen
        raise ValueError("a name or a number is missing")
    return text


RiderName = Annotated[str, Field(max_length=80), AfterValidator(_line), AfterValidator(_not_empty)]
Notes = Annotated[str, Field(max_length=2000), AfterValidator(_text)]
GoalText = Annotated[str, Field(max_length=120), AfterValidator(_line)]


class RiderGoal(Model):
    """Goal of a rider: trips that are counted, or own words that the therapist ticks."""

    kind: Literal["arrivals", "unaided", "words"]
    """Counted are trips that arrived, or those that also were driven unaided."""
    target: Annotated[int, Field(ge=1, le=1000)] = 1
    """Number of trips; of a counted goal."""
    text: GoalText = ""
    done: bool = False
    """Ticked by the therapist; of a goal in own words."""

    @model_validator(mode="after")
    def _has_words(self) -> RiderGoal:
        if self.kind == "words" and not self.text:
            raise ValueError("a goal in own words needs some")
        return self


class RiderPreset(Model):
    """Limits and settings that take effect when the rider is chosen."""

    limits: Limits
    settings: RiderSettings = RiderSettings()
    """Stick, switches and setting off."""
    mode: Mode = Mode.SHARED
    pace: Pace = "normal"


class RiderDraft(Model):
    """Content of a rider's form."""

    name: RiderName
    """Name or number; unique, except for case and spaces."""
    notes: Notes = ""
    preset: RiderPreset
    goals: Annotated[tuple[RiderGoal, ...], Field(max_length=8)] = ()


class RiderRecord(RiderDraft):
    """Stored rider."""

    id: str
    created: str
    """ISO 8601, UTC."""
    changed: str
    """ISO 8601, UTC."""


class DamagedRider(Model):
    """Rider whose record cannot be read."""

    id: str
    problem: str
    """Sentence with the id."""


class RiderStore:
    """Riders in a database; every method may be called from any thread, and waits for the disk."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._lock = threading.Lock()

    def list(self) -> tuple[tuple[RiderRecord, ...], tuple[DamagedRider, ...]]:
        """Return all riders by name, and those that are damaged."""
        found, damaged = [], []
        for (rider,) in self._database.rows("SELECT id FROM rider ORDER BY id"):
            try:
                found.append(self.get(rider))
            except StoreError:
                problem = f"The record of this rider ({rider}) cannot be read."
                damaged.append(DamagedRider(id=rider, problem=problem))
        return tuple(sorted(found, key=lambda each: _key(each.name))), tuple(damaged)

    def get(self, rider: str) -> RiderRecord:
        """Return a rider.

        Raises:
            StoreError: There is no such rider, or the record is damaged; then it names the file.
        """
        try:
            return RiderRecord.model_validate_json(self.check(rider))
        except ValueError:
            raise StoreError("cannot be read", file=f"{self._database.file} ({rider})") from None

    def name(self, rider: str) -> str:
        """Return the name of a rider; their id if there is none, and empty for no rider."""
        try:
            return self.get(rider).name if rider else ""
        except StoreError:
            return rider

    def check(self, rider: str) -> str:
        """Return the stored record of a rider, damaged or not.

        Raises:
            StoreError: There is none.
        """
        found = self._database.rows("SELECT record FROM rider WHERE id = ?", rider)
        if not found:
            raise StoreError("there is no such rider")
        return str(found[0][0])

    def create(self, draft: RiderDraft) -> RiderRecord:
        """Store a new rider.

        Raises:
            RiderExists: Another rider has this name.
            StoreError: There are too many, or the database cannot be written.
        """
        with self._lock:
            self._check_name(draft.name, "")
            if len(self._database.rows("SELECT id FROM rider")) >= MAX_RIDERS:
                problem = f"holds {MAX_RIDERS} riders; delete some"
                raise StoreError(problem, file=self._database.file)
            return self._write(draft, f"rider-{secrets.token_hex(4)}", now_utc())

    def change(self, rider: str, draft: RiderDraft) -> RiderRecord:
        """Replace what is stored about a rider.

        Raises:
            RiderExists: Another rider has this name.
            StoreError: There is no such rider, the record is damaged, or it cannot be written.
        """
        with self._lock:
            before = self.get(rider)
            self._check_name(draft.name, rider)
            return self._write(draft, rider, before.created)

    def remove(self, rider: str) -> None:
        """Remove a rider, also a damaged one.

        Raises:
            StoreError: There is no such rider, or the database cannot be written.
        """
        self.check(rider)
        self._database.write("DELETE FROM rider WHERE id = ?", rider)

    def _write(self, draft: RiderDraft, id_: str, created: str) -> RiderRecord:
        content = {**dict(draft), "id": id_, "created": created, "changed": now_utc()}
        record = RiderRecord.model_validate(content)
        text = record.model_dump_json()
        self._database.write("INSERT OR REPLACE INTO rider VALUES (?, ?)", id_, text)
        return record

    def _check_name(self, name: str, rider: str) -> None:
        others, _ = self.list()
        if any(_key(each.name) == _key(name) and each.id != rider for each in others):
            raise RiderExists("another rider has this name or number")


def _key(name: str) -> str:
    """Name without what a reader would not tell apart: case, spaces, and forms of a letter."""
    return unicodedata.normalize("NFKC", "".join(name.split())).casefold()
