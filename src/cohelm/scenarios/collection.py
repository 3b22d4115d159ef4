"""Headings under which scenarios are listed."""

from __future__ import annotations

from enum import StrEnum


class Collection(StrEnum):
    """Collections of scenarios, in the order of a listing."""

    OWN = "own"
    """Scenarios of the user; the default of a file that names no collection."""
    BUILDING = "building"
    GLOBAL = "paper-global"
    STATIC = "paper-static"
    DYNAMIC = "paper-dynamic"
    CARDS = "cards"
    CROWDS = "crowds"
    RIDER = "rider"
    CHANGING = "changing"
    SHARING = "sharing"
    DOORWAYS = "doorways"
    CIRCUITS = "circuits"
    FLOORS = "floors"

    @property
    def heading(self) -> str:
        """Heading of the listing."""
        return _HEADINGS[self]


_HEADINGS = {
    Collection.OWN: "Your own",
    Collection.BUILDING: "Across a building",
    Collection.GLOBAL: "Global planning in semi-open offices (Xu et al., Table 2)",
    Collection.STATIC: "Narrow corridors (Xu et al., static)",
    Collection.DYNAMIC: "Among a few people (Xu et al., Table 3)",
    Collection.CARDS: "Social navigation cards (Francis et al. 2023)",
    Collection.CROWDS: "Other crowds",
    Collection.RIDER: "Rider and chair together",
    Collection.CHANGING: "Obstacles and doors that are not on the map",
    Collection.SHARING: "Knowledge split between rider and chair",
    Collection.DOORWAYS: "Narrow places",
    Collection.CIRCUITS: "Circuits of clinical trials",
    Collection.FLOORS: "Floors with edges, steps and slopes",
}
