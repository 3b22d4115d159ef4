"""Fault injection between world and navigator."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from cohelm.arrays import Booleans, Floats, replace
from cohelm.geometry import transform
from cohelm.maps import OccupancyGrid, distance_field
from cohelm.messages import Decision, Observation
from cohelm.simulation.drivetrain import DriveCommand
from cohelm.simulation.faults.api import FaultInput, FaultMemory
from cohelm.simulation.faults.drive import received, true_twist, weakened
from cohelm.simulation.faults.fault import Fault
from cohelm.simulation.faults.kinds import FAULT_KINDS
from cohelm.simulation.faults.people import unseen_people
from cohelm.simulation.random_streams import generator

HISTORY = 2.0
"""Time for which sound input is kept, s: the longest delay."""
_DIRECTIONS = 64
_ROOM = 0.8
"""Distance from walls at the place to which a chair is carried, and ``_AHEAD`` of it, m."""
_AHEAD = 0.5
"""m: nearer walls are hit even if the chair notices the carry within 0.25 s and brakes."""
_ROOM_PEOPLE = 2.5
"""Distance from people there, m: the outline (0.7), and what chair (0.4) and person (1.1) travel
until a chair that notices the carry within 0.25 s stands; nearer ones touch it in any case."""

Streams = Callable[[int, str], np.random.Generator]
"""Generator for a fault's index and a purpose; ``moving`` goes on, ``pattern`` begins anew."""


def with_faults(
    observation: Observation, faults: tuple[Fault, ...], memory: FaultMemory, streams: Streams
) -> tuple[Observation, FaultMemory]:
    """Apply the faults that are active at the time of the observation, in order.

    Returns:
        (the observation as delivered, the memory for the next call).
    """
    if not faults:
        return observation, memory
    now, sound = observation.time, observation
    recent = (*(o for o in memory.recent if o.time > now - HISTORY), sound)
    held = memory.held or (None,) * len(faults)
    held_scans = memory.held_scans or ((),) * len(faults)
    scans = sound.scans or memory.scans
    before = memory.recent[-1] if memory.recent else None
    for i, fault in enumerate(faults):
        effect = FAULT_KINDS[fault.kind].effect
        if effect is None or not fault.active(now):
            continue
        if held[i] is None:
            known = {tuple(c.mount): c for each in recent for c in each.clouds if each is not sound}
            kept = replace(before or sound, clouds=tuple(known.values()) or sound.clouds)
            held = (*held[:i], kept, *held[i + 1 :])
            held_scans = (*held_scans[:i], memory.scans or scans, *held_scans[i + 1 :])
        given = FaultInput(
            fault=fault,
            time=now,
            last=memory.last,
            held=held[i] or sound,
            held_scans=held_scans[i],
            recent=recent,
            rng=streams(i, "moving"),
            pattern=streams(i, "pattern"),
        )
        observation = effect(observation, given)
    after = FaultMemory(
        last=observation, recent=recent, scans=scans, held=held, held_scans=held_scans
    )
    return observation, after


class FaultInjector:
    """Faults of one ride; only its memory and random streams change.

    Args:
        faults: of the ride.
        seed: of the ride.
    """

    def __init__(self, faults: tuple[Fault, ...], seed: int) -> None:
        self._faults, self._seed = faults, seed
        self._moving = [generator(seed, f"fault {i}") for i in range(len(faults))]
        self._memory = FaultMemory()
        self._sent: list[tuple[float, Decision]] = []
        self._arrived = Decision(twist=np.zeros(3))
        self._carried: dict[int, Floats] = {}

    def branch(self, faults: tuple[Fault, ...]) -> FaultInjector:
        """Injector of other faults with the sound input so far; no fault may have begun yet."""
        out = FaultInjector(faults, self._seed)
        out._memory = replace(self._memory, held=(), held_scans=())
        out._sent, out._arrived = list(self._sent), self._arrived
        return out

    def observed(self, observation: Observation) -> Observation:
        """Observation as the navigator gets it."""
        if not self._faults:
            return observation
        shift = self._shift(observation.time)
        if shift.any():
            observation = replace(observation, pose=observation.pose - shift)
        delivered, self._memory = with_faults(observation, self._faults, self._memory, self._stream)
        return delivered

    def received(self, decision: Decision, time: float) -> Decision:
        """Decision as the motor controller gets it."""
        if not self._faults:
            return decision
        self._sent = [each for each in self._sent if each[0] > time - HISTORY] + [(time, decision)]
        rng = self._moving[0]
        self._arrived = received(self._sent, self._active(time), time, rng, self._arrived)
        return self._arrived

    def command(self, command: DriveCommand, time: float) -> DriveCommand:
        """Command with the ramps of faulty motors and brakes."""
        return weakened(command, self._active(time)) if self._faults else command

    def twist(self, twist: Floats, time: float) -> Floats:
        """True twist (3,) of a chair whose motors should give ``twist``."""
        return true_twist(twist, self._active(time)) if self._faults else twist

    def unseen(self, n: int, time: float) -> Booleans:
        """Mask (n,) of the people whom no sensor sees now."""
        out = np.zeros(n, dtype=np.bool_)
        for i, fault in enumerate(self._faults):
            if fault.kind == "people_lost" and fault.active(time):
                out |= unseen_people(n, fault.size, self._stream(i, "pattern"))
        return out

    def carried(self, pose: Floats, grid: OccupancyGrid, bodies: Floats, time: float) -> Floats:
        """Pose (3,) of the chair, elsewhere if it is carried away now.

        Args:
            pose: (3,) true pose.
            grid: true obstacles.
            bodies: (n, 3) people as (x, y, radius), m.
            time: s.
        """
        for i, fault in enumerate(self._faults):
            if fault.kind == "kidnapped" and fault.active(time) and i not in self._carried:
                angles = self._stream(i, "pattern").permutation(_DIRECTIONS)
                self._carried[i] = _free_shift(
                    pose, fault.size, 2.0 * math.pi * angles / _DIRECTIONS, grid, bodies
                )
                pose = pose + self._carried[i]
        return pose

    def _shift(self, time: float) -> Floats:
        """Sum (3,) of the shifts of which the localiser was not told."""
        shifts = [s for i, s in self._carried.items() if self._faults[i].active(time)]
        return np.sum(shifts, axis=0) if shifts else np.zeros(3)

    def _active(self, time: float) -> list[Fault]:
        return [fault for fault in self._faults if fault.active(time)]

    def _stream(self, index: int, purpose: str) -> np.random.Generator:
        if purpose == "moving":
            return self._moving[index]
        return generator(self._seed, f"fault {index} pattern")


def _free_shift(
    pose: Floats, distance: float, angles: Floats, grid: OccupancyGrid, bodies: Floats
) -> Floats:
    """First shift (3,) to a place with room; zero if there is none."""
    walls = distance_field(grid)
    for angle in angles:
        point = pose[:2] + transform([0.0, 0.0, angle], np.array([distance, 0.0]))
        x0, y0, x1, y1 = grid.bounds
        inside = x0 < point[0] < x1 and y0 < point[1] < y1
        apart = np.hypot(*(bodies[:, :2] - point).T) - bodies[:, 2] if len(bodies) else np.inf
        ahead = transform([*point, pose[2]], np.array([_AHEAD, 0.0]))
        free = min(float(walls.at(point)), float(walls.at(ahead))) > _ROOM
        if inside and free and np.min(apart) > _ROOM_PEOPLE:
            return np.array([*(point - pose[:2]), 0.0])
    return np.zeros(3)
