"""The true world: a chair, its rider, the people about it, and what the chair's sensors tell.

``observe`` gives what the navigator may know, ``advance`` takes what it decided, ``truth`` is for
the referee alone. Every source of chance has a generator of its own, named by its purpose, so that
one more sensor does not change what the people do; the same set-up and seed give the same ride bit
for bit.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.geometry import transform
from cohelm.maps import OccupancyGrid
from cohelm.messages import Decision, Observation, People
from cohelm.robots import Robot
from cohelm.simulation.api import Crowd, RiderAct, RiderView, Scene
from cohelm.simulation.chance import generator
from cohelm.simulation.changes import is_clear, present
from cohelm.simulation.contact import gap_to_people, gap_to_walls
from cohelm.simulation.crowds.steps import between, went
from cohelm.simulation.doorways import on_the_way, with_shut
from cohelm.simulation.drive import Wheels, at_rest, drive, ordered
from cohelm.simulation.eyes import seen_by
from cohelm.simulation.faults import with_faults
from cohelm.simulation.newcomers import Newcomer, joined
from cohelm.simulation.senses import Sensed, Senses
from cohelm.simulation.sensors.figures import STEP_LENGTH, Bodies
from cohelm.simulation.sensors.localisation import with_error
from cohelm.simulation.sensors.scenery import Scenery
from cohelm.simulation.setting import WorldSetup

STANDING = 0.02
"""A chair slower than this stands, m/s …"""
STANDING_TURN = 0.05
"""… if it does not turn faster than this either, rad/s."""
STATURE = 1.7
"""Height of people of whom nothing is said, m."""
_ROUNDING = 1e-6
"""More than what a gap may be wrong by, m."""


@value
class Truth:
    """The true state, and what has touched since the last one. n people."""

    time: float
    """s."""
    pose: Annotated[Floats, Shape("3")]
    """X_MR."""
    twist: Annotated[Floats, Shape("3")]
    """Robot frame."""
    crowd: Crowd
    gap_people: Annotated[Floats, Shape("n")]
    """Footprint to body now, m; negative where they overlap, +inf for who is not there."""
    gap_wall: float
    """Footprint to the nearest occupied cell now, m; +inf without any."""
    hit_moving: Annotated[Booleans, Shape("n")]
    """Touched since the last truth, while the chair moved."""
    hit_standing: Annotated[Booleans, Shape("n")]
    """Touched since the last truth, while the chair stood."""
    hit_wall: bool
    """A wall was touched since the last truth."""


class World:
    """One ride's world; the only thing in it that changes.

    Args:
        setup: what there is.
        seed: of all chance, ≥ 0.
    """

    def __init__(self, setup: WorldSetup, seed: int) -> None:
        self.setup = setup
        self._random = {
            purpose: generator(seed, purpose)
            for purpose in (
                "people", "localisation", "odometry", "rider", "strides", "newcomers"
            )
        }  # fmt: skip
        self._ticks = 0
        self._shut: frozenset[int] = frozenset()
        self._open = setup.grid
        self._scenery = Scenery(
            grid=setup.grid,
            heights=setup.heights,
            wall_height=setup.wall_height,
            ceiling=setup.ceiling,
        )
        self._senses = Senses(setup.robot, seed)
        self._walked = self._random["strides"].uniform(
            0.0, 2.0 * STEP_LENGTH * STATURE, len(setup.crowd.radius)
        )
        statures = setup.statures
        self._statures = np.full_like(self._walked, STATURE) if statures is None else statures
        self._wheels = at_rest(setup.robot, setup.start)
        self._act: RiderAct | None = None
        self._error = setup.localisation.first(self._random["localisation"])
        self._truth = self._judged(setup.crowd, nobody_touched(setup.crowd), touched_wall=False)
        sensed = self._sense(0.0, setup.crowd, setup.crowd, 1.0)
        self._observation = self._told(sensed, last=None)

    @property
    def truth(self) -> Truth:
        """How things are; not for the navigator."""
        return self._truth

    def observe(self) -> Observation:
        """What the chair knows now; the same until the world advances."""
        return self._observation

    def advance(self, decision: Decision) -> None:
        """Let one control step pass under ``decision``.

        Contact does not stop the world; who rides on after it decides.
        """
        setup = self.setup
        before, stood = self._truth.crowd, self.grid
        standing = self._standing()
        if standing is not stood:
            self._scenery = replace(self._scenery, grid=standing)
        steps = max(round(setup.control_step / setup.physics_step), 1)
        dt = setup.control_step / steps
        start = self._ticks * setup.control_step
        after = setup.pedestrian_model.step(
            before, self._scene(), setup.control_step, self._random["people"]
        )
        sensed = Sensed()
        order = ordered(setup.robot, decision)
        touched = nobody_touched(before)
        touched_wall = False
        clearance = self._truth.gap_wall if self.grid is stood else 0.0
        there = before.there & after.there
        way = np.hypot(*went(before, after).T)
        room = float((self._truth.gap_people - way).min(initial=np.inf))
        for k in range(1, steps + 1):
            old = self._wheels
            self._wheels = drive(setup.robot, old, order, dt)
            swept = _swept(setup.robot, old, self._wheels)
            room, clearance = room - swept, clearance - swept
            if room <= _ROUNDING:  # else nobody can have come so near
                gaps = self._gaps(between(before, after, k / steps), before.radius, there)
                touched[int(is_standing(self._wheels.twist))] |= gaps <= 0.0
            if clearance <= 0.0:
                clearance = gap_to_walls(setup.robot.outline, self._wheels.pose, self.grid)
                touched_wall |= clearance <= 0.0
            time = start + k * dt
            if self._senses.are_due(time):
                sensed += self._sense(time, before, after, k / steps)
        self._walked += way
        self._ticks += 1
        self._truth = self._judged(after, touched, touched_wall=touched_wall)
        self._error = setup.localisation.after(
            self._error, setup.control_step, self._random["localisation"]
        )
        self._observation = self._told(sensed, last=self._observation)

    def admit(self, newcomer: Newcomer) -> int:
        """Let somebody come in now, between two steps; their number, behind everybody else's.

        Without it a ride is what it was before; with it, from here on another one, and the same
        again for the same newcomers at the same times.
        """
        truth, crowd = self._truth, joined(self._truth.crowd, newcomer)
        phase = self._random["newcomers"].uniform(0.0, 2.0 * STEP_LENGTH * newcomer.stature)
        self._walked = np.append(self._walked, phase)
        self._statures = np.append(self._statures, newcomer.stature)
        self._truth = replace(
            truth,
            crowd=crowd,
            gap_people=self._gaps(crowd.position, crowd.radius, crowd.there),
            hit_moving=np.append(truth.hit_moving, np.False_),
            hit_standing=np.append(truth.hit_standing, np.False_),
        )
        return len(crowd.radius) - 1

    def set_door(self, door: int, *, shut: bool) -> bool:
        """Shut or open one of the set-up's doors, from the next step on.

        Returns:
            whether it is so; a door stays open whose leaf would come within 0.1 m of a person, of
            the chair, or of where the chair could still stop.

        Raises:
            IndexError: if there is no such door.
        """
        if not 0 <= door < len(self.setup.doors):
            raise IndexError(f"there are {len(self.setup.doors)} doors, and none is {door}")
        wanted = self._shut | {door} if shut else self._shut - {door}
        if wanted != self._shut and shut:
            robot, wheels, bodies = self.setup.robot, self._wheels, self._bodies()
            way = on_the_way(robot.outline, wheels.pose, wheels.twist, robot.max_deceleration)
            then, now = self._with_doors(wanted), self._with_doors(self._shut)
            if not all(is_clear(then, now, outline, bodies) for outline in way):
                return False
        self._shut = wanted
        return True

    @property
    def shut(self) -> frozenset[int]:
        """The set-up's doors that are shut."""
        return self._shut

    def _with_doors(self, shut: frozenset[int]) -> OccupancyGrid:
        return with_shut(self._open, tuple(self.setup.doors[door] for door in sorted(shut)))

    def _standing(self) -> OccupancyGrid:
        """What stands there now; a timed door waits for whoever is in it."""
        outline = transform(self._wheels.pose, self.setup.robot.outline)
        self._open = present(self.setup.changes, self._open, self._now, outline, self._bodies())
        return self._with_doors(self._shut)

    def _bodies(self) -> Floats:
        """People who are there, (n, 3) as (x, y, radius), m."""
        crowd = self._truth.crowd
        return np.column_stack([crowd.position, crowd.radius])[crowd.there]

    @property
    def grid(self) -> OccupancyGrid:
        """What truly stands there now; not for the navigator."""
        return self._scenery.grid

    @property
    def _now(self) -> float:
        return self._ticks * self.setup.control_step

    def _judged(self, crowd: Crowd, touched: Booleans, *, touched_wall: bool) -> Truth:
        pose, outline = self._wheels.pose, self.setup.robot.outline
        return Truth(
            time=self._now,
            pose=pose,
            twist=self._wheels.twist,
            crowd=crowd,
            gap_people=self._gaps(crowd.position, crowd.radius, crowd.there),
            gap_wall=gap_to_walls(outline, pose, self.grid),
            hit_moving=touched[0],
            hit_standing=touched[1],
            hit_wall=touched_wall,
        )

    def _gaps(self, position: Floats, radius: Floats, there: Booleans) -> Floats:
        """From the footprint to each body (n,), m; +inf for who is not there."""
        gaps = gap_to_people(self.setup.robot.outline, self._wheels.pose, position, radius)
        return np.where(there, gaps, np.inf)

    def _scene(self) -> Scene:
        """The chair as pedestrians meet it: the disc about its footprint."""
        robot, wheels = self.setup.robot, self._wheels
        low, high = robot.outline.min(axis=0), robot.outline.max(axis=0)
        centre = (low + high) / 2.0
        vx, vy, turn = wheels.twist
        velocity = np.array([vx - turn * centre[1], vy + turn * centre[0]])
        return Scene(
            grid=self.grid,
            robot_position=transform(wheels.pose, centre),
            robot_velocity=transform([0.0, 0.0, wheels.pose[2]], velocity),
            robot_radius=float(np.hypot(*(robot.outline - centre).T).max()),
            time=self._now,
        )

    def _sense(self, time: float, before: Crowd, after: Crowd, share: float) -> Sensed:
        """The sweeps due at ``time``, a share of a control step after ``before``."""
        there = before.there & after.there
        way = np.hypot(*went(before, after).T)
        bodies = Bodies(
            position=between(before, after, share)[there],
            heading=after.heading[there],
            walked=(self._walked + share * way)[there],
            speed=way[there] / self.setup.control_step,
            height=self._statures[there],
            radius=before.radius[there],
        )
        return self._senses.sense(time, self._scenery, bodies, self._wheels.pose)

    def _told(self, sensed: Sensed, last: Observation | None) -> Observation:
        setup, truth = self.setup, self._truth
        self._act = setup.rider.act(self._seen_by_rider(), self._remembered, self._random["rider"])
        observation = Observation(
            time=truth.time,
            # along the start's heading, so that a rotated world has the same ride rotated
            pose=with_error(truth.pose, self._error, axis=setup.start[2]),
            pose_time=truth.time,
            twist=setup.odometry.measure(truth.twist, self._random["odometry"]),
            twist_time=truth.time,
            scans=sensed.scans,
            clouds=sensed.clouds,
            rider=self._act.command,
            people=_known_exactly(truth) if setup.give_people else None,
        )
        return with_faults(observation, setup.faults, last)

    @property
    def _remembered(self) -> Any | None:
        return self._act.memory if self._act is not None else None

    def _seen_by_rider(self) -> RiderView:
        setup, truth = self.setup, self._truth
        people, bearings, free = seen_by(setup.rider, self.grid, truth.pose, truth.crowd)
        return RiderView(
            time=truth.time,
            pose=truth.pose,
            twist=truth.twist,
            goal=setup.rider_goal,
            route=setup.rider_route,
            people=people,
            bearings=bearings,
            free=free,
            outline=setup.robot.outline,
        )


