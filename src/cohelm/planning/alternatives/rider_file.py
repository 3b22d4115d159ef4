"""File of a rider's choices: one small JSON file per rider, to be read, copied and deleted.

The file holds every choice with the routes that were shown, and the weights learned from them. It
is replaced as a whole, so an interruption leaves the old one or the new one; the previous file is
kept as ``NAME.json.bak``. An unreadable file is never overwritten.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import unicodedata
from pathlib import Path
from typing import Any, Literal, TypeVar

from cohelm.config import Model, nearest, validate
from cohelm.errors import ConfigError
from cohelm.folders import data_folder
from cohelm.planning.alternatives.learned_preference import (
    MIN_CHOICES,
    FeatureVector,
    RouteChoice,
    describe_preference,
    learn_weights,
)

_NAME = re.compile(r"\w[\w .'-]{0,62}(?<![ .])")
_LONGEST = 64
"""Maximum length of a name, characters."""

_M = TypeVar("_M", bound=Model)


class RiderChoices(Model):
    """Choices of a rider, and the weights learned from them."""

    version: Literal[1] = 1
    """Version of the file's format."""
    name: str
    """Name of the rider."""
    choices: tuple[RouteChoice, ...] = ()
    """Choices in the order of time."""
    weights: FeatureVector | None = None
    """Learned from the choices; None if there are too few."""

    def with_choice(self, choice: RouteChoice) -> RiderChoices:
        """Add a choice and learn the weights again."""
        choices = (*self.choices, choice)
        return self.model_copy(update={"choices": choices, "weights": learn_weights(choices)})

    def sentence(self) -> str:
        """Describe the rider's preference in a sentence."""
        made = _count(len(self.choices), "choice")
        if self.weights is None:
            return f"{self.name} has made {made}; learning begins at {MIN_CHOICES} choices"
        liked = describe_preference(self.weights)
        return f"{self.name} prefers {', '.join(liked[:3])} ({made})"


class ShownRoutes(Model):
    """Routes of the last proposal, until one of them is reported as taken."""

    version: Literal[1] = 1
    """Version of the file's format."""
    where: str
    """Map, start and goal, for the reader."""
    routes: tuple[FeatureVector, ...]
    """Routes in the order shown."""


def riders_folder() -> Path:
    """Folder of the riders' files: ``$XDG_DATA_HOME/cohelm/riders``."""
    return data_folder("riders")


def rider_names() -> tuple[str, ...]:
    """Names of the riders with a file; none without a home folder."""
    try:
        return tuple(sorted(file.stem for file in riders_folder().glob("*.json")))
    except ConfigError:
        return ()


def rider_file(name_or_file: str) -> Path:
    """File of a rider, which need not exist yet.

    Args:
        name_or_file: a name, or a file, which ends in ``.json``.

    Raises:
        ConfigError: if the name is not possible for a file.
    """
    if name_or_file.endswith(".json"):
        return Path(name_or_file)
    # Marks belong to the letters of many scripts.
    letters = "".join(each for each in name_or_file if unicodedata.category(each)[0] != "M")
    if not _NAME.fullmatch(letters) or len(name_or_file) > _LONGEST:
        raise ConfigError(
            f"{name_or_file!r} cannot be the name of a rider: take letters, digits, spaces and "
            "-_.', at most 64, or name a .json file",
            key="--rider",
        )
    return riders_folder() / f"{name_or_file}.json"


def read_rider(file: Path) -> RiderChoices | None:
    """Read a rider's file; None if there is none.

    Raises:
        ConfigError: if the file is not readable; with the problem and a remedy.
    """
    return _read(RiderChoices, file)


def known_rider(name_or_file: str) -> RiderChoices:
    """Read the file of a rider that must exist.

    Raises:
        ConfigError: if there is none of that name; with the most similar name, or all names.
    """
    file = rider_file(name_or_file)
    rider = read_rider(file)
    if rider is None:
        known = nearest(name_or_file, rider_names()) or f" ({file} is not there)"
        raise ConfigError(f"no rider is called {name_or_file!r}{known}", key="--rider")
    return rider


