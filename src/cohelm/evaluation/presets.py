"""Parameters of local planners that a search found, all with one budget and one objective.

``benchmarks/tune.py`` writes them, a file for each planner in ``tuned/``; see ``tuning``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from cohelm.config import read_yaml


def tuned_file(planner: str) -> Path:
    """Where the parameters of a planner are kept, whether or not there are any."""
    return Path(str(files("cohelm.evaluation") / "tuned" / f"{planner}.yaml"))


def tuned_settings(planner: str) -> tuple[str, ...]:
    """``local_planner.key=value`` for each parameter that was searched; empty: none are kept.

    Raises:
        ConfigError: if the file does not hold a mapping.
    """
    file = tuned_file(planner)
    return as_settings(read_yaml(file)) if file.is_file() else ()


def as_settings(parameters: Mapping[str, Any], part: str = "local_planner") -> tuple[str, ...]:
    """Nested parameters as ``part.dotted.key=value``, as ``load_scenario`` takes them."""
    return tuple(f"{part}.{key}={json.dumps(each)}" for key, each in _flat(parameters))


def nested(dotted: Mapping[str, Any]) -> dict[str, Any]:
    """``{"a.b": 1}`` as ``{"a": {"b": 1}}``."""
    out: dict[str, Any] = {}
    for key, each in dotted.items():
        *above, last = key.split(".")
        node = out
        for word in above:
            node = node.setdefault(word, {})
        node[last] = each
    return out


def _flat(parameters: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    for key, each in parameters.items():
        if isinstance(each, Mapping):
            yield from _flat(each, f"{before}{key}.")
        else:
            yield before + key, each