def is_standing(twist: Floats) -> Booleans:
    """Which twists (..., 3) stand still, neither moving nor turning; (...,)."""
    moves = np.hypot(twist[..., 0], twist[..., 1]) >= STANDING
    turns = np.abs(twist[..., 2]) >= STANDING_TURN
    still: Booleans = ~(moves | turns)
    return still


def nobody_touched(crowd: Crowd) -> Booleans:
    """(2, n) False: touched while the chair moved, touched while it stood."""
    return np.zeros((2, len(crowd.radius)), dtype=bool)


def _swept(robot: Robot, old: Wheels, new: Wheels) -> float:
    """A bound on how far any point of the footprint has moved, m."""
    dx, dy, _ = new.pose - old.pose
    turn = abs(math.remainder(new.pose[2] - old.pose[2], 2.0 * math.pi))
    return math.hypot(dx, dy) + turn * robot.circumscribed_radius


def _known_exactly(truth: Truth) -> People:
    crowd, who = truth.crowd, np.flatnonzero(truth.crowd.there)
    n = len(who)
    return People(
        time=truth.time,
        id=who,
        mean=np.column_stack([crowd.position, crowd.velocity])[who],
        covariance=np.zeros((n, 4, 4)),
        heading=crowd.heading[who],
        radius=crowd.radius[who],
        confidence=np.ones(n),
        source="simulation",
    )
