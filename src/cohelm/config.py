"""Strict configuration: from YAML to a frozen pydantic model, with errors that suggest a remedy.

An unknown key is an error with its file, its dotted key and the nearest known one, so that a
misspelt parameter is never ignored.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar, cast, get_origin

import numpy as np
import pydantic
import yaml

from cohelm.errors import ConfigError


class FrozenModel(pydantic.BaseModel):
    """Frozen model without unknown keys."""

    model_config = pydantic.ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Model(FrozenModel):
    """Base of every parameter set: frozen, without unknown keys.

    A mapping for a nested set changes only the values that it names: the others are those of the
    field's own default, which may differ from the defaults of its type.
    """

    @pydantic.model_validator(mode="before")
    @classmethod
    def _complete(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        fields = cls.model_fields
        return {
            key: _completed(fields[key].default, given) if key in fields else given
            for key, given in data.items()
        }


def _completed(default: Any, given: Any) -> Any:
    """The given values over those of a default."""
    if not (isinstance(default, Model) and isinstance(given, Mapping)):
        return given
    known = dict(default)
    return {**known, **{key: _completed(known.get(key), each) for key, each in given.items()}}


_M = TypeVar("_M", bound=Model)

_MERGE = "tag:yaml.org,2002:merge"
_MOST = 1e9
"""Largest size of a real number: in SI units nothing here is beyond it."""
_MOST_INTEGER = 2**63 - 1
"""Largest integer of compiled code; only seeds come near it."""
_DEEPEST = 50
"""Most levels of keys and lists within each other."""
_LARGEST = 2_000_000
"""Most values of a file, with those that an alias repeats."""
_SHORT = 80
"""Maximum length of a value in an error, characters."""

_IN_YAML = {
    **dict.fromkeys(("dict_type", "model_type"), "must be a mapping of keys to values"),
    **dict.fromkeys(("tuple_type", "list_type"), "must be a list"),
}
"""Messages in terms of YAML instead of Python types."""


def number_record(parameters: _M) -> _M:
    """Return the numbers among parameters as one structured scalar, for compiled code.

    It has the type's names, int64 and float64; compiled code reads it without conversion of each
    number.
    """
    numbers = {
        name: number
        for name, number in parameters
        if isinstance(number, int | float) and not isinstance(number, bool)
    }
    kinds = [(name, np.int64 if isinstance(n, int) else np.float64) for name, n in numbers.items()]
    return cast(_M, np.array(tuple(numbers.values()), np.dtype(kinds))[()])


def read_yaml(file: Path, *, error: type[ConfigError] = ConfigError) -> dict[str, Any]:
    """Read a mapping from a YAML file; an empty file is an empty mapping.

    Raises:
        ConfigError: (or ``error``) if the file cannot be read, is not YAML, is not a mapping, or
            names a key twice.
    """
    if file.is_char_device():
        raise error("is a device; name a file", file=file)
    try:
        text = file.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise error("no such file", file=file) from None
    except IsADirectoryError:
        raise error("is a folder; name a file in it", file=file) from None
    except (OSError, ValueError) as cause:  # ValueError: not UTF-8, or an invalid file name
        what = getattr(cause, "strerror", None) or cause
        raise error(f"cannot be read as text ({what})", file=file) from cause
    try:
        data = yaml.load(text, Loader=_StrictLoader)  # a SafeLoader
    except RecursionError:
        raise error("not YAML: nested too deeply", file=file) from None
    except yaml.YAMLError as cause:
        line = getattr(getattr(cause, "problem_mark", None), "line", None)
        where = "" if line is None else f"line {line + 1}: "
        what = getattr(cause, "problem", None) or str(cause).splitlines()[0]
        raise error(f"not YAML: {where}{what}", file=file) from cause
    if _unfolds_too_far(data):
        raise error("not YAML: too many values, or values within themselves", file=file)
    if data is None:
        return {}
    if not isinstance(data, dict):
        raise error("must be a mapping of keys to values", file=file)
    return data


def validate(
    model: type[_M],
    data: Mapping[str, Any],
    *,
    file: Path | str | None = None,
    prefix: str = "",
    error: type[ConfigError] = ConfigError,
) -> _M:
    """Validate ``data`` as a ``model``.

    Args:
        model: expected type.
        data: plain values, as from YAML.
        file: named in the error.
        prefix: dotted key of ``data``, named in the error.
        error: the type to raise.

    Raises:
        ConfigError: (or ``error``) naming file, dotted key and remedy; the first problem only. A
            number that no unit makes sense of, as 1e-300, is one.
    """
    absurd = next(_absurd(data), None)
    if absurd is not None:
        where, number = absurd
        key = ".".join([*([prefix] if prefix else []), *where])
        raise error(f"{number} is not a plausible number", file=file, key=key)
    try:
        return model.model_validate(dict(data))
    except pydantic.ValidationError as cause:
        fault = min(cause.errors(), key=lambda e: e["type"] != "extra_forbidden")
        location = [str(part) for part in fault["loc"]]
        key = ".".join([*([prefix] if prefix else []), *location])
        raise error(_explain(model, fault, location), file=file, key=key) from None


def load(model: type[_M], file: Path, *, error: type[ConfigError] = ConfigError) -> _M:
    """Load a ``model`` from a YAML file.

    Raises:
        ConfigError: (or ``error``), see :func:`read_yaml` and :func:`validate`.
    """
    return validate(model, read_yaml(file, error=error), file=file, error=error)


def override(data: Mapping[str, Any], settings: Iterable[str]) -> dict[str, Any]:
    """Apply ``dotted.key=value`` settings to a deep copy of ``data``; values are read as YAML.

    Raises:
        ConfigError: if a setting has no ``=``, or a part of its key is not a mapping.
    """
    out = _copied(data)
    for setting in settings:
        key, equals, text = setting.partition("=")
        parts = [part.strip() for part in key.split(".")]
        if not equals or not all(parts):
            raise ConfigError("write a setting as key=value, as in people.count=5", key=setting)
        try:
            given = yaml.load(text, Loader=_StrictLoader)  # a SafeLoader
        except (yaml.YAMLError, RecursionError):
            raise ConfigError(
                f"{_shortened(text)!r} is not a YAML value", key=key.strip()
            ) from None
        if _unfolds_too_far(given):
            raise ConfigError("has too many values, or values within themselves", key=key.strip())
        node = out
        for part in parts[:-1]:
            below = node.setdefault(part, {})
            if below is None:
                below = node[part] = {}
            if not isinstance(below, dict):
                raise ConfigError(f"{part!r} holds a value, not further keys", key=key.strip())
            node = below
        node[parts[-1]] = given
    return out


def nearest(word: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean 'horizon'?"``, or all choices if none is near."""
    choices = sorted(known)
    close = difflib.get_close_matches(word, choices, n=1, cutoff=0.6)
    if close:
        return f"; did you mean {close[0]!r}?"
    return f"; known: {', '.join(choices)}" if choices else ""