def write_rider(rider: RiderChoices, file: Path) -> None:
    """Replace the rider's file, and keep the previous one as ``NAME.json.bak``.

    Raises:
        ConfigError: if the present file is not readable, or the new one cannot be written.
    """
    read_rider(file)  # an unreadable file is not overwritten
    _write(rider, file)


def forget_rider(name_or_file: str) -> Path:
    """Remove a rider's file, readable or not, and the last proposal.

    Returns:
        The backup of the file; a damaged one does not take the place of a good backup.

    Raises:
        ConfigError: if there is none, or it cannot be moved.
    """
    file = rider_file(name_or_file)
    if not file.is_file():
        known_rider(name_or_file)  # raises with the known names
    kept = _backup(file)
    try:
        read_rider(file)
    except ConfigError:
        if kept.exists():
            kept = file.with_name(f"{file.name}.damaged")
    try:
        file.replace(kept)
        shown_file(file).unlink(missing_ok=True)
    except OSError as cause:
        raise _not_written(file, cause) from None
    return kept


def shown_file(file: Path) -> Path:
    """File of the last proposal, beside a rider's file."""
    return file.with_suffix(".shown")


def read_shown_routes(file: Path) -> ShownRoutes | None:
    """Read the last proposal to the rider with this file; None if it was answered or none was made.

    Raises:
        ConfigError: if it is not readable.
    """
    return _read(ShownRoutes, shown_file(file))


def write_shown_routes(shown: ShownRoutes | None, file: Path) -> None:
    """Write the proposal to the rider with this file; None: remove it.

    Raises:
        ConfigError: if it cannot be written.
    """
    if shown is not None:
        _write(shown, shown_file(file), keep=False)
        return
    try:
        shown_file(file).unlink(missing_ok=True)
    except OSError as cause:
        raise _not_written(shown_file(file), cause) from None


def _read(model: type[_M], file: Path) -> _M | None:
    try:
        data: Any = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except RecursionError:
        raise _unreadable(file, "is nested too deeply") from None
    except (OSError, ValueError) as cause:  # ValueError: not UTF-8, or not JSON
        what = getattr(cause, "strerror", None) or f"is not what cohelm wrote: {cause}"
        raise _unreadable(file, what) from None
    if not isinstance(data, dict):
        raise _unreadable(file, "is not what cohelm wrote: no JSON object")
    try:
        return validate(model, data, file=file)
    except ConfigError as cause:
        raise _unreadable(file, f"{cause.key}: {cause.problem}") from None


def _unreadable(file: Path, what: str) -> ConfigError:
    kept = _backup(file)
    last = f"; the one before it is {kept.name}" if kept.exists() else ""
    return ConfigError(
        f"{what}; repair it, or restart with 'cohelm preferences reset --rider {file}'{last}",
        file=file,
    )


def _write(data: Model, file: Path, *, keep: bool = True) -> None:
    """Write a new file and replace the old one with it; links are followed."""
    file = file.resolve()
    new = file.with_name(f".{file.name}.{os.getpid()}.new")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with new.open("w", encoding="utf-8") as stream:
            stream.write(data.model_dump_json(indent=2) + "\n")
            stream.flush()
            os.fsync(stream.fileno())
        if keep and file.exists():
            shutil.copyfile(file, _backup(file))
        new.replace(file)
    except OSError as cause:
        new.unlink(missing_ok=True)
        raise _not_written(file, cause) from None


def _backup(file: Path) -> Path:
    return file.with_name(f"{file.name}.bak")


def _not_written(file: Path, cause: OSError) -> ConfigError:
    return ConfigError(f"cannot be written ({cause.strerror or cause})", file=file)


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
