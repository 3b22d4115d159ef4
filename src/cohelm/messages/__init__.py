"""Every value that flows: the language of the project. Read this package first.

    scan ─► people ─► predictions ─► spaces ──────┐
    goal ─► path ───► reference ─┐                ├─► local plan ─► decision ─► wheels
    rider ─► authority ──────────┴► shared ref. ──┘

All values are frozen and check the shapes of their arrays (``arrays.value``). SI units and REP-103
(metres, seconds, radians, x forward, y left); positions and poses are in the map frame unless a
field says otherwise. A *twist* is (v_x, v_y, ω) in the robot frame. n people, h hypotheses a
person, N horizon steps (N+1 states), k points. The ``Tick``, which binds them all, is in
``navigation.tick``, because it also holds each stage's memory.
"""

from cohelm.messages.decided import Decision, LocalPlan, Status
from cohelm.messages.given import (
    Mode,
    Observation,
    People,
    PointCloud,
    Request,
    RiderCommand,
    RiderProfile,
    Scan,
    Side,
    Wish,
)
from cohelm.messages.planned import Authority, Path, Reference, WishReport
from cohelm.messages.seen import (
    Crowding,
    Groups,
    GroupSpaces,
    LiveObstacles,
    Predictions,
    Sensing,
    SocialSpaces,
)
from cohelm.reasons import Reason

__all__ = [
    "Authority",
    "Crowding",
    "Decision",
    "GroupSpaces",
    "Groups",
    "LiveObstacles",
    "LocalPlan",
    "Mode",
    "Observation",
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
