"""The simulator: a true world, people, sensors and riders. It never meets the navigator."""

from cohelm.simulation.api import Crowd, PedestrianModel, Rider, RiderAct, RiderView, Scene
from cohelm.simulation.chance import generator
from cohelm.simulation.changes import Change
from cohelm.simulation.crowds import Aggressive, Distracted, Inattentive, Orca, SocialForce, entered
from cohelm.simulation.faults import Fault
from cohelm.simulation.riders import (
    Biased,
    Delayed,
    Dropout,
    Ideal,
    Idle,
    Laggy,
    Noisy,
    NoRider,
    Nudge,
    OneSwitch,
    Reluctant,
    Tremor,
    Uncooperative,
    Watchful,
)
from cohelm.simulation.sensors import Localisation, Odometry
from cohelm.simulation.world import Truth, World, WorldSetup, is_standing

__all__ = [
    "Aggressive",
    "Biased",
    "Change",
    "Crowd",
    "Delayed",
    "Distracted",
    "Dropout",
    "Fault",
    "Ideal",
    "Idle",
    "Inattentive",
    "Laggy",
    "Localisation",
    "NoRider",
    "Noisy",
    "Nudge",
    "Odometry",
    "OneSwitch",
    "Orca",
    "PedestrianModel",
    "Reluctant",
    "Rider",
    "RiderAct",
    "RiderView",
    "Scene",
    "SocialForce",
    "Tremor",
    "Truth",
    "Uncooperative",
    "Watchful",
    "World",
    "WorldSetup",
    "entered",
    "generator",
    "is_standing",
]
