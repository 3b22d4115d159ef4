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
from cohelm.sharing.destinations import (
    InferenceParameters,
    InferenceState,
    StickLine,
    belief,
    prior_of,
    update_inference,
)
from cohelm.sharing.hand import HandState
from cohelm.sharing.intent import (
    RiderIntent,
    SteeringParameters,
    SteeringState,
)
from cohelm.sharing.offers import EMPTY, OfferParameters, OfferState, update_offers
from cohelm.sharing.passage_wait import Surroundings
from cohelm.sharing.steering import rider_intent
from cohelm.sharing.yielding import (
    YieldingParameters,
    YieldingState,
    update_yielding,
    with_literal_stick,
)

__all__ = [
    "EMPTY",
    "AuthorityParameters",
    "AuthorityState",
    "HandState",
    "InferenceParameters",
    "InferenceState",
    "InputHorizon",
    "OfferParameters",
    "OfferState",
    "RiderIntent",
    "SteeringParameters",
    "SteeringState",
    "StickLine",
    "Surroundings",
    "YieldingParameters",
    "YieldingState",
    "authority",
    "belief",
    "limit_authority",
    "prior_of",
    "rider_intent",
    "shared_reference",
    "stick_twist",
    "update_inference",
    "update_offers",
    "update_yielding",
    "with_literal_stick",
]
