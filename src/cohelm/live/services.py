"""Helpers of the control loop that have a process, a thread or files of their own."""

from __future__ import annotations

from dataclasses import dataclass

from cohelm.live.control.navigator_client import NavigatorClient
from cohelm.live.control.world_factory import WorldFactory
from cohelm.live.page.route_preview import RoutePreview
from cohelm.live.ride_tracker import RideTracker


@dataclass(frozen=True, slots=True, kw_only=True)
class Services:
    """Helpers of the control loop."""

    navigator: NavigatorClient
    route_preview: RoutePreview
    world_factory: WorldFactory
    rides: RideTracker
