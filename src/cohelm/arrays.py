"""Frozen values whose arrays have declared shapes.

A field is annotated with its array type and the names of its axes, and the constructor checks
them::

    @value
    class People:
        id: Annotated[Integers, Shape("n")]
        mean: Annotated[Floats, Shape("n 4")]

A number is an exact length; a name has one length throughout the value; ``name+1`` is one more;
``...`` at the beginning stands for any leading axes; ``*`` is any length. Arrays are converted to
the annotated type, and become read-only and contiguous, so that compiled code needs one version for
each declaration; an array that the caller could still write to is copied, unless it was
:func:`sealed`.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import mmap
import operator
import os
import typing
import weakref
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, TypeVar, dataclass_transform, get_args, get_origin

import numpy as np
from numpy.typing import DTypeLike, NDArray

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]
Bytes = NDArray[np.uint8]
SignedBytes = NDArray[np.int8]

_T = TypeVar("_T")
_Table = TypeVar("_Table", bound=tuple[Any, ...])

__all__ = [
    "Annotated",
    "Booleans",
    "Bytes",
    "Floats",
    "Floats32",
    "Integers",
    "Shape",
    "SignedBytes",
    "empty_for_copies",
    "identical",
    "lazy_copy",
    "read_only",
    "replace",
    "sealed",
    "unchecked",
    "value",
]


@dataclass_transform(
    frozen_default=True,
    kw_only_default=True,
    eq_default=False,
    field_specifiers=(dataclasses.field,),
)
def value(cls: type[_T]) -> type[_T]:
    """Make ``cls`` a frozen, slotted, keyword-only record that checks its arrays on construction.

    Raises:
        ValueError: on construction, if an array does not have its declared shape.
    """
    cls.__post_init__ = _check  # type: ignore[attr-defined]  # the dataclass calls it
    return dataclasses.dataclass(frozen=True, slots=True, kw_only=True, eq=False)(cls)


def unchecked(of: _T, **changes: Any) -> _T:
    """Copy a value with changed fields, as :func:`replace`, but without checks.

    For inner loops: the caller guarantees types and shapes. Arrays become read-only, and are not
    copied.
    """
    cls: Any = type(of)
    copy: _T = object.__new__(cls)
    for name, content_of in _contents(cls):
        content = changes[name] if name in changes else content_of(of)
        object.__setattr__(copy, name, content)
    for content in changes.values():
        if type(content) is np.ndarray:
            content.flags.writeable = False
    return copy


def replace(of: _T, **changes: Any) -> _T:
    """Copy a value, or a dataclass, with changed fields, and check it.

    Raises:
        TypeError: if there is no such field.
    """
    cls: Any = type(of)
    fields = {name: content_of(of) for name, content_of in _contents(cls)}
    made: _T = cls(**{**fields, **changes})
    return made


def sealed(table: _Table) -> _Table:
    """Make the arrays of a named tuple read-only in place, so that a value need not copy them.

    For results of compiled code, which nothing else holds.
    """
    for content in table:
        if isinstance(content, np.ndarray):
            content.flags.writeable = False
    return table


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Return ``array`` itself if it is read-only, else a read-only copy."""
    if array.flags.writeable:
        array = array.copy()
        array.flags.writeable = False
    return array


