"""Serialise values to bytes and back, exactly to the bit.

A packed value is, all numbers little-endian::

    4 bytes   "CHV1"
    uint32    CRC-32 of all that follows
    uint32    length of the description, bytes
    …         the description: JSON in UTF-8, with spaces up to a multiple of 8 from the start
    …         the arrays, one after the other, in C order, each beginning at a multiple of 8

The description has an object for every value and every parameter set, with its fields by name; an
array is ``{"dtype": "<f8", "shape": [2, 3], "at": 16}``, where ``at`` counts bytes from the first
array's beginning. A number that JSON does not know is ``"nan"``, ``"inf"`` or ``"-inf"``.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import math
import struct
import types
import typing
import zlib
from collections.abc import Mapping
from enum import Enum
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

import numpy as np
from numpy.typing import NDArray

from cohelm.config import Model

MAGIC = b"CHV1"
_HEAD = struct.Struct("<4sII")
_T = TypeVar("_T")


def pack(content: object) -> bytes:
    """Serialise a value of ``messages``, or any other made with ``arrays.value``."""
    arrays = _Arrays()
    text = json.dumps(_plain(content, arrays), separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-(_HEAD.size + len(text)) % _ALIGNED)
    body = b"".join([struct.pack("<I", len(text)), text, *arrays.pieces])
    return MAGIC + struct.pack("<I", zlib.crc32(body)) + body


def unpack(data: bytes, kind: type[_T]) -> _T:
    """Deserialise the bytes of :func:`pack`; arrays share their memory.

    Args:
        data: Packed value.
        kind: Expected type.

    Raises:
        ValueError: if it is damaged, or not of that type.
    """
    if len(data) < _HEAD.size or not data.startswith(MAGIC):
        raise ValueError("is not a packed value")
    _, crc, length = _HEAD.unpack_from(data)
    if zlib.crc32(memoryview(data)[len(MAGIC) + 4 :]) != crc:
        raise ValueError("is damaged: its checksum is wrong")
    try:
        tree = json.loads(data[_HEAD.size : _HEAD.size + length])
        built: _T = _built(tree, kind, memoryview(data)[_HEAD.size + length :])
    except (ValueError, TypeError, LookupError, AttributeError, RecursionError) as fault:
        raise ValueError(f"is not a {kind.__name__}: {fault}") from None
    return built


class _Arrays:
    """Arrays collected so far, with their offsets."""

    def __init__(self) -> None:
        self.pieces: list[bytes] = []
        self._at = 0

    def add(self, array: NDArray[Any]) -> dict[str, Any]:
        little = array.astype(array.dtype.newbyteorder("<"), copy=False)
        data = little.tobytes()
        entry = {"dtype": little.dtype.str, "shape": list(array.shape), "at": self._at}
        data += b"\0" * (-len(data) % _ALIGNED)
        self.pieces.append(data)
        self._at += len(data)
        return entry


def _plain(content: Any, arrays: _Arrays) -> Any:  # noqa: PLR0911  # one for each kind
    """Convert to JSON types; arrays are collected separately."""
    if isinstance(content, np.ndarray):
        return arrays.add(content)
    if isinstance(content, Enum):
        return content.value
    if content is None or isinstance(content, bool | int | str):
        return content
    if isinstance(content, float):
        return float(content) if math.isfinite(content) else str(float(content))
    if isinstance(content, Mapping):
        return {key: _plain(each, arrays) for key, each in content.items()}
    if isinstance(content, tuple | list):
        return [_plain(each, arrays) for each in content]
    if isinstance(content, Model):
        return _plain(content.model_dump(mode="json"), arrays)
    if isinstance(content, np.generic):
        return _plain(content.item(), arrays)
    names = type(content).__dataclass_fields__
    return {name: _plain(getattr(content, name), arrays) for name in names}


def _built(tree: Any, hint: Any, raw: memoryview) -> Any:  # noqa: PLR0911  # one for each kind
    """Convert JSON types to the annotated type ``hint``."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _array(tree, raw)
    if origin in {Union, types.UnionType}:
        if tree is None:
            return None
        return _built(tree, next(each for each in inner if each is not type(None)), raw)
    if origin is tuple:
        kinds = [inner[0]] * len(tree) if len(inner) == 2 and inner[1] is ... else inner
        return tuple(_built(each, kind, raw) for each, kind in zip(tree, kinds, strict=True))
    if hint is float:
        return float(tree)
    if not isinstance(hint, type) or origin is not None:
        return _word(tree, hint)
    if issubclass(hint, Model):
        return hint.model_validate(tree)
    if issubclass(hint, Enum):
        return hint(tree)
    if dataclasses.is_dataclass(hint):
        hints = _hints(hint)
        return hint(**{name: _built(each, hints[name], raw) for name, each in tree.items()})
    return _checked(tree, hint)


def _word(tree: Any, hint: Any) -> Any:
    """Check a Literal; mappings and Any pass unchanged."""
    if get_origin(hint) is Literal and tree not in get_args(hint):
        raise ValueError(f"{tree!r} is not one of {get_args(hint)}")
    return tree


def _checked(tree: Any, kind: type) -> Any:
    if kind is not object and not isinstance(tree, kind):
        raise TypeError(f"{str(tree)[:40]!r} is not a {kind.__name__}")
    return tree


def _array(tree: Any, raw: memoryview) -> NDArray[Any]:
    shape = tuple(int(length) for length in tree["shape"])
    count, at = math.prod(shape), int(tree["at"])
    if any(length < 0 for length in shape) or at < 0:
        raise ValueError("an array has no such shape")
    flat: NDArray[Any] = np.frombuffer(raw, np.dtype(tree["dtype"]), count, at)
    return flat.reshape(shape)


@functools.cache
def _hints(kind: type) -> dict[str, Any]:
    return typing.get_type_hints(kind, include_extras=True)


_ALIGNED = 8
