"""Plugins: lookup of implementations by name; one file and one entry point add one.

A plugin is a class with a nested parameter model, constructed from that model alone::

    class SoftVia:
        class Parameters(Model): ...
        def __init__(self, parameters: Parameters) -> None: ...

and one line in ``[project.entry-points."cohelm.global_planners"]``. A plugin is
imported when it is used, an unknown name lists the choices, and an import error is reported.
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
    "platforms",
)
"""Kinds of plugins; each is the entry-point group ``cohelm.<kind>``."""


def spelt_out(given: Any) -> Any:
    """Expand a name to the mapping ``{"use": name}``."""
    return {"use": given} if isinstance(given, str) else given


Spec = Annotated[dict[str, Any], BeforeValidator(spelt_out)]
"""Specification of a plugin: a name, or ``{use: name, parameter: value, …}``."""


class Part(Protocol):
    """Target of an entry point."""

    Parameters: type[Model]

    def __call__(self, parameters: Any) -> Any:
        """Create the plugin with these parameters."""
        ...


def names(group: str) -> tuple[str, ...]:
    """Return the installed implementations of one kind, sorted."""
    return tuple(sorted(_entries(group)))


def origin(group: str, name: str) -> tuple[str, str]:
    """Return ``(module:class, distribution)`` of an entry point, without importing it."""
    entry = _entry(group, name)
    distribution = entry.dist.name if entry.dist is not None else "unknown"
    return entry.value, distribution


def load(group: str, name: str) -> Any:
    """Load the class of an entry point, or the one that ``module:Class`` names.

    Raises:
        PluginError: if the name is unknown, the import fails, or ``Parameters`` is missing.
    """
    entry = EntryPoint(name, name, f"cohelm.{group}") if ":" in name else _entry(group, name)
    try:
        part = entry.load()
    except Exception as cause:  # the import of someone's module may raise anything
        raise PluginError(
            f"{group} {entry.value!r} does not import: {type(cause).__name__}: {cause}"
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
    """Build a plugin from a name, or from ``{"use": name, **parameters}``.

    Args:
        group: one of :data:`GROUPS`.
        spec: from a scenario.
        file, key: named in an error about the parameters.
        error: the type to raise for invalid parameters.

    Raises:
        PluginError: if the name is unknown or the import fails.
        ConfigError: (or ``error``) if the parameters are invalid.
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
    """Find entry points by name; cached by path, because it reads files of every distribution."""
    return {entry.name: entry for entry in search(group=group)}


def _entry(group: str, name: str) -> EntryPoint:
    entries = _entries(group)
    if name not in entries:
        what = group.replace("_", " ").removesuffix("s")
        raise PluginError(f"no {what} is called {name!r}{nearest(name, entries)}")
    return entries[name]
