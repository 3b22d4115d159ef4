"""Nav2's YAML files: keys that are unknown here are left out with a warning, as Nav2 does."""

from __future__ import annotations

import difflib
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from cohelm import config
from cohelm.errors import ConfigError, MapError

_M = TypeVar("_M", bound=config.Model)

_NEAR, _CLOSE = 0.6, 0.8
"""Similarity from which a word may be meant for another one, and almost certainly is."""


class MapWarning(UserWarning):
    """A map was read with an assumption, a substitute file, or without a part of its files."""


def read_nav2_yaml(file: Path) -> dict[str, Any]:
    """Read a mapping.

    Raises:
        MapError: see :func:`~cohelm.config.read_yaml`.
    """
    try:
        return config.read_yaml(file)
    except ConfigError as cause:
        raise MapError(cause.problem, file=file) from None


def known_part(model: type[_M], given: Mapping[str, Any], file: Path) -> _M:
    """Validate the keys that a model has; the others give a :class:`MapWarning`.

    Raises:
        MapError: if a value is invalid, or a key looks like a misspelling of the model's own.
    """
    foreign = [key for key in given if _is_foreign(str(key), model.model_fields, given)]
    try:
        out = config.validate(model, {k: v for k, v in given.items() if k not in foreign})
    except ConfigError as cause:
        where = f"{cause.key}: " if cause.key else ""
        raise MapError(where + cause.problem, file=file) from None
    if foreign:
        warnings.warn(
            f"{file}: {', '.join(map(str, foreign))}: not known here, left out",
            MapWarning,
            stacklevel=4,
        )
    return out


def _is_foreign(word: str, known: Iterable[str], given: Iterable[str]) -> bool:
    """Check that an unknown key is no misspelling.

    A misspelling resembles a key that is absent, or closely resembles one that is present and adds
    no whole word to it, as ``image_width`` does.
    """
    if word in known:
        return False
    (near,) = difflib.get_close_matches(word.lower(), known, n=1, cutoff=_NEAR) or ("",)
    if near not in given:
        return not near
    close = difflib.SequenceMatcher(None, word.lower(), near).ratio() >= _CLOSE
    return not close or set(near.split("_")) < set(word.lower().split("_"))
