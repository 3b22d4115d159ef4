"""What a rider has chosen so far: one small file per rider, to be read, copied and thrown away.

The file is JSON: every choice with the routes that were shown, and the weights learned from them.
It is replaced as a whole, so that an interruption leaves the old one or the new one; the one before
is kept beside it as ``NAME.json.bak``. A file that does not read is never written over.
"""

from __future__ import annotations

import json
import os
import re
import shutil
from pathlib import Path
from typing import Any, Literal, TypeVar

from cohelm.config import Model, nearest, validate
from cohelm.errors import ConfigError
from cohelm.planning.learned import LEAST_CHOICES, Choice, Liking, habits, learn

_NAME = re.compile(r"\w[\w .'-]{0,62}(?<![ .])")

_M = TypeVar("_M", bound=Model)


class Rider(Model):
    """A rider's choices, and what was learned from them."""

    version: Literal[1] = 1
    """Of the file's form."""
    name: str
    """Whom to speak of."""
    choices: tuple[Choice, ...] = ()
    """In the order made."""
    weights: Liking | None = None
    """Learned from the choices, see ``cohelm.planning.learned``; None while they are too few."""

    def with_choice(self, choice: Choice) -> Rider:
        """The rider with one more choice made, and the weights learned anew."""
        choices = (*self.choices, choice)
        return self.model_copy(update={"choices": choices, "weights": learn(choices)})

    def sentence(self) -> str:
        """What is known of the rider."""
        made = _count(len(self.choices), "choice")
        if self.weights is None:
            return f"{self.name} has made {made}; from {LEAST_CHOICES} on they are learned from"
        liked = habits(self.weights)
        return f"the {made} of {self.name} speak for {', '.join(liked[:3])}"


class Shown(Model):
    """The routes that were proposed last, until one of them is said to be the one taken."""

    version: Literal[1] = 1
    """Of the file's form."""
    where: str
    """Map, start and goal, for the reader."""
    routes: tuple[Liking, ...]
    """In the order shown."""


def riders_folder() -> Path:
    """Where the files of riders are: ``$XDG_DATA_HOME/cohelm/riders``."""
    data = os.environ.get("XDG_DATA_HOME", "")
    root = Path(data) if Path(data).is_absolute() else Path.home() / ".local" / "share"
    return root / "cohelm" / "riders"


def rider_names() -> tuple[str, ...]:
    """The riders there are files of."""
    return tuple(sorted(file.stem for file in riders_folder().glob("*.json")))


def rider_file(name_or_file: str) -> Path:
    """The file of a rider, which need not be there yet.

    Args:
        name_or_file: a name, or a file, which ends in ``.json``.

    Raises:
        ConfigError: if the name cannot be that of a file.
    """
    if name_or_file.endswith(".json"):
        return Path(name_or_file)
    if not _NAME.fullmatch(name_or_file):
        raise ConfigError(
            f"{name_or_file!r} cannot be the name of a rider: take letters, digits, spaces and "
            "-_.', at most 64, or name a .json file",
            key="--rider",
        )
    return riders_folder() / f"{name_or_file}.json"


def read_rider(file: Path) -> Rider | None:
    """The rider that a file holds; None where there is no file.

    Raises:
        ConfigError: if the file does not read; names it, what is wrong and what to do.
    """
    return _read(Rider, file)


def known_rider(name_or_file: str) -> Rider:
    """A rider whose file is there.

    Raises:
        ConfigError: if there is none of that name; names the nearest, or all.
    """
    file = rider_file(name_or_file)
    rider = read_rider(file)
    if rider is None:
        known = nearest(name_or_file, rider_names()) or f" ({file} is not there)"
        raise ConfigError(f"no rider is called {name_or_file!r}{known}", key="--rider")
    return rider


def write_rider(rider: Rider, file: Path) -> None:
    """Replace the rider's file, and keep the one before as ``NAME.json.bak``.

    Raises:
        ConfigError: if the file there does not read, or it cannot be written.
    """
    read_rider(file)  # what is not understood is not written over
    _write(rider, file)


def forget_rider(name_or_file: str) -> Path:
    """Take a rider's file away, whether it reads or not, and what was shown last.

    Returns:
        where the file is kept still.

    Raises:
        ConfigError: if there is none, or it cannot be moved.
    """
    file = rider_file(name_or_file)
    if not file.is_file():
        known_rider(name_or_file)  # says what is there instead
    kept = _backup(file)
    try:
        file.replace(kept)
        shown_file(file).unlink(missing_ok=True)
    except OSError as cause:
        raise _not_written(file, cause) from None
    return kept


def shown_file(file: Path) -> Path:
    """Where the last proposal is noted beside a rider's file."""
    return file.with_suffix(".shown")


def read_shown(file: Path) -> Shown | None:
    """The last proposal made to the rider with this file; None where it was answered, or none was.

    Raises:
        ConfigError: if it does not read.
    """
    return _read(Shown, shown_file(file))


def write_shown(shown: Shown | None, file: Path) -> None:
    """Note what was proposed to the rider with this file; None: nothing is to be answered.

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
        f"{what}; mend it, or start anew with 'cohelm preferences reset --rider {file}'{last}",
        file=file,
    )


def _write(data: Model, file: Path, *, keep: bool = True) -> None:
    """Write a file beside the old one and put it in its place, also where a link leads to it."""
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