def empty_for_copies(shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """Allocate an array that is filled once and then made read-only, for :func:`lazy_copy`.

    A large one is memory that the operating system can map again, where that is supported.
    """
    size = math.prod(shape) * np.dtype(dtype).itemsize
    if size < _LARGE or not hasattr(os, "memfd_create"):
        return np.empty(shape, dtype)
    descriptor = os.memfd_create("cohelm")
    os.ftruncate(descriptor, size)
    return np.ndarray(shape, dtype, buffer=_Pages(descriptor, size))


def lazy_copy(array: NDArray[Any]) -> NDArray[Any]:
    """Return a writable copy that shares unchanged pages with ``array``.

    Copying a large array from :func:`empty_for_copies` costs only what is changed; any other array
    is simply copied.

    Args:
        array: read-only: a write to it would appear in its copies.
    """
    pages = array.base
    if not isinstance(pages, _Pages) or array.flags.writeable or array.nbytes != len(pages):
        return array.copy()
    private = mmap.mmap(pages.descriptor, len(pages), access=mmap.ACCESS_COPY)
    return np.ndarray(array.shape, array.dtype, buffer=private)


def identical(a: object, b: object, *, ignore: frozenset[str] = frozenset()) -> bool:
    """Check that two values are equal bit for bit, field by field; NaN equals NaN.

    Args:
        a, b: values, arrays, sequences, mappings or plain objects.
        ignore: names of fields that are not compared, as measured durations.
    """
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return a.shape == b.shape and a.dtype == b.dtype and _bytes(a) == _bytes(b)
    if dataclasses.is_dataclass(a) and not isinstance(a, type):
        return all(
            identical(getattr(a, f.name), getattr(b, f.name), ignore=ignore)
            for f in dataclasses.fields(a)
            if f.name not in ignore
        )
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(identical(a[k], b[k], ignore=ignore) for k in a)
    if isinstance(a, tuple | list) and isinstance(b, tuple | list):
        return len(a) == len(b) and all(
            identical(x, y, ignore=ignore) for x, y in zip(a, b, strict=True)
        )
    return bool(a == b or (a != a and b != b))  # noqa: PLR0124  # NaN is the one that differs


def _bytes(array: NDArray[Any]) -> tuple[bytes, ...]:
    """Content of an array; that of a table by column, because the gaps between are undefined."""
    columns = array.dtype.names
    return tuple(array[name].tobytes() for name in columns) if columns else (array.tobytes(),)


@dataclasses.dataclass(frozen=True, slots=True)
class Shape:
    """Declared axes of an array field, as ``Shape("n 4")``."""

    axes: str


class _Pages(mmap.mmap):
    """Memory that can be mapped again."""

    descriptor: int

    def __new__(cls, descriptor: int, size: int) -> _Pages:
        self = super().__new__(cls, descriptor, size)
        self.descriptor = descriptor
        weakref.finalize(self, os.close, descriptor)
        return self


class _Field:
    """Declaration of one array field: its element type and axes."""

    __slots__ = ("axes", "content_of", "dtype", "leading", "lengths", "name", "optional")

    def __init__(self, name: str, hint: Any, *, optional: bool) -> None:
        array_type, shape = get_args(hint)[:2]
        self.name = name
        self.content_of = operator.attrgetter(name)
        self.dtype = np.dtype(get_args(get_args(array_type)[1])[0])
        self.axes = tuple(shape.axes.split())
        self.optional = optional
        self.leading = self.axes[:1] == ("...",)
        self.lengths = tuple(_length(axis) for axis in self.axes[self.leading :])


def _length(axis: str) -> tuple[int, str]:
    """(exact length, "") of an axis, or (extra, name); ("*" for any length)."""
    if axis.isdigit():
        return int(axis), ""
    name, _, extra = axis.partition("+")
    return int(extra or 0), name


def _check(self: Any) -> None:
    """Check and seal all arrays of a value; few calls, because a tick makes some seventy values."""
    cls: Any = type(self)
    shapes: tuple[tuple[int, ...] | None, ...] = ()
    for field in _fields(cls):
        given = array = field.content_of(self)
        if array is None and field.optional:
            shapes += (None,)
            continue
        if type(array) is not np.ndarray or array.dtype is not field.dtype:
            array = np.asarray(array, dtype=field.dtype)
        flags = array.flags
        if flags.writeable or not flags.c_contiguous:
            array = array.copy()
            array.flags.writeable = False
        if array is not given:
            object.__setattr__(self, field.name, array)
        shapes += (array.shape,)
    if shapes:
        _agree(cls, shapes)


@functools.lru_cache(maxsize=4096)
def _agree(cls: type, shapes: tuple[tuple[int, ...] | None, ...]) -> None:
    """Check the shapes of the arrays of ``cls``; cached, because shapes repeat.

    Raises:
        ValueError: naming the first array with a wrong shape.
    """
    lengths: dict[str, int] = {}
    for field, shape in zip(_fields(cls), shapes, strict=True):
        if shape is not None and not _fits(shape, field, lengths):
            raise ValueError(
                f"{cls.__name__}.{field.name} has shape {shape}, "
                f"declared ({', '.join(field.axes)}) with {lengths}"
            )


def _fits(shape: tuple[int, ...], field: _Field, lengths: dict[str, int]) -> bool:
    if field.leading:
        shape = shape[max(0, len(shape) - len(field.lengths)) :]
    if len(shape) != len(field.lengths):
        return False
    for length, (least, name) in zip(shape, field.lengths, strict=True):
        if not name:
            if length != least:
                return False
        elif name != "*" and lengths.setdefault(name, length - least) != length - least:
            return False
    return True


@functools.cache
def _contents(cls: type) -> tuple[tuple[str, Any], ...]:
    """Name of every field of a value, and the function that returns its content."""
    return tuple((each.name, operator.attrgetter(each.name)) for each in dataclasses.fields(cls))


@functools.cache
def _fields(cls: type) -> tuple[_Field, ...]:
    found = []
    for name, hint in typing.get_type_hints(cls, include_extras=True).items():
        if get_origin(hint) is ClassVar:
            continue
        options = get_args(hint) if type(None) in get_args(hint) else (hint,)
        found += [
            _Field(name, option, optional=len(options) > 1)
            for option in options
            if get_origin(option) is Annotated
        ]
    return tuple(found)


_LARGE = 1 << 22
"""Size above which mapping memory is cheaper than copying it, bytes."""
