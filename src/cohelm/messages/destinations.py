"""Belief over the destinations of a rider who has named none, and the offers that follow."""

from __future__ import annotations

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.reasons import OfferReason


@value
class DestinationOffer:
    """A place that the rider may choose by one press; nothing chooses it otherwise."""

    name: str
    """Name of the place."""
    slot: int
    """Position among the offers, 0…2; an offer keeps it while it is shown."""
    belief: float
    """Probability that the rider wants to go there."""
    highlighted: bool
    """The belief is so high that this is the one offer to show first."""
    reason: OfferReason
    """Why it is believed."""
    progress: float
    """Distance by which the rider has come closer on the last metres, m."""

    @property
    def sentence(self) -> str:
        """The reason in the rider's words."""
        return self.reason.sentence.format(metres=f"{self.progress:.0f}")


@value
class DestinationBelief:
    """Probabilities of the n places of a map."""

    places: Annotated[Floats, Shape("n")]
    """In the order of the map's places."""
    elsewhere: float
    """Probability of any other destination; with ``places`` they sum to 1."""
    offers: tuple[DestinationOffer, ...] = ()
    """At most three, by slot."""
