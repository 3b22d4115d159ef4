"""The world that is driven in: made aside, because that takes seconds, and begun anew at will."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cohelm.arrays import Floats
from cohelm.driving.messages import Simulate
from cohelm.driving.simulated import Ground, ground, into_the_way, somebody
from cohelm.errors import CohelmError
from cohelm.evaluation import Scenario, Stage
from cohelm.evaluation.staging import set_stage
from cohelm.messages import Decision
from cohelm.simulation import World, generator

_STEPS = 5


@dataclass(slots=True)
class Play:
    """A world with what may be done to it."""

    stage: Stage
    world: World
    ground: Ground
    chance: np.random.Generator
    """Of who is added."""

    def do(self, asked: Simulate, route: Floats) -> None:
        """Let somebody come, or move a door.

        Args:
            asked: what.
            route: (k, 2) the way that the chair follows, m; empty: none.

        Raises:
            CohelmError: why not.
        """
        if asked.what == "door":
            self._door(asked)
            return
        truth = self.world.truth
        if asked.what == "walker":
            self.world.admit(into_the_way(self.ground, truth, route, self.chance))
            return
        point = None if asked.point is None else np.array(asked.point)
        self.world.admit(somebody(self.ground, truth, point, self.chance))

    def _door(self, asked: Simulate) -> None:
        if asked.door is None or asked.door >= len(self.stage.world.doors):
            raise NoDoor("There is no such door.")
        if not self.world.set_door(asked.door, shut=asked.on):
            raise NoDoor("Somebody stands in that door.")


class NoDoor(CohelmError):
    """A door that is not there, or does not shut; says why."""

    code = "no_door"


class Playing:
    """Worlds being made; one at a time, in a thread of its own.

    Args:
        scenario: of which.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._made: queue.SimpleQueue[Play | Exception] = queue.SimpleQueue()
        self.busy = False

    def make(self, seed: int, when: Callable[[], bool]) -> None:
        """Begin to make one.

        Args:
            seed: of all its chance.
            when: asked now and then; it is begun once that is so.
        """
        self.busy = True
        thread = threading.Thread(target=self._make, args=(seed, when), name="stage", daemon=True)
        thread.start()

    def made(self) -> Play | None:
        """The one that has become ready since this was last asked; None: none.

        Raises:
            CohelmError: if there can be none.
        """
        try:
            found = self._made.get_nowait()
        except queue.Empty:
            return None
        self.busy = False
        if isinstance(found, Exception):
            raise found
        return found

    def _make(self, seed: int, when: Callable[[], bool]) -> None:
        waiting = threading.Event()
        while not when():
            waiting.wait(0.1)
        try:
            stage = set_stage(self._scenario, seed)
            _tried(World(stage.world, stage.seed))
            world = World(stage.world, stage.seed)
            play = Play(stage, world, ground(stage), generator(seed, "added"))
        except Exception as trouble:  # whatever it is, the chair's thread tells it
            self._made.put(trouble)
        else:
            self._made.put(play)


def _tried(world: World) -> None:
    """Let some time pass in a world that nobody sees, so that all of it is compiled and read."""
    for _ in range(_STEPS):
        world.advance(Decision(twist=np.array([0.1, 0.0, 0.1])))
