"""Lookup of an implementation by name: one file and one entry point add a part.

A part is a class with a nested parameter model, constructed from that model alone::

    class SoftVia:
        class Parameters(Model): ...
        def __init__(self, parameters: Parameters) -> None: ...

and one line in ``[project.entry-points."cohelm.global_planners"]``. Nothing is imported before the
moment of use, an unknown name lists the choices, and a part that does not import says why.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Annotated, Any, Protocol

from pydantic import BeforeValidator

from cohelm.config import Model, nearest, validate
from cohelm.errors import ConfigError, PluginError

GROUPS = (
    "global_planners",
    "local_planners",
    "detectors",
    "cloud_detectors",
    "trackers",
    "group_detectors",
    "predictors",
    "social_models",
    "pedestrian_models",
    "riders",
    "kinematics",
)
"""The kinds of parts; each is the entry-point group ``cohelm.<kind>``."""


def spelt_out(given: Any) -> Any:
    """A part that is named by a word, as the mapping that names it."""
    return {"use": given} if isinstance(given, str) else given


Spec = Annotated[dict[str, Any], BeforeValidator(spelt_out)]
"""How a file names a part: a word, or ``{use: word, parameter: value, …}``."""


class Part(Protocol):
    """What an entry point names."""

    Parameters: type[Model]

    def __call__(self, parameters: Any) -> Any:
        """The part with these parameters."""
        ...


def names(group: str) -> tuple[str, ...]:
    """The installed implementations of one kind, sorted."""
    return tuple(sorted(_entries(group)))


def origin(group: str, name: str) -> tuple[str, str]:
    """``(module:class, distribution)`` of an entry point, without importing it."""
    entry = _entry(group, name)
    distribution = entry.dist.name if entry.dist is not None else "unknown"
    return entry.value, distribution


def load(group: str, name: str) -> Any:
    """The class that ``name`` stands for.

    Raises:
        PluginError: if there is no such name, or it does not import, or it has no ``Parameters``.
    """
    entry = _entry(group, name)
    try:
        part = entry.load()
    except Exception as cause:
        raise PluginError(
            f"{group} {name!r} ({entry.value}) does not import: {type(cause).__name__}: {cause}"
        ) from cause
    parameters = getattr(part, "Parameters", None)
    if not (isinstance(parameters, type) and issubclass(parameters, Model)):
        raise PluginError(f"{group} {name!r} ({entry.value}) has no nested Parameters model")
    return part


def build(
    group: str,
    spec: str | Mapping[str, Any],
    *,
    file: Path | str | None = None,
    key: str = "",
    error: type[ConfigError] = ConfigError,
) -> Any:
    """The part that ``spec`` asks for: a name, or ``{"use": name, **parameters}``.

    Args:
        group: one of :data:`GROUPS`.
        spec: what a scenario says of it.
        file, key: named in an error about the parameters.
        error: the type to raise for parameters that do not fit.

    Raises:
        PluginError: if the name is unknown or does not import.
        ConfigError: (or ``error``) if the parameters do not fit.
    """
    given = dict(spelt_out(spec))
    name = given.pop("use", None)
    if not isinstance(name, str):
        raise error("say which one with 'use'" + nearest("", names(group)), file=file, key=key)
    part = load(group, name)
    parameters = validate(part.Parameters, given, file=file, prefix=key, error=error)
    return part(parameters)


def _entries(group: str) -> Mapping[str, EntryPoint]:
    return _found(entry_points, f"cohelm.{group}", tuple(sys.path))


@lru_cache(maxsize=64)
def _found(
    search: Callable[..., Any], group: str, path: tuple[str, ...]
) -> Mapping[str, EntryPoint]:
    """Entry points by name, looked for once on a path: that reads every distribution's files."""
    return {entry.name: entry for entry in search(group=group)}


def _entry(group: str, name: str) -> EntryPoint:
    entries = _entries(group)
    if name not in entries:
        what = group.replace("_", " ").removesuffix("s")
        raise PluginError(f"no {what} is called {name!r}{nearest(name, entries)}")
    return entries[name]
