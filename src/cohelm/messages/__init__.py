"""The values that pass between the stages. Read this package first.

    scan ─► people ─► predictions ─► spaces ──────┐
    goal ─► path ───► reference ─┐                ├─► local plan ─► decision ─► wheels
    rider ─► authority ──────────┴► shared ref. ──┘

All values are frozen and check the shapes of their arrays (``arrays.value``). SI units and REP-103
(metres, seconds, radians, x forward, y left); positions and poses are in the map frame unless a
field states another. A *twist* is (v_x, v_y, ω) in the robot frame. Dimensions: n people, h
hypotheses a person, N horizon steps (N+1 states), k points. ``navigation.tick.Tick`` binds all
values of one step; it lives there because it also holds the memory of each stage.
"""

from cohelm.messages.decision import Decision, LocalPlan, Status
from cohelm.messages.destinations import DestinationBelief, DestinationOffer
from cohelm.messages.environment import Crowding, LiveObstacles, Sensing
from cohelm.messages.observation import (
    Inertial,
    Observation,
    PointCloud,
    RiderCommand,
    Scan,
)
from cohelm.messages.people import Groups, GroupSpaces, People, Predictions, SocialSpaces
from cohelm.messages.plan import Authority, Path, Reference, WishReport
from cohelm.messages.request import Mode, Request, RiderProfile, Side, Wish
from cohelm.reasons import OfferReason, Reason

__all__ = [
    "Authority",
    "Crowding",
    "Decision",
    "DestinationBelief",
    "DestinationOffer",
    "GroupSpaces",
    "Groups",
    "Inertial",
    "LiveObstacles",
    "LocalPlan",
    "Mode",
    "Observation",
    "OfferReason",
    "Path",
    "People",
    "PointCloud",
    "Predictions",
    "Reason",
    "Reference",
    "Request",
    "RiderCommand",
    "RiderProfile",
    "Scan",
    "Sensing",
    "Side",
    "SocialSpaces",
    "Status",
    "Wish",
    "WishReport",
]
