"""Shared control: rider intent, authority η and the shared reference."""

from cohelm.sharing.authority import (
    AuthorityParameters,
    AuthorityState,
    InputHorizon,
    authority,
    limit_authority,
    shared_reference,
    stick_twist,
)

__all__ = [
    "AuthorityParameters",
    "AuthorityState",
    "InputHorizon",
    "authority",
    "limit_authority",
    "shared_reference",
    "stick_twist",
]
