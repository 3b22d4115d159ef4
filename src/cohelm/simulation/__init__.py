"""The simulator: a true world, people, sensors and riders. It never meets the navigator."""

from cohelm.simulation.api import Crowd, PedestrianModel, Rider, RiderAct, RiderView, Scene
from cohelm.simulation.chance import generator
from cohelm.simulation.changes import Change
from cohelm.simulation.crowds import Aggressive, Distracted, Inattentive, Orca, SocialForce, entered
from cohelm.simulation.doorways import Doorway
from cohelm.simulation.faults import Fault
from cohelm.simulation.newcomers import Newcomer
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
from cohelm.simulation.setting import WorldSetup
from cohelm.simulation.world import Truth, World, is_standing

__all__ = [
    "Aggressive",
    "Biased",
    "Change",
    "Crowd",
    "Delayed",
    "Distracted",
    "Doorway",
    "Dropout",
    "Fault",
    "Ideal",
    "Idle",
    "Inattentive",
    "Laggy",
    "Localisation",
    "Newcomer",
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
