"""Identity of sweeps: keys of tasks, and values as text, equal on every machine."""

from __future__ import annotations

import dataclasses
import enum
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from cohelm.errors import ConfigError
from cohelm.evaluation.code_version import digest

_FILES = (".yaml", ".yml", ".npz", ".txt", ".csv", ".pgm", ".png", ".json", ".geojson", ".mcap")


def canonical_text(value: Any) -> str:
    """A value as text; equal values give equal text. A file name counts with the file's content.

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


def task_keys(tasks: Sequence[Any]) -> list[str]:
    """A key for each task, the same in every run; equal tasks are numbered.

    Raises:
        TypeError: as :func:`canonical_text`.
    """
    digests = [digest(canonical_text(task).encode()) for task in tasks]
    seen: Counter[str] = Counter()
    out = []
    for each in digests:
        out.append(f"{each}-{seen[each]}" if seen[each] else each)
        seen[each] += 1
    return out


def check_plain(tasks: Sequence[Any]) -> None:
    """Check that tasks have keys.

    Raises:
        ConfigError: if not.
    """
    try:
        task_keys(tasks)
    except TypeError as cause:
        raise ConfigError(f"these tasks cannot be stored: {cause}") from None


def _of_parts(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"array{value.shape}{value.dtype}{digest(np.ascontiguousarray(value).tobytes())}"
    if isinstance(value, list | tuple | range):
        return f"({', '.join(map(canonical_text, value))})"
    if isinstance(value, set | frozenset):
        return f"{{{', '.join(sorted(map(canonical_text, value)))}}}"
    if isinstance(value, Mapping):
        items = (f"{canonical_text(k)}: {canonical_text(v)}" for k, v in value.items())
        return f"{{{', '.join(sorted(items))}}}"
    if isinstance(value, BaseModel):
        names = tuple(type(value).model_fields)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = tuple(each.name for each in dataclasses.fields(value))
    else:
        raise TypeError(f"{type(value).__name__} is not a plain value")
    inside = ", ".join(f"{name}={canonical_text(getattr(value, name))}" for name in names)
    return f"{type(value).__name__}({inside})"


def _of_text(text: str) -> str:
    """A text, and the digest of each file that it names alone, in a list or as a value."""
    named = (part for part in re.split("[,=]", text) if part.endswith(_FILES))
    files = [Path(part.strip()) for part in named]
    return repr(text) + "".join(f"[{digest(f.read_bytes())}]" for f in files if f.is_file())
