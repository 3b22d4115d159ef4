"""The simulator: a true world, people, sensors and riders. It never meets the navigator."""

from cohelm.simulation.api import Crowd, PedestrianModel, Rider, RiderView, Scene
from cohelm.simulation.chance import generator
from cohelm.simulation.changes import Change
from cohelm.simulation.crowds import Orca
from cohelm.simulation.faults import Fault
from cohelm.simulation.riders import Ideal, Idle, NoRider, Nudge
from cohelm.simulation.sensors import Localisation, Odometry
from cohelm.simulation.world import Truth, World, WorldSetup, is_standing

__all__ = [
    "Change",
    "Crowd",
    "Fault",
    "Ideal",
    "Idle",
    "Localisation",
    "NoRider",
    "Nudge",
    "Odometry",
    "Orca",
    "PedestrianModel",
    "Rider",
    "RiderView",
    "Scene",
    "Truth",
    "World",
    "WorldSetup",
    "generator",
    "is_standing",
]
