"""What makes two sweeps the same: their tasks in words, their options, and the code that rides.

Everything becomes text before it is compared, so that a folder can say what it is of.
"""

from __future__ import annotations

import dataclasses
import enum
import hashlib
import platform
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib.metadata import entry_points, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from cohelm.errors import ConfigError

LIBRARIES = ("cohelm", "daqp", "numba", "numpy", "opencv-python-headless", "scipy")
"""Those whose versions decide the numbers; and Python's."""
_ONLY_SHOWS = ("cli", "driving", "evaluation/results", "pictures", "web")
"""Parts of the package that no row comes of."""
_NOT_ASKED = ("TITLE", "SEEDS", "WORKERS")
_FILES = (".yaml", ".yml", ".npz", ".txt", ".csv", ".pgm", ".png", ".json", ".geojson", ".mcap")
_DIGITS = 16


def words_of(value: Any) -> str:
    """A value as text; equal values, on whatever machine, give equal text.

    Whatever names a file that is there counts with what is in the file.

    Raises:
        TypeError: if a part of it is neither plain nor a frozen value of plain parts.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, enum.Enum):
        return f"{type(value).__name__}.{value.name}"
    if value is None or isinstance(value, bool | int | float | complex):
        return repr(value)
    if isinstance(value, str | Path):
        return _of_text(str(value))
    return _of_parts(value)


def keys_of(tasks: Sequence[Any]) -> list[str]:
    """A key for each task, the same in every run; those that are asked for twice are numbered.

    Raises:
        TypeError: as :func:`words_of`.
    """
    digests = [_digest(words_of(task).encode()) for task in tasks]
    seen: Counter[str] = Counter()
    out = []
    for each in digests:
        out.append(f"{each}-{seen[each]}" if seen[each] else each)
        seen[each] += 1
    return out


def options_of(bench: Any) -> dict[str, str]:
    """What a benchmark was asked for, in words, by name; nothing of one that asks nothing."""
    if not dataclasses.is_dataclass(bench):
        return {}
    return {
        each.name: words_of(getattr(bench, each.name))
        for each in dataclasses.fields(bench)
        if each.name not in _NOT_ASKED
    }


@cache
def code() -> Mapping[str, str]:
    """File or library → its digest or version: all that decides a row but the task.

    The packages of parts that others have installed belong to it.
    """
    out = {name: version(name) for name in LIBRARIES} | {"python": platform.python_version()}
    for package in ("cohelm", *sorted(_others())):
        spec = find_spec(package)
        if spec is None or not spec.origin:
            continue
        file = Path(spec.origin)
        whole = spec.submodule_search_locations is not None
        for each in _sources(file.parent) if whole else [file]:
            name = each.relative_to(file.parent).as_posix()
            if not (package == "cohelm" and name.startswith(_ONLY_SHOWS)):
                out[f"{package}/{name}"] = _digest(each.read_bytes())
    return out


def code_digest() -> str:
    """Of all that :func:`code` tells, in one word."""
    return _digest(words_of(dict(code())).encode())


def differences(one: Mapping[str, str], other: Mapping[str, str], most: int = 3) -> str:
    """Names that do not mean the same in both, the first few of them; empty: none."""
    names = sorted(name for name in {*one, *other} if one.get(name) != other.get(name))
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(_change(name, one, other) for name in names[:most]) + more


def check_plain(tasks: Sequence[Any]) -> None:
    """Whether tasks can be told apart.

    Raises:
        ConfigError: if not.
    """
    try:
        keys_of(tasks)
    except TypeError as cause:
        raise ConfigError(f"no sweep can be kept of these tasks: {cause}") from None


def _of_parts(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"array{value.shape}{value.dtype}{_digest(np.ascontiguousarray(value).tobytes())}"
    if isinstance(value, list | tuple | range):
        return f"({', '.join(map(words_of, value))})"
    if isinstance(value, set | frozenset):
        return f"{{{', '.join(sorted(map(words_of, value)))}}}"
    if isinstance(value, Mapping):
        return f"{{{', '.join(sorted(f'{words_of(k)}: {words_of(v)}' for k, v in value.items()))}}}"
    if isinstance(value, BaseModel):
        names = tuple(type(value).model_fields)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = tuple(each.name for each in dataclasses.fields(value))
    else:
        raise TypeError(f"{type(value).__name__} is no plain value that tells sweeps apart")
    inside = ", ".join(f"{name}={words_of(getattr(value, name))}" for name in names)
    return f"{type(value).__name__}({inside})"


def _change(name: str, one: Mapping[str, str], other: Mapping[str, str]) -> str:
    if "/" in name:
        return name
    return f"{name} {one.get(name, 'none')} → {other.get(name, 'none')}"


def _others() -> set[str]:
    """Top packages of parts that are installed beside ours."""
    points = entry_points()
    found = {
        point.module.partition(".")[0]
        for group in points.groups
        if group.startswith("cohelm.")
        for point in points.select(group=group)
    }
    return found - {"cohelm"}


def _sources(folder: Path) -> Iterator[Path]:
    for file in sorted(folder.rglob("*")):
        if file.suffix in {".py", ".yaml", ".yml", ".so"} and file.is_file():
            yield file


def _of_text(text: str) -> str:
    if not text.endswith(_FILES):
        return repr(text)
    file = Path(text)
    return f"{text!r}[{_digest(file.read_bytes())}]" if file.is_file() else repr(text)


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:_DIGITS]