def _unfolds_too_far(data: Any) -> bool:
    """Check plain values for aliases that hold themselves, or unfold beyond memory."""
    pending, count = [(data, 0)], 0
    while pending:
        here, depth = pending.pop()
        below = here.values() if isinstance(here, dict) else here if isinstance(here, list) else ()
        count += len(below)
        if depth > _DEEPEST or count > _LARGEST:
            return True
        pending.extend((each, depth + 1) for each in below)
    return False


def _absurd(data: Any, where: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], str]]:
    """Keys and values of numbers that are finite and too large to be meant."""
    if isinstance(data, float) and abs(data) > _MOST and np.isfinite(data):
        yield where, f"{data:g}"
    elif isinstance(data, int) and abs(data) > _MOST_INTEGER:
        yield where, f"an integer of {data.bit_length()} bits"
    elif isinstance(data, Mapping):
        for key, below in data.items():
            yield from _absurd(below, (*where, str(key)))
    elif isinstance(data, list | tuple):
        for number, below in enumerate(data):
            yield from _absurd(below, (*where, str(number)))


def _explain(model: type[Model], fault: Any, location: list[str]) -> str:
    if fault["type"] == "extra_forbidden":
        known = nearest(location[-1], _keys_at(model, location[:-1]))
        return "unknown" + (known or "; there is nothing to set here")
    if fault["type"] == "missing":
        return "missing, and it has no default"
    message = _IN_YAML.get(fault["type"]) or str(fault["msg"]).removeprefix("Value error, ")
    message = message[:1].lower() + message[1:]
    given = fault.get("input")
    if isinstance(given, str | int | float | bool):
        return f"{message}, got {_shortened(given)!r}"
    return message


def _shortened(given: Any) -> Any:
    """Shorten a value to one line."""
    text = str(given)
    return given if len(text) <= _SHORT else f"{text[:_SHORT]}…"


def _keys_at(model: type[Model], location: list[str]) -> Iterable[str]:
    """Known keys of the model at ``location``; empty if that is not a model."""
    here: Any = model
    named = False
    for part in location:
        # A key of a mapping or list: its content type was found together with it.
        if named or part.isdigit():
            named = False
            continue
        if not (isinstance(here, type) and issubclass(here, pydantic.BaseModel)):
            return ()
        field = here.model_fields.get(part)
        if field is None:
            return ()
        here = _model_in(field.annotation)
        named = get_origin(field.annotation) in {dict, Mapping}
    if isinstance(here, type) and issubclass(here, pydantic.BaseModel):
        return here.model_fields.keys()
    return ()


def _model_in(annotation: Any) -> Any:
    if isinstance(annotation, type) and issubclass(annotation, pydantic.BaseModel):
        return annotation
    for part in getattr(annotation, "__args__", ()):
        found = _model_in(part)
        if found is not None:
            return found
    return None


def _copied(data: Mapping[str, Any]) -> dict[str, Any]:
    return {k: _copied(v) if isinstance(v, Mapping) else v for k, v in data.items()}


class _StrictLoader(yaml.SafeLoader):
    """SafeLoader that refuses a key given twice and reads ``1e-3`` as a number.

    A malformed value, as the date 2020-99-99, is a YAML error with a line.
    """

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        try:
            return super().construct_object(node, deep=deep)
        except (ValueError, LookupError, AttributeError):
            kind = node.tag.rpartition(":")[2]
            problem = f"{_shortened(node.value)!r} is no {kind}; quote it if it is a word"
            raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark) from None

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key_node, _ in node.value:
            if key_node.tag == _MERGE:
                raise yaml.constructor.ConstructorError(
                    None,
                    None,
                    "merging with << is not supported; write the keys out",
                    node.start_mark,
                )
            key = self.construct_object(key_node, deep=deep)
            if not isinstance(key, str | int | float | bool):
                raise yaml.constructor.ConstructorError(
                    None, None, "a key must be a word", key_node.start_mark
                )
            if key in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key {key!r} is given twice", key_node.start_mark
                )
            seen.add(key)
        return super().construct_mapping(node, deep=deep)


# YAML 1.1, which PyYAML implements, requires a dot and a sign: it reads 1e-3 as a string.
_StrictLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?[0-9]+[eE][-+]?[0-9]+$"), list("-+0123456789")
)
