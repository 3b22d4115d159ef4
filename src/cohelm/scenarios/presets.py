"""Tuned parameters of local planners, searched with one budget and one objective.

``benchmarks/tune.py`` writes them to ``tuned/``, one file for each planner.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from cohelm.config import read_yaml


def tuned_file(planner: str) -> Path:
    """File of a planner's tuned parameters, which may not exist."""
    return Path(str(files("cohelm.scenarios") / "tuned" / f"{planner}.yaml"))


def tuned_settings(planner: str) -> tuple[str, ...]:
    """``local_planner.key=value`` for each tuned parameter; empty without a file.

    Raises:
        ConfigError: if the file does not hold a mapping.
    """
    file = tuned_file(planner)
    return as_settings(read_yaml(file)) if file.is_file() else ()


def as_settings(parameters: Mapping[str, Any], part: str = "local_planner") -> tuple[str, ...]:
    """Nested parameters as ``part.dotted.key=value``, the form that ``load_scenario`` takes."""
    return tuple(f"{part}.{key}={json.dumps(each)}" for key, each in _flat(parameters))


def nested(dotted: Mapping[str, Any]) -> dict[str, Any]:
    """``{"a.b": 1}`` as ``{"a": {"b": 1}}``."""
    out: dict[str, Any] = {}
    for key, each in dotted.items():
        *parents, last = key.split(".")
        node = out
        for name in parents:
            node = node.setdefault(name, {})
        node[last] = each
    return out


def _flat(parameters: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, each in parameters.items():
        if isinstance(each, Mapping):
            yield from _flat(each, f"{prefix}{key}.")
        else:
            yield prefix + key, each
