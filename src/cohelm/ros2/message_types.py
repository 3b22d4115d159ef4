"""Types of ROS 2 messages for DDS, made from their public definitions; no ROS is installed.

The bytes on the wire are CDR from ``rosbags``; Cyclone DDS only needs each type's name and
structure, so that other DDS vendors recognise it.
"""

from __future__ import annotations

import functools
from typing import Any

from cyclonedds.idl import IdlStruct, make_idl_struct, types

from cohelm.ros2.cdr import types_of

_BASE = {
    "bool": bool,
    "byte": types.uint8,
    "char": types.uint8,
    "int8": types.int8,
    "uint8": types.uint8,
    "int16": types.int16,
    "uint16": types.uint16,
    "int32": types.int32,
    "uint32": types.uint32,
    "int64": types.int64,
    "uint64": types.uint64,
    "float32": types.float32,
    "float64": types.float64,
    "string": str,
}
_TYPES: Any = types
"""Types of arrays are made here from elements that only exist at run time."""
_HEADER_SIZE = 4
"""Size of the CDR encapsulation header, bytes."""


class Sample(IdlStruct):
    """Sample that carries the serialised message; its type is that of the subclass."""

    cdr: bytes

    def __init__(self, cdr: bytes) -> None:
        self.cdr = cdr

    def serialize(self, *_: Any, **__: Any) -> bytes:
        """Return the message as it is sent."""
        return self.cdr

    @classmethod
    def deserialize(cls, data: bytes, *_: Any, **__: Any) -> Sample:
        """Keep the bytes: the reader decides about decoding."""
        return cls(bytes(data))

    @classmethod
    def deserialize_key(cls, *_: Any, **__: Any) -> Sample:
        """Return an empty sample: ROS topics have no keys, and the publisher has gone."""
        return cls(b"")


@functools.cache
def dds_type(name: str, distribution: str) -> type[Sample]:
    """Return the DDS type of a message type, as ``nav_msgs/msg/Path``.

    Raises:
        KeyError: The type is unknown.
    """
    struct = _struct(name, distribution)

    class Named(Sample, typename=struct.__idl_typename__):
        pass

    setattr(Named, "__idl__", struct.__idl__)  # noqa: B010  # its metaclass declares it
    return Named


@functools.cache
def _struct(name: str, distribution: str) -> type[IdlStruct]:
    package, _, type_ = name.split("/")
    _, fields = types_of(distribution).fielddefs[name]
    # An empty struct has one hidden octet in ROS 2, since IDL forbids empty structs.
    described = {field: _field(each, distribution) for field, each in fields} or {
        "structure_needs_at_least_one_member": types.uint8
    }
    return make_idl_struct(type_, f"{package}.msg.dds_.{type_}_", described, dataclassify=False)


def _field(description: Any, distribution: str) -> Any:
    kind, content = description
    match kind.name:
        case "BASE":
            return _BASE[content[0]]
        case "NAME":
            return _struct(content, distribution)
        case "ARRAY":
            return _TYPES.array[_field(content[0], distribution), content[1]]
        case _:
            return _TYPES.sequence[_field(content[0], distribution)]
