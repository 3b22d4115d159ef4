"""World of a live ride: a platform and its ride, built in a thread, since that takes seconds."""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import CohelmError
from cohelm.live.control.added_people import (
    WalkableFloor,
    crossing_pedestrian,
    new_pedestrian,
    walkable_floor,
)
from cohelm.live.control.step_timing import Wait
from cohelm.live.messages import ChangeSimulation
from cohelm.messages import Decision, Observation
from cohelm.platforms import Platform, SimulatedWorld, is_simulated, open_platform
from cohelm.reasons import Reason
from cohelm.scenarios import RideSetup, Scenario
from cohelm.scenarios.build import build_scenario
from cohelm.simulation import GroundTruth, World, generator, is_standing

_WARM_UP_STEPS = 5
_POLL_PERIOD = 0.1
"""Time between two polls of ``when``, s."""
_log = logging.getLogger(__name__)


class WorldError(CohelmError):
    """The world cannot be built, for a reason that is not the scenario's."""

    code = "world_failed"


class NotSimulated(CohelmError):
    """Change of the world that only a simulation can make."""

    code = "not_simulated"


class DoorError(CohelmError):
    """The door does not exist, or a person stands in it."""

    code = "door"


class LiveWorld:
    """Platform of a live ride, and the changes that a page may make in a simulated one.

    Args:
        ride_setup: Floor, chair and parts.
        platform: Open platform; closed by :meth:`close`.
        floor: Walkable floor of a simulation; None: people cannot be added.
        rng: Random stream of added people.
    """

    def __init__(
        self,
        ride_setup: RideSetup,
        platform: Platform,
        floor: WalkableFloor | None,
        rng: np.random.Generator,
    ) -> None:
        self.ride_setup, self._platform = ride_setup, platform
        self._floor, self._rng = floor, rng
        self._world = platform.capabilities.world
        self.observation: Observation = platform.observe()
        """Observation of the current control step."""
        self._applied_at = self.observation.pose

    @property
    def simulated(self) -> bool:
        """True if the chair is simulated in this process."""
        return self._world is not None

    @property
    def wait(self) -> Wait | None:
        """Wait for a reading of the leading sensor; see ``Capabilities``."""
        return self._platform.capabilities.wait

    @property
    def truth(self) -> GroundTruth | None:
        """Ground truth, for logs and the page only; None: the chair is real."""
        return self._world.truth if self._world is not None else None

    @property
    def accident(self) -> Reason | None:
        """Accident of a simulated chair: it touches a person or a wall, or fell."""
        truth = self.truth
        if truth is not None and truth.fell:
            return Reason.FELL
        touches = truth is not None and (bool(truth.hit_moving.any()) or truth.hit_wall)
        return Reason.COLLISION if touches else None

    @property
    def shut(self) -> frozenset[int]:
        """Indices of the doors that are shut."""
        return self._world.shut if self._world is not None else frozenset()

    @property
    def twist(self) -> Floats:
        """Motion (3,) of the chair: the true one in a simulation, else that of its odometry."""
        return self._world.truth.twist if self._world is not None else self.observation.twist

    @property
    def stands(self) -> bool:
        """True if the chair stands."""
        return bool(is_standing(self.twist))

    def time(self, now: float) -> float:
        """Time in which answers age, s: that of a simulation, else ``now`` of a monotonic clock."""
        return self._world.truth.time if self._world is not None else now

    def sense(self) -> None:
        """Take the observation of the next control step.

        Raises:
            PlatformError: The chair is lost.
        """
        self.observation = self._platform.observe()

    def apply(self, decision: Decision) -> float:
        """Send a decision to the wheels; return the distance driven since the previous one, m.

        Raises:
            PlatformError: The chair is lost.
        """
        if self._world is not None:
            before = self._world.truth.pose
            self._platform.apply(decision)
            after = self._world.truth.pose
        else:
            self._platform.apply(decision)
            before, after = self._applied_at, self.observation.pose
            self._applied_at = after
        return float(np.hypot(*(after[:2] - before[:2])))

    def close(self) -> None:
        """Stop the wheels and release the platform."""
        self._platform.close()

    def change(self, command: ChangeSimulation, route: Floats) -> None:
        """Add a person, or move a door.

        Args:
            command: Command of a page.
            route: (k, 2) route of the chair, m; empty: none.

        Raises:
            CohelmError: The change is not possible.
        """
        world = self._world
        if world is None or self._floor is None:
            raise NotSimulated("Only a simulation can do that.")
        if command.action == "door":
            self._move_door(world, command)
            return
        if command.action == "crossing_person":
            person = crossing_pedestrian(self._floor, world.truth, route, self._rng)
        else:
            point = None if command.point is None else np.array(command.point)
            person = new_pedestrian(self._floor, world.truth, point, self._rng)
        world.spawn(person)

    def _move_door(self, world: SimulatedWorld, command: ChangeSimulation) -> None:
        if command.door is None or command.door >= len(self.ride_setup.world.doors):
            raise DoorError("There is no such door.")
        if not world.set_door(command.door, shut=command.on):
            raise DoorError("A person stands in this door.")


class WorldFactory:
    """Builds one world at a time, in a thread of its own.

    Args:
        scenario: Scenario of all worlds.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._results: queue.SimpleQueue[LiveWorld | CohelmError] = queue.SimpleQueue()
        self.busy = False
        """True from :meth:`start` until :meth:`finished` has returned the result."""

    def start(self, seed: int, when: Callable[[], bool]) -> None:
        """Start to build a world.

        Args:
            seed: Its random seed.
            when: Polled in the thread; building begins once it returns True.
        """
        self.busy = True
        thread = threading.Thread(target=self._build, args=(seed, when), name="world", daemon=True)
        thread.start()

    def finished(self) -> LiveWorld | None:
        """Return a world that was finished since the last call; None: there is none.

        Raises:
            CohelmError: The world cannot be built; any other failure becomes a :class:`WorldError`.
        """
        try:
            result = self._results.get_nowait()
        except queue.Empty:
            return None
        self.busy = False
        if isinstance(result, CohelmError):
            raise result
        return result

    def _build(self, seed: int, when: Callable[[], bool]) -> None:
        try:
            while not when():
                time.sleep(_POLL_PERIOD)
            world = build_world(self._scenario, seed)
        except CohelmError as error:  # raised again by finished() in the control thread
            self._results.put(error)
        except Exception as error:  # must not end the drive in the old world
            _log.exception("the world could not be built")
            self._results.put(WorldError(f"The simulation could not be built: {error!r}."))
        else:
            self._results.put(world)


def build_world(scenario: Scenario, seed: int) -> LiveWorld:
    """Build a world, compiled and loaded.

    Raises:
        CohelmError: The scenario cannot be built.
    """
    ride_setup = build_scenario(scenario, seed)
    if is_simulated(scenario):
        _warm_up(World(ride_setup.world, ride_setup.seed))
    platform = open_platform(ride_setup)
    floor = walkable_floor(ride_setup) if platform.capabilities.simulation else None
    return LiveWorld(ride_setup, platform, floor, generator(seed, "added"))


def _warm_up(world: World) -> None:
    """Advance a spare world a little, so that its code is compiled and loaded."""
    for _ in range(_WARM_UP_STEPS):
        world.advance(Decision(twist=np.array([0.1, 0.0, 0.1])))
