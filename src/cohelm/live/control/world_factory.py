"""Simulated world of a live ride: built in a thread, since that takes seconds, and restartable."""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import CohelmError
from cohelm.live.control.added_people import (
    WalkableFloor,
    crossing_pedestrian,
    new_pedestrian,
    walkable_floor,
)
from cohelm.live.messages import ChangeSimulation
from cohelm.messages import Decision
from cohelm.scenarios import RideSetup, Scenario
from cohelm.scenarios.build import build_scenario
from cohelm.simulation import World, generator

_WARM_UP_STEPS = 5
_POLL_PERIOD = 0.1
"""Time between two polls of ``when``, s."""
_log = logging.getLogger(__name__)


class WorldError(CohelmError):
    """The world cannot be built, for a reason that is not the scenario's."""

    code = "world_failed"


class DoorError(CohelmError):
    """The door does not exist, or a person stands in it."""

    code = "door"


@dataclass(slots=True)
class LiveWorld:
    """Simulated world, and the changes that a page may make in it."""

    ride_setup: RideSetup
    simulation: World
    floor: WalkableFloor
    rng: np.random.Generator
    """Random stream of added people."""

    def change(self, command: ChangeSimulation, route: Floats) -> None:
        """Add a person, or move a door.

        Args:
            command: Command of a page.
            route: (k, 2) route of the chair, m; empty: none.

        Raises:
            CohelmError: The change is not possible.
        """
        if command.action == "door":
            self._move_door(command)
            return
        truth = self.simulation.truth
        if command.action == "crossing_person":
            person = crossing_pedestrian(self.floor, truth, route, self.rng)
        else:
            point = None if command.point is None else np.array(command.point)
            person = new_pedestrian(self.floor, truth, point, self.rng)
        self.simulation.spawn(person)

    def _move_door(self, command: ChangeSimulation) -> None:
        if command.door is None or command.door >= len(self.ride_setup.world.doors):
            raise DoorError("There is no such door.")
        if not self.simulation.set_door(command.door, shut=command.on):
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
            self._results.put(WorldError(f"the simulation could not be built: {error!r}"))
        else:
            self._results.put(world)


def build_world(scenario: Scenario, seed: int) -> LiveWorld:
    """Build a world, compiled and loaded.

    Raises:
        CohelmError: The scenario cannot be built.
    """
    ride_setup = build_scenario(scenario, seed)
    _warm_up(World(ride_setup.world, ride_setup.seed))
    return LiveWorld(
        ride_setup=ride_setup,
        simulation=World(ride_setup.world, ride_setup.seed),
        floor=walkable_floor(ride_setup),
        rng=generator(seed, "added"),
    )


def _warm_up(world: World) -> None:
    """Advance a spare world a little, so that its code is compiled and loaded."""
    for _ in range(_WARM_UP_STEPS):
        world.advance(Decision(twist=np.array([0.1, 0.0, 0.1])))
