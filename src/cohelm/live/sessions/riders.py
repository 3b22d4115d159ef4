"""Riders in the data folder: name or number, notes, preset and goals, one file for each.

    DIR/riders/                 0700
      rider-0f3a91c2.json       0600

A rider's id is random: names stand in these files and in exports, and in no path, log, session or
recording. A damaged file is listed as such, never replaced, and can be deleted like any rider.
"""

from __future__ import annotations

import re
import secrets
import threading
import unicodedata
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field, model_validator

from cohelm.config import Model
from cohelm.errors import CohelmError, StoreError
from cohelm.live.messages import Limits, Pace, RiderSettings
from cohelm.live.sessions.files import make_private_folder, write_atomically
from cohelm.live.sessions.session_files import RIDERS, as_json, now_utc, read, remove_file
from cohelm.messages import Mode

RIDER = re.compile(r"rider-[0-9a-f]{8}")
"""Pattern of a rider's id; nothing else becomes part of a path."""
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
    """Rider whose file cannot be read."""

    id: str
    problem: str
    """Sentence with the name of the file."""


class RiderStore:
    """Riders in a data folder; every method may be called from any thread, and waits for the disk.

    Args:
        folder: Data folder; the folder of the riders is created with the first of them.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder / RIDERS
        self._lock = threading.Lock()

    def list(self) -> tuple[tuple[RiderRecord, ...], tuple[DamagedRider, ...]]:
        """Return all riders by name, and those that are damaged."""
        found, damaged = [], []
        for file in sorted(self._folder.glob("*.json")):
            if not RIDER.fullmatch(file.stem):
                continue
            try:
                found.append(self.get(file.stem))
            except StoreError:
                problem = f"The file of this rider (riders/{file.name}) cannot be read."
                damaged.append(DamagedRider(id=file.stem, problem=problem))
        return tuple(sorted(found, key=lambda each: _key(each.name))), tuple(damaged)

    def get(self, rider: str) -> RiderRecord:
        """Return a rider.

        Raises:
            StoreError: There is no such rider, or the file is damaged, which it names.
        """
        record = read(RiderRecord, self._known(rider))
        if record.id != rider:  # a file that was copied by hand
            raise StoreError("has the id of another rider", file=self._file(rider))
        return record

    def name(self, rider: str) -> str:
        """Return the name of a rider; their id if there is none, and empty for no rider."""
        try:
            return self.get(rider).name if rider else ""
        except StoreError:
            return rider

    def check(self, rider: str) -> None:
        """Check that there is a rider, damaged or not.

        Raises:
            StoreError: There is none.
        """
        self._known(rider)

    def create(self, draft: RiderDraft) -> RiderRecord:
        """Store a new rider.

        Raises:
            RiderExists: Another rider has this name.
            StoreError: There are too many, or the folder cannot be written.
        """
        with self._lock:
            self._check_name(draft.name, "")
            make_private_folder(self._folder)
            if sum(1 for _ in self._folder.glob("*.json")) >= MAX_RIDERS:
                raise StoreError(f"holds {MAX_RIDERS} riders; delete some", file=self._folder)
            id_ = f"rider-{secrets.token_hex(4)}"
            while self._file(id_).exists():
                id_ = f"rider-{secrets.token_hex(4)}"
            return self._write(draft, id_, now_utc())

    def change(self, rider: str, draft: RiderDraft) -> RiderRecord:
        """Replace what is stored about a rider.

        Raises:
            RiderExists: Another rider has this name.
            StoreError: There is no such rider, their file is damaged, or it cannot be written.
        """
        with self._lock:
            before = self.get(rider)
            self._check_name(draft.name, rider)
            return self._write(draft, rider, before.created)

    def remove(self, rider: str) -> None:
        """Remove the file of a rider, also a damaged one.

        Raises:
            StoreError: There is no such rider, or the file cannot be removed.
        """
        with self._lock:
            remove_file(self._known(rider))

    def _write(self, draft: RiderDraft, id_: str, created: str) -> RiderRecord:
        content = {**dict(draft), "id": id_, "created": created, "changed": now_utc()}
        record = RiderRecord.model_validate(content)
        write_atomically(self._file(id_), as_json(record))
        return record

    def _check_name(self, name: str, rider: str) -> None:
        others, _ = self.list()
        if any(_key(each.name) == _key(name) and each.id != rider for each in others):
            raise RiderExists("another rider has this name or number")

    def _known(self, rider: str) -> Path:
        if not RIDER.fullmatch(rider) or not self._file(rider).is_file():
            raise StoreError("there is no such rider")
        return self._file(rider)

    def _file(self, rider: str) -> Path:
        return self._folder / f"{rider}.json"


def _key(name: str) -> str:
    """Name without what a reader would not tell apart: case, spaces, and forms of a letter."""
    return unicodedata.normalize("NFKC", "".join(name.split())).casefold()
