"""What of a route a choice may go by, with its unit and its words: one entry for each."""

from __future__ import annotations

from collections.abc import Mapping

from cohelm.arrays import value


@value
class Trait:
    """A figure of ``RouteFeatures`` that riders may like or not."""

    unit: float
    """What one unit of weight is per: about by how much alternatives differ; assumed."""
    noticed: float
    """The least difference that is spoken of, in the figure's own unit; assumed."""
    counted: str
    """What a unit is made of, as "m longer"."""
    liked: str
    """What a rider likes whose weight is positive."""
    disliked: str
    """What one likes whose weight is negative."""
    more: str
    """Of a route with more of it than another; {n} is by how much, {s} the plural."""
    less: str
    """Of one with less."""

    def compared(self, difference: float) -> str:
        """One route's figure less another's, in words, as "6 m longer"."""
        n = abs(difference)
        phrase = self.more if difference > 0.0 else self.less
        return phrase.format(n=f"{n:.0f}", s="s" if round(n) > 1 else "")


TRAITS: Mapping[str, Trait] = {
    "length": Trait(
        unit=10.0,
        noticed=1.0,
        counted="m longer",
        liked="longer ways",
        disliked="shorter ways",
        more="{n} m longer",
        less="{n} m shorter",
    ),
    "clearance": Trait(
        unit=0.2,
        noticed=0.1,
        counted="m more room",
        liked="more room at the sides",
        disliked="narrow ways",
        more="more room",
        less="less room",
    ),
    "encounters": Trait(
        unit=2.0,
        noticed=0.5,
        counted="more people",
        liked="busy ways",
        disliked="quiet ways",
        more="busier",
        less="quieter",
    ),
    "turns": Trait(
        unit=2.0,
        noticed=1.0,
        counted="more turns",
        liked="ways with turns",
        disliked="straight ways",
        more="{n} more turn{s}",
        less="{n} fewer turn{s}",
    ),
    "doors": Trait(
        unit=1.0,
        noticed=1.0,
        counted="more narrow passage",
        liked="ways through doors",
        disliked="ways without doors",
        more="{n} more narrow passage{s}",
        less="{n} fewer narrow passage{s}",
    ),
}
"""By the name of the figure."""
