"""What a true world is made of."""

from __future__ import annotations

import math

from cohelm.arrays import Annotated, Floats, Floats32, Shape, value
from cohelm.maps import OccupancyGrid
from cohelm.robots import Robot
from cohelm.simulation.api import Crowd, PedestrianModel, Rider
from cohelm.simulation.changes import Change
from cohelm.simulation.doorways import Doorway
from cohelm.simulation.faults import Fault
from cohelm.simulation.sensors.localisation import Localisation, Odometry


@value
class WorldSetup:
    """Everything that makes a world, but for chance."""

    grid: OccupancyGrid
    """What truly stands there at time 0."""
    changes: tuple[Change, ...] = ()
    """What stands there later, in the order of their times."""
    heights: Annotated[Floats32, Shape("rows cols")] | None = None
    """Of what stands or will stand on the grid's cells, m, for 3-D sensors; see ``Scenery``."""
    wall_height: float = 2.5
    """m."""
    ceiling: float = math.inf
    """Its height, m; +inf: there is none."""
    robot: Robot
    start: Annotated[Floats, Shape("3")]
    """X_MR at time 0."""
    crowd: Crowd
    """The people at time 0."""
    statures: Annotated[Floats, Shape("n")] | None = None
    """Their heights, m, for 3-D sensors; None: 1.7 m each."""
    pedestrian_model: PedestrianModel
    rider: Rider
    rider_goal: Annotated[Floats, Shape("2")]
    """Where the rider wants to go, m."""
    rider_route: Annotated[Floats, Shape("k 2")]
    """By which way, m; empty: straight."""
    localisation: Localisation = Localisation()
    odometry: Odometry = Odometry()
    control_step: float = 0.05
    """From decision to decision, s."""
    physics_step: float = 0.01
    """At most; a whole number of them makes a control step, s."""
    give_people: bool = False
    """Whether the observation says where people truly are."""
    faults: tuple[Fault, ...] = ()
    doors: tuple[Doorway, ...] = ()
    """Those that can be shut by hand, see :meth:`.world.World.set_door`; open at first."""
