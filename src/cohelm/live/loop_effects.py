"""Commands of pages that need the control loop: changes of the world, route previews, ratings."""

from __future__ import annotations

import numpy as np

from cohelm.live.control.world_factory import NotSimulated
from cohelm.live.control_loop import ControlLoop, NotPossibleNow
from cohelm.live.messages import ChangeSimulation, Destination, PlanTrip
from cohelm.live.page.route_preview import TripQuestion
from cohelm.live.services import Services
from cohelm.reasons import Reason


class LoopEffects:
    """Effects of commands on the control loop; see ``commands.CommandEffects``.

    Args:
        loop: Loop of the drive.
        services: Its helpers.
    """

    def __init__(self, loop: ControlLoop, services: Services) -> None:
        self._loop, self._services = loop, services

    def change_simulation(self, command: ChangeSimulation) -> None:
        """Change the simulated world.

        Raises:
            CohelmError: The change is not possible.
        """
        cycle = self._loop.cycle
        if cycle.world is not None and not cycle.world.simulated:
            raise NotSimulated("Only a simulation can do that.")
        if command.action == "restart":
            self._loop.restart_world(command.seed)
            return
        if cycle.world is None:
            raise NotPossibleNow(Reason.STARTING.sentence)
        if command.action == "pause":
            cycle.pause(on=command.on)
            return
        route = cycle.view.route
        points = np.array(route.points if route is not None else ()).reshape(-1, 2)
        cycle.world.change(command, points)

    def plan_trip(self, client: str, trip: PlanTrip, goal: Destination) -> None:
        """Request the routes to a destination; the answer comes later."""
        self._services.route_preview.request(
            client, TripQuestion(trip, goal, self._services.rides.rider)
        )

    def rate(self, ride: str, rating: int) -> None:
        """Store a rating.

        Raises:
            StoreError: There is no such ride.
        """
        self._services.rides.rate(ride, rating)
