"""Variants of a sweep: lists of values for any keys of the scenarios."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from cohelm.errors import ConfigError

OPTION = "--vary"


@dataclass(frozen=True)
class SettingVariant:
    """One value for every varied key."""

    columns: tuple[tuple[str, str], ...] = ()
    """(key, value) of each, as columns of the rows."""
    settings: tuple[str, ...] = ()
    """``dotted.key=value`` of each."""


def variants_of(given: Sequence[str]) -> tuple[SettingVariant, ...]:
    """All combinations of the values that ``key=a,b,c`` lists for each key.

    Values are YAML, so a list is one value: ``people.speed=[0.4,0.6],[1.0,1.2]``. Without keys
    there is one variant without columns.

    Raises:
        ConfigError: if one is not ``key=value,value``, or a value or a key is repeated.
    """
    keys: dict[str, tuple[str, ...]] = {}
    for text in given:
        key, equals, listed = text.partition("=")
        key = key.strip()
        if not equals or not key or not listed.strip():
            raise ConfigError("write key=a,b,c, as in people.count=1,3,5", key=f"{OPTION} {text}")
        if key in keys:
            raise ConfigError("is given twice; list all its values once", key=f"{OPTION} {key}")
        keys[key] = _values(key, listed)
    return tuple(
        SettingVariant(
            columns=tuple(zip(keys, chosen, strict=True)),
            settings=tuple(f"{key}={each}" for key, each in zip(keys, chosen, strict=True)),
        )
        for chosen in itertools.product(*keys.values())
    )


def columns_of(variants: Sequence[SettingVariant]) -> tuple[str, ...]:
    """Varied keys."""
    return tuple(key for key, _ in variants[0].columns) if variants else ()


def _values(key: str, listed: str) -> tuple[str, ...]:
    """Values of a list, each as YAML."""
    try:
        values = yaml.safe_load(f"[{listed}]")
    except yaml.YAMLError:
        raise ConfigError(f"{listed!r} is not a list of values", key=f"{OPTION} {key}") from None
    texts = [_as_line(each) for each in values]
    if len(set(texts)) < len(texts):
        raise ConfigError(f"{listed!r} has a value twice", key=f"{OPTION} {key}")
    return tuple(texts)


def _as_line(content: Any) -> str:
    """YAML of a value on one line, without the end marker that follows a bare word."""
    return yaml.safe_dump(content, default_flow_style=True, width=math.inf).splitlines()[0]
