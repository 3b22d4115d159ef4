"""Part of LUCI's gRPC interface that cohelm speaks.

Names and field numbers are those of LUCI's published ``sensors.proto`` (package ``sensors``,
service ``Sensors``); fields that are not read are left out, which the wire format allows.
"""

from __future__ import annotations

import functools
from typing import Any

from google.protobuf import empty_pb2
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass

SERVICE = "sensors.Sensors"
SHARED_REMOTE = 5
"""Input source of a computer that shares control: the rider's joystick is still streamed."""

_TYPES = {
    "int32": FieldDescriptorProto.TYPE_INT32,
    "float": FieldDescriptorProto.TYPE_FLOAT,
    "string": FieldDescriptorProto.TYPE_STRING,
}
# Enumerations are integers on the wire, and are declared as such.
_MESSAGES: dict[str, tuple[tuple[int, str, str], ...]] = {
    "Response": ((1, "string", "reply"), (2, "int32", "return_code")),
    "RemoteJsValues": (
        (1, "int32", "forward_back"),
        (2, "int32", "left_right"),
        (3, "int32", "source"),
    ),
    "InputSourceRequest": ((1, "int32", "source"),),
    "JoystickData": (
        (1, "int32", "forward_back"),
        (2, "int32", "left_right"),
        (4, "int32", "source"),
    ),
    "EncoderData": ((1, "float", "left_angle"), (2, "float", "right_angle")),
    "Point3D": ((1, "float", "x"), (2, "float", "y"), (3, "float", "z")),
    "CameraPoints": ((1, "Point3D*", "points"),),
}
UNARY = {
    "JsOverride": "RemoteJsValues",
    "AddInputSource": "InputSourceRequest",
    "RemoveInputSource": "InputSourceRequest",
}
"""Request of each call that has one answer, a ``Response``."""
STREAMS = {
    "UserJoystickStream": "JoystickData",
    "EncoderStream": "EncoderData",
    "DecimatedCameraStream": "CameraPoints",
}
"""Message of each stream; its request is empty."""


def path(method: str) -> str:
    """Return the path of a method."""
    return f"/{SERVICE}/{method}"


@functools.cache
def message(name: str) -> type[Any]:
    """Return the class of a message."""
    found: type[Any] = GetMessageClass(_pool().FindMessageTypeByName(f"sensors.{name}"))
    return found


Empty = empty_pb2.Empty


@functools.cache
def _pool() -> DescriptorPool:
    file = FileDescriptorProto(name="cohelm/luci.proto", package="sensors", syntax="proto3")
    for name, fields in _MESSAGES.items():
        made = file.message_type.add(name=name)
        for number, kind, field in fields:
            repeated = kind.endswith("*")
            label = (
                FieldDescriptorProto.LABEL_REPEATED
                if repeated
                else FieldDescriptorProto.LABEL_OPTIONAL
            )
            added = made.field.add(name=field, number=number, label=label)
            if kind in _TYPES:
                added.type = _TYPES[kind]
            else:
                added.type = FieldDescriptorProto.TYPE_MESSAGE
                added.type_name = f".sensors.{kind.rstrip('*')}"
    pool = DescriptorPool()
    pool.Add(file)
    return pool
