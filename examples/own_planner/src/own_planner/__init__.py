"""A local planner of one's own."""

from own_planner.give_way import GiveWay

__all__ = ["GiveWay"]
