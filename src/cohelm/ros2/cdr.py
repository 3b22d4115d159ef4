"""ROS 2 messages as bytes: CDR by ``rosbags``, from their public definitions."""

from __future__ import annotations

import functools
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

PEOPLE = "people_msgs/msg/People"
_FURTHER = {
    "people_msgs/msg/Person": """string name
geometry_msgs/Point position
geometry_msgs/Point velocity
float64 reliability
string[] tagnames
string[] tags
""",
    PEOPLE: """std_msgs/Header header
people_msgs/Person[] people
""",
}
"""Definitions of types that no distribution's core has."""


@functools.cache
def types_of(distribution: str) -> Typestore:
    """Message types of a ROS 2 distribution; they differ in ``rmw_dds_common`` only."""
    types = get_typestore(Stores(f"ros2_{distribution}"))
    for name, definition in _FURTHER.items():
        types.register(get_types_from_msg(definition, name))
    return types


def decode(data: bytes, name: str) -> Any:
    """Decode a message.

    Raises:
        ValueError: The bytes are not a message of that type.
        KeyError: There is no such type.
    """
    types = types_of("humble")
    if name not in types.types:  # a mistake of the caller, not damage
        raise KeyError(name)
    try:
        return types.deserialize_cdr(data, name)
    except Exception as error:  # damaged bytes raise many kinds of errors in rosbags
        raise ValueError(f"not a {name}: {error}") from None


def encode(message: Any, distribution: str = "humble") -> bytes:
    """Encode a message in CDR, little-endian."""
    return bytes(types_of(distribution).serialize_cdr(message, message.__msgtype__))
