"""State that the driver's messages change: the link to the driver, and the mission."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from cohelm.live.control import driver_link
from cohelm.live.control.driver_link import LinkState
from cohelm.live.control.mission import Mission
from cohelm.live.control.world_factory import LiveWorld
from cohelm.reasons import Reason


@dataclass(slots=True)
class DriverState:
    """Link to the driver, and the mission. Only the control thread reads and changes it."""

    link: LinkState = field(default_factory=LinkState)
    mission: Mission = field(default_factory=Mission)

    def stop_until_confirmed(self, cause: Reason) -> None:
        """Stop the chair until the driver confirms."""
        self.link = driver_link.stop_until_confirmed(self.link, cause)

    def sense(self, world: LiveWorld, now: float, *, dead_zone: float) -> None:
        """Take the observation of the next control step, and with it a real chair's own stick.

        Args:
            world: Chair; a simulated rider gives way to the driver.
            now: s of the control loop's clock.
            dead_zone: Deflection up to which a stick counts as centred.

        Raises:
            PlatformError: The chair is lost.
        """
        world.sense()
        rider = None if world.simulated else world.observation.rider
        if rider is None:
            self.link = replace(self.link, chair_stick=None)
            return
        forward, left = (float(each) for each in rider.deflection)
        at = now - max(world.observation.time - rider.heartbeat, 0.0)
        self.link = driver_link.on_chair_stick(self.link, (forward, left), at, dead_zone=dead_zone)

    def require_centring(self) -> None:
        """Ignore the stick until it has been centred once."""
        self.link = driver_link.require_centring(self.link)

    def require_confirmation_of_trip(self) -> None:
        """Ask the driver to confirm if a destination was chosen before the chair was ready."""
        if self.mission.under_way:
            self.link = driver_link.require_confirmation(self.link)

    def arrive(self) -> str:
        """End the trip at its destination; returns what the rider is told."""
        goal = self.mission.goal
        self.mission = self.mission.with_goal(None)
        self.require_centring()
        return f"You have arrived: {goal.name}." if goal and goal.name else Reason.ARRIVED.sentence

    def clear_mission(self) -> None:
        """Remove destination and wishes; mode and pace stay."""
        self.mission = self.mission.with_goal(None)
