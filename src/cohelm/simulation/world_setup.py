"""Setup of a simulated world."""

from __future__ import annotations

import math

from cohelm.arrays import Annotated, Floats, Floats32, Integers, Shape, value
from cohelm.maps import OccupancyGrid
from cohelm.robots import Robot
from cohelm.simulation.api import Crowd, PedestrianModel, Rider
from cohelm.simulation.dynamic_objects import ManualDoor, MapChange
from cohelm.simulation.faults import Fault
from cohelm.simulation.floor_relief import FLAT, FloorRelief
from cohelm.simulation.sensors.localisation import Localisation, Odometry
from cohelm.simulation.split_knowledge import GoalChange, SplitCells


@value
class WorldSetup:
    """Everything that defines a world, except for the seed."""

    grid: OccupancyGrid
    """True obstacles at time 0."""
    changes: tuple[MapChange, ...] = ()
    """Later obstacles, in the order of their times."""
    heights: Annotated[Floats32, Shape("rows cols")] | None = None
    """Heights of all obstacles of the ride, m, for 3-D sensors; see ``StaticScene``."""
    wall_height: float = 2.5
    """m."""
    ceiling: float = math.inf
    """Height of the ceiling, m; +inf: none."""
    relief: FloorRelief = FLAT
    """Ramp and thresholds, for worlds with wheels."""
    robot: Robot
    start: Annotated[Floats, Shape("3")]
    """X_MR at time 0."""
    crowd: Crowd
    """People at time 0."""
    statures: Annotated[Floats, Shape("n")] | None = None
    """Their heights, m, for 3-D sensors; None: 1.7 m each."""
    kinds: Annotated[Integers, Shape("n")] | None = None
    """Their outlines in planar scans, a ``BodyKind`` each; None: discs."""
    pedestrian_model: PedestrianModel
    rider: Rider
    rider_goal: Annotated[Floats, Shape("2")]
    """Destination of the rider, m."""
    rider_route: Annotated[Floats, Shape("k 2")]
    """Desired route of the rider, m; empty: straight to the destination."""
    goal_change: GoalChange | None = None
    """Destination that the rider decides for on the way."""
    split: SplitCells | None = None
    """Cells that rider and chair see differently; None: none."""
    localisation: Localisation = Localisation()
    odometry: Odometry = Odometry()
    control_step: float = 0.05
    """Time between decisions, s."""
    physics_step: float = 0.01
    """Upper bound, s; a control step is a whole number of them."""
    give_people: bool = False
    """Put the true people into the observation."""
    faults: tuple[Fault, ...] = ()
    doors: tuple[ManualDoor, ...] = ()
    """Doors for :meth:`.world.World.set_door`; open at first."""

    @property
    def last_goal(self) -> Floats:
        """Destination (2,) of the rider in the end, m."""
        return self.rider_goal if self.goal_change is None else self.goal_change.goal
