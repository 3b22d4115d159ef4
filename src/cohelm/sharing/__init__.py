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
from cohelm.sharing.steering import (
    RiderIntent,
    SteeringParameters,
    SteeringState,
    rider_intent,
)

__all__ = [
    "AuthorityParameters",
    "AuthorityState",
    "InputHorizon",
    "RiderIntent",
    "SteeringParameters",
    "SteeringState",
    "authority",
    "limit_authority",
    "rider_intent",
    "shared_reference",
    "stick_twist",
]
