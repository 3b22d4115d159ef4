"""Under which heading a scenario is listed."""

from __future__ import annotations

from enum import StrEnum


class Collection(StrEnum):
    """The collections there are, in the order of a listing."""

    OWN = "own"
    """Of one's own: what a file that does not say belongs to."""
    BUILDING = "building"
    GLOBAL = "paper-global"
    STATIC = "paper-static"
    DYNAMIC = "paper-dynamic"
    CARDS = "cards"
    CROWDS = "crowds"
    RIDER = "rider"
    CHANGING = "changing"

    @property
    def heading(self) -> str:
        """For people."""
        return _TITLES[self]


_TITLES = {
    Collection.OWN: "Of your own",
    Collection.BUILDING: "Across a building",
    Collection.GLOBAL: "Global planning in semi-open offices (Xu et al., Table 2)",
    Collection.STATIC: "Narrow corridors (Xu et al., static)",
    Collection.DYNAMIC: "Among a few people (Xu et al., Table 3)",
    Collection.CARDS: "Social navigation cards (Francis et al. 2023)",
    Collection.CROWDS: "In other crowds",
    Collection.RIDER: "What the rider adds",
    Collection.CHANGING: "When the way is not as the map has it",
}
