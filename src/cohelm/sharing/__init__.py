"""Shared control: the rider's intent, authority η and the shared reference."""

from cohelm.sharing.authority import (
    AuthorityParameters,
    AuthorityState,
    authority,
    docked,
    stick_twist,
)
from cohelm.sharing.blend import blended

__all__ = [
    "AuthorityParameters",
    "AuthorityState",
    "authority",
    "blended",
    "docked",
    "stick_twist",
]
