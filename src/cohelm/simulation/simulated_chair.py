"""Chair of a simulated world: its motion and contacts, and the planar one."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Protocol

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Shape, replace, value
from cohelm.maps import OccupancyGrid
from cohelm.messages import Inertial
from cohelm.robots import Robot
from cohelm.simulation.api import Crowd
from cohelm.simulation.contact import gap_to_people, gap_to_walls
from cohelm.simulation.crowds.motion import displacement, interpolated
from cohelm.simulation.drivetrain import DriveCommand, at_rest, step_drivetrain
from cohelm.simulation.ground_truth import Touch, is_standing
from cohelm.simulation.sensing import Casting, PlanarCasting
from cohelm.simulation.sensors.human_bodies import HumanBodies
from cohelm.simulation.sensors.static_scene import StaticScene

Grip = Callable[[Floats], Floats]
"""Twist (3,) of the chair for that of its motors."""
_ROUNDING = 1e-6
"""Bound on the rounding error of a gap, m."""


@value
class CrowdStep:
    """People and obstacles of one control step."""

    before: Crowd
    after: Crowd
    people: Callable[[float], HumanBodies]
    """Bodies of all n people after a share of the step; those absent are far away."""
    grid: OccupancyGrid
    """True obstacles."""
    gap_people: Annotated[Floats, Shape("n")]
    """Gap at the beginning, m."""
    gap_wall: float
    """Gap at the beginning, m; 0: unknown."""


@value
class Contacts:
    """Contacts of one control step, and people after it."""

    hit_moving: Annotated[Booleans, Shape("n")]
    hit_standing: Annotated[Booleans, Shape("n")]
    hit_wall: bool
    after: Crowd
    """Crowd after the step; contacts may have moved it."""
    fell: bool = False
    """A wheel dropped farther than the chair may step down."""
    touches: tuple[Touch, ...] = ()
    """Contacts with measured forces."""


class SimulatedChair(Protocol):
    """Chair that a world advances; the world owns it, and nothing else changes it."""

    @property
    def pose(self) -> Floats:
        """True X_MR, (3,)."""
        ...

    @property
    def twist(self) -> Floats:
        """True twist, (3,), robot frame."""
        ...

    @property
    def wheel_twist(self) -> Floats:
        """Twist (3,) by the wheels' speeds, as exact encoders measure it."""
        ...

    @property
    def inertial(self) -> Inertial | None:
        """Reading of the inertial unit now; None: the chair has none."""
        ...

    def branch(self) -> SimulatedChair:
        """Copy that moves by itself, between two control steps."""
        ...

    def carry(self, pose: Floats) -> None:
        """Put the chair elsewhere, in motion as before."""
        ...

    def begin(self, step: CrowdStep) -> None:
        """Begin a control step."""
        ...

    def move(self, command: DriveCommand, dt: float, share: float, grip: Grip) -> None:
        """Move for ``dt``, s, to a share of the control step."""
        ...

    def casting(self, scene: StaticScene, bodies: HumanBodies, visible: Booleans) -> Casting:
        """Return the rays of the sensors now.

        Args:
            scene: true obstacles.
            bodies: true people who can be seen.
            visible: (n,) mask of them among all people.
        """
        ...

    def end(self) -> Contacts:
        """End the control step."""
        ...


class PlanarChair:
    """Point with limits and lag that carries a rigid footprint.

    Args:
        robot: limits, lag and footprint.
        start: (3,) X_MR at time 0.
    """

    def __init__(self, robot: Robot, start: Floats) -> None:
        self._robot = robot
        self._drive = at_rest(robot, start)

    @property
    def pose(self) -> Floats:
        """See :class:`SimulatedChair`."""
        return self._drive.pose

    @property
    def twist(self) -> Floats:
        """See :class:`SimulatedChair`."""
        return self._drive.twist

    @property
    def wheel_twist(self) -> Floats:
        """See :class:`SimulatedChair`: no wheel slips."""
        return self._drive.twist

    @property
    def inertial(self) -> Inertial | None:
        """See :class:`SimulatedChair`: a planar chair has no forces to feel."""
        return None

    def branch(self) -> PlanarChair:
        """See :class:`SimulatedChair`; all that changes is a value."""
        return copy.copy(self)

    def carry(self, pose: Floats) -> None:
        """See :class:`SimulatedChair`."""
        self._drive = replace(self._drive, pose=pose)

    def begin(self, step: CrowdStep) -> None:
        """Begin with lower bounds of the gaps: exact ones are computed when a bound is used up."""
        before, after = step.before, step.after
        self._step, self._there = step, before.there & after.there
        walked = np.hypot(*displacement(before, after).T)
        self._people_gap = float((step.gap_people - walked).min(initial=np.inf))
        self._wall_gap = step.gap_wall
        self._hits = np.zeros((2, len(before.radius)), dtype=np.bool_)
        self._hit_wall = False

    def move(self, command: DriveCommand, dt: float, share: float, grip: Grip) -> None:
        """See :class:`SimulatedChair`."""
        robot, old, step = self._robot, self._drive, self._step
        self._drive = step_drivetrain(robot, old, command, dt, grip)
        moved = _max_motion(robot, old.pose, self._drive.pose)
        self._people_gap -= moved
        self._wall_gap -= moved
        if self._people_gap <= _ROUNDING:
            position = interpolated(step.before, step.after, share)
            gaps = gap_to_people(robot.outline, self._drive.pose, position, step.before.radius)
            self._hits[int(is_standing(self._drive.twist))] |= self._there & (gaps <= 0.0)
        if self._wall_gap <= 0.0:
            self._wall_gap = gap_to_walls(robot.outline, self._drive.pose, step.grid)
            self._hit_wall |= self._wall_gap <= 0.0

    def casting(self, scene: StaticScene, bodies: HumanBodies, visible: Booleans) -> Casting:
        """See :class:`SimulatedChair`."""
        return PlanarCasting(scene=scene, bodies=bodies, X_MR=self._drive.pose)

    def end(self) -> Contacts:
        """See :class:`SimulatedChair`."""
        return Contacts(
            hit_moving=self._hits[0],
            hit_standing=self._hits[1],
            hit_wall=self._hit_wall,
            after=self._step.after,
        )


def _max_motion(robot: Robot, old: Floats, new: Floats) -> float:
    """Upper bound of the motion of any point of the footprint between two poses, m."""
    dx, dy, _ = new - old
    turn = abs(math.remainder(new[2] - old[2], 2.0 * math.pi))
    return math.hypot(dx, dy) + turn * robot.circumscribed_radius
